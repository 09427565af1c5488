// Which objects of a scene are the same body, so that they share a tree.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/scene/scene.h"

namespace sinew {

struct SceneBody {
  uint32_t mesh = 0;
  bool skinned = false;
  std::vector<uint32_t> objects;  // at least one, rising
};

// By mesh and whether it is skinned; in the order of their first objects.
std::vector<SceneBody> scene_bodies(const Scene& scene);

}  // namespace sinew
