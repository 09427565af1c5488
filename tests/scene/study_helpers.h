// What tests of study scenes ask of a scene.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sinew/scene/sample.h"

namespace sinew {

// The object whose mesh has this name.
inline uint32_t object_of(const Scene& scene, const std::string& mesh) {
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.meshes[scene.objects[i].mesh].name == mesh) return i;
  }
  ADD_FAILURE() << mesh;
  return 0;
}

// Where its vertices are, in the world.
inline std::vector<vec3> positions_at(const Scene& scene, int clip, double time, uint32_t object) {
  ScenePose pose;
  sample(scene, clip, time, pose);
  std::vector<vec3> positions(scene.meshes[scene.objects[object].mesh].positions.size());
  world_positions(scene, pose, object, positions);
  return positions;
}

}  // namespace sinew
