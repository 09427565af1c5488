#include "app/hide.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>

namespace sinew::app {
namespace {

constexpr size_t kListed = 20;  // names in the error message

bool fits(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

// Then the node is no object any more; what hangs below it stays.
void remove_mesh(Node& node) {
  node.mesh = -1;
  node.skin = -1;
  node.weights.clear();
}

std::string list_names(const Scene& scene) {
  std::string list;
  const size_t count = std::min(kListed, scene.objects.size());
  for (size_t i = 0; i < count; ++i) {
    list += (i > 0 ? ", " : "") + scene.nodes[scene.objects[i].node].name;
  }
  return scene.objects.size() > count ? list + ", ..." : list;
}

}  // namespace

Result<void> hide_objects(Scene& scene, const std::vector<std::string>& patterns) {
  std::vector<uint8_t> hidden(scene.objects.size(), 0);
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      const SceneObject& object = scene.objects[i];
      if (!fits(pattern, scene.nodes[object.node].name) &&
          !fits(pattern, scene.meshes[object.mesh].name)) {
        continue;
      }
      hidden[i] = 1;
      found = true;
    }
    if (!found) {
      return fail({ErrorKind::usage, scene.name, "",
                   fmt::format("--hide '{}' fits no object", pattern),
                   "the objects are " + list_names(scene)});
    }
  }
  for (size_t i = 0; i < hidden.size(); ++i) {
    if (hidden[i]) remove_mesh(scene.nodes[scene.objects[i].node]);
  }
  for (Clip& clip : scene.clips) {
    std::erase_if(clip.channels, [&](const Channel& channel) {
      const bool of_mesh =
          channel.path == ChannelPath::weights || channel.path == ChannelPath::cache_key;
      return of_mesh && scene.nodes[channel.node].mesh < 0;
    });
  }
  list_objects(scene);
  return {};
}

}  // namespace sinew::app
