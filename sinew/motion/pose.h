// What one object looks like at one instant: the numbers that a Motion turns into positions.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/math/affine.h"

namespace sinew {

// A range of vertices. The default is all that there are.
struct VertexRange {
  uint32_t first = 0;
  uint32_t count = 0xffffffffu;
};

// A view: the spans belong to whoever sampled the pose (see scene/sample.h) and must live until the
// next update. A motion reads only its own fields.
struct Pose {
  Affine placement = identity_affine();  // object -> world; identity for skinned objects
  std::span<const Affine> joints;        // skin: joint matrices, rest -> world
  std::span<const float> weights;        // morph: one a target
  uint32_t key = 0;                      // keyframes: between sample key and key + 1
  float key_fraction = 0.0f;             // keyframes: 0 at key, 1 at key + 1
  std::span<const vec3> positions;       // free: the vertices of this frame
  VertexRange changed;                   // free: outside it they are as in the pose before
  bool present = true;                   // false: the object is not there in this frame
};

}  // namespace sinew
