// Small arithmetic of one brick: its level 1, and its colours.
#pragma once

#include <algorithm>
#include <cmath>

#include "sinew/svo/format.h"

namespace sinew {

// The level 1 bits of a brick with these voxels: bit x + 4 y + 16 z, 0 or 1 each.
inline uint64_t coarse_of_brick(uint64_t voxels) {
  // Each 2^3 voxels are gathered in the first of them; then these move together along x, y and z.
  voxels |= voxels >> 1;
  voxels |= voxels >> 4;
  voxels |= voxels >> 16;
  voxels &= 0x0000050500000505u;
  voxels = (voxels | voxels >> 1) & 0x0000030300000303u;
  voxels = (voxels | voxels >> 4) & 0x0000003300000033u;
  return (voxels | voxels >> 16) & 0x0000000000330033u;
}
inline uint32_t coarse_shift(uint32_t brick) {
  return 2 * (brick & 1) + 8 * (brick >> 1 & 1) + 32 * (brick >> 2);
}

// The brick that holds a bit of level 1, and the first of that bit's voxels in it, of which there
// may be more at kEight << first.
inline constexpr uint64_t kEight = 0x0000000000330033u;
inline uint32_t brick_above(uint32_t bit) {
  return (bit >> 1 & 1) + (bit >> 2 & 2) + (bit >> 3 & 4);
}
inline uint32_t first_below(uint32_t bit) {
  return 2 * (bit & 1) + 8 * (bit >> 2 & 1) + 32 * (bit >> 4 & 1);
}

// unpack_normal(), inlined.
inline vec3 unit_normal(uint16_t packed) {
  const float x = static_cast<float>(static_cast<int>(packed & 255) - 127);
  const float y = static_cast<float>(static_cast<int>(packed >> 8) - 127);
  const float z = 127.0f - std::abs(x) - std::abs(y);
  const float fold = std::max(-z, 0.0f);
  const vec3 d(x - std::copysign(fold, x), y - std::copysign(fold, y), z);
  return d * (1.0f / std::sqrt(dot(d, d)));
}

// Length of the mean of `count` unit normals whose sum has this length. What is 1 but for rounding
// is 1: sharp materials shine otherwise where normals spread at all.
inline float mean_length(float sum, float count) {
  const float mean = sum / count;
  return mean > 1.0f - 1e-6f ? 1.0f : mean;
}

// Square roots of a packed colour's linear values.
inline vec3 color_root(uint16_t packed) {
  return vec3(static_cast<float>(packed >> 11) * (1.0f / 31.0f),
              static_cast<float>(packed >> 5 & 63) * (1.0f / 63.0f),
              static_cast<float>(packed & 31) * (1.0f / 31.0f));
}

// Linear.
inline vec3 selected_color(SvoColorEnds ends, uint32_t selector) {
  const vec3 a = color_root(ends.a), b = color_root(ends.b);
  const vec3 root = a + (static_cast<float>(selector) * (1.0f / 3.0f)) * (b - a);
  return root * root;
}

// Ends for the packed colours of a brick's voxels, 1 to 64, and a selector for each.
void fit_colors(const uint16_t* colors, uint32_t count, SvoColorEnds& ends, uint8_t* selectors);

}  // namespace sinew
