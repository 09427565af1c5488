// Rays and hits, as callers see them.
#pragma once

#include <cstdint>
#include <limits>

#include "sinew/math/vec.h"

namespace sinew {

// The points origin + t * direction for t in [t_min, t_max], t_min >= 0. The direction need not
// have unit length; t is measured in units of it.
struct Ray {
  vec3 origin{0.0f};
  float t_min = 0.0f;
  vec3 direction{0.0f, 0.0f, -1.0f};
  float t_max = std::numeric_limits<float>::infinity();
};
static_assert(sizeof(Ray) == 32);

inline constexpr uint32_t kNoObject = 0xffffffffu;

// Where a ray meets a triangle (v0, v1, v2): at (1 - u - v) * v0 + u * v1 + v * v2.
// Of several hits at the same t, the one with the least (object, primitive) counts.
struct Hit {
  float t = std::numeric_limits<float>::infinity();
  float u = 0.0f;
  float v = 0.0f;
  uint32_t primitive = 0;       // index of the triangle in its mesh
  uint32_t object = kNoObject;  // kNoObject: the ray met nothing

  explicit operator bool() const { return object != kNoObject; }
};
static_assert(sizeof(Hit) == 20);

}  // namespace sinew
