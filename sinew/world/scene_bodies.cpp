#include "sinew/world/scene_bodies.h"

#include <map>

namespace sinew {

std::vector<SceneBody> scene_bodies(const Scene& scene) {
  std::vector<SceneBody> bodies;
  std::map<std::pair<uint32_t, bool>, size_t> places;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const bool skinned = object.skin >= 0;
    const auto [place, is_new] = places.try_emplace({object.mesh, skinned}, bodies.size());
    if (is_new) bodies.push_back({object.mesh, skinned, {}});
    bodies[place->second].objects.push_back(i);
  }
  return bodies;
}

}  // namespace sinew
