// Low-discrepancy points for camera and ambient rays.
// Based on: J. Hammersley point set (radical inverse in base 2); R. Cranley, T. Patterson,
// "Randomization of Number Theoretic Methods for Multiple Integration", 1976 (the shift).
#pragma once

#include <cmath>
#include <cstdint>

#include "sinew/math/random.h"
#include "sinew/math/vec.h"

namespace sinew {

inline uint32_t reverse_bits(uint32_t x) {
  x = (x << 16) | (x >> 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
  x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
  return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// Point i of n in the unit square, one a row and (n a power of two) one a column, cell-centred:
// the centre itself for n = 1.
inline vec2 hammersley(uint32_t i, uint32_t n) {
  uint32_t cells = 1;  // columns of the radical inverse: the power of two from n up
  while (cells < n) cells *= 2;
  return vec2((static_cast<float>(i) + 0.5f) / static_cast<float>(n),
              unit_float(reverse_bits(i)) + 0.5f / static_cast<float>(cells));
}

// The point shifted on the torus by a hash, so that pixels use different sets.
inline vec2 shifted(vec2 p, uint32_t hash) {
  p += vec2(unit_float(hash), unit_float(hash_u32(hash ^ 0x9e3779b9u)));
  return p - floor(p);
}

// Direction about the unit vector n with density cos / pi.
// Based on: T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
inline vec3 cosine_direction(vec3 n, vec2 p) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
  const vec3 tangent(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
  const vec3 bitangent(b, sign + n.y * n.y * a, -n.y);
  const float r = std::sqrt(p.x), phi = 6.28318531f * p.y;
  return tangent * (r * std::cos(phi)) + bitangent * (r * std::sin(phi)) +
         n * std::sqrt(std::fmax(0.0f, 1.0f - p.x));
}

}  // namespace sinew
