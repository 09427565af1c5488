// Small deterministic random numbers for tests, sampling and procedural scenes.
// Based on: M. O'Neill, "PCG: A family of simple fast space-efficient statistically good
// algorithms for random number generation", 2014 (the RXS-M-XS 32-bit output as a hash).
#pragma once

#include <cmath>
#include <cstdint>

#include "sinew/math/vec.h"

namespace sinew {

inline uint32_t hash_u32(uint32_t x) {
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}
inline uint32_t hash_combine(uint32_t a, uint32_t b) {
  return hash_u32(a ^ hash_u32(b));
}

// [0, 1)
inline float unit_float(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

struct Random {
  uint32_t state = 1;
  explicit Random(uint32_t seed) : state(hash_u32(seed)) {}

  uint32_t next() {
    state = state * 747796405u + 2891336453u;
    uint32_t x = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (x >> 22u) ^ x;
  }
  float uniform() { return unit_float(next()); }  // [0, 1)
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  vec3 uniform3(float low, float high) {
    const float x = uniform(low, high), y = uniform(low, high), z = uniform(low, high);
    return vec3(x, y, z);
  }
  vec3 direction() {  // uniform on the unit sphere
    const float z = uniform(-1.0f, 1.0f), phi = uniform(0.0f, 6.28318531f);
    const float r = std::sqrt(std::fmax(0.0f, 1.0f - z * z));
    return vec3(r * std::cos(phi), r * std::sin(phi), z);
  }
};

}  // namespace sinew
