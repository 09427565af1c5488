// Axis-aligned boxes.
#pragma once

#include <cmath>
#include <limits>

#include "sinew/math/affine.h"
#include "sinew/math/vec.h"

namespace sinew {

struct Box {
  vec3 min{std::numeric_limits<float>::infinity()};
  vec3 max{-std::numeric_limits<float>::infinity()};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  void extend(vec3 p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  void extend(const Box& b) {
    min = glm::min(min, b.min);
    max = glm::max(max, b.max);
  }
  bool contains(vec3 p) const {
    return glm::all(glm::greaterThanEqual(p, min)) && glm::all(glm::lessThanEqual(p, max));
  }
  bool contains(const Box& b) const { return b.empty() || (contains(b.min) && contains(b.max)); }
  vec3 center() const { return 0.5f * (min + max); }
  vec3 extent() const { return max - min; }
};
static_assert(sizeof(Box) == 24);

// No coordinate is NaN or infinite.
inline bool is_finite(const Box& b) {
  const vec3 sum = b.min + b.max;  // a NaN or infinity stays in it
  return std::isfinite(sum.x) && std::isfinite(sum.y) && std::isfinite(sum.z);
}

// Half the surface area; 0 for an empty box.
inline float half_area(const Box& b) {
  if (b.empty()) return 0.0f;
  const vec3 e = b.extent();
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

// Contains the image of the box as float arithmetic computes it: the eight mapped corners, widened
// by the rounding of any transform_point of a point inside.
inline Box transform_box(const Affine& m, const Box& b) {
  if (b.empty()) return b;
  Box out;
  for (int i = 0; i < 8; ++i) {
    out.extend(transform_point(
        m, vec3(i & 1 ? b.max.x : b.min.x, i & 2 ? b.max.y : b.min.y, i & 4 ? b.max.z : b.min.z)));
  }
  // Four roundings a coordinate (three products, summed with the translation), twice: for the
  // corners and for the point.
  constexpr float kGamma = 8.0f * 5.97e-8f;
  const vec3 reach = glm::max(glm::abs(b.min), glm::abs(b.max));
  const vec3 pad = kGamma * (glm::abs(m[0]) * reach.x + glm::abs(m[1]) * reach.y +
                             glm::abs(m[2]) * reach.z + glm::abs(m[3]));
  out.min -= pad;
  out.max += pad;
  return out;
}

}  // namespace sinew
