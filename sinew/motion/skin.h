// One vertex of a SkinMotion: the joints' matrices are blended, then the point is mapped once.
// Based on: glTF 2.0 specification, section 3.7.3.3 (skinned mesh attributes).
// Four lanes work on one vertex with the compiler's own vectors (GCC's and Clang's vector_size), so
// that the function inlines into every loop; the scalar formula, with the same bits, takes twice
// the time.
#pragma once

#include <cstring>

#include "sinew/motion/motion.h"

namespace sinew {

using Float4 = float __attribute__((vector_size(16)));

inline Float4 load4(const float* values) {
  Float4 out;
  std::memcpy(&out, values, sizeof out);
  return out;
}

// An Affine as it lies in memory, four floats a vector; its columns are x, y, z, t:
//   a = x.x x.y x.z y.x    b = y.y y.z z.x z.y    c = z.z t.x t.y t.z
struct PackedAffine {
  Float4 a{}, b{}, c{};
};
static_assert(sizeof(PackedAffine) == sizeof(Affine));

// sum_k weight_k * joints[index_k], in the order of k, from zero. Unused influences are added like
// all others: 0 * a finite matrix changes nothing, and a branch on the weight costs twice the time
// because it is never predicted well.
inline PackedAffine blend_joints(const SkinMotion& skin, const Pose& pose, uint32_t vertex) {
  PackedAffine sum;
  const size_t begin = size_t{vertex} * skin.influences;
  for (size_t k = begin; k < begin + skin.influences; ++k) {
    const float weight = skin.weights[k];
    const float* const joint = &pose.joints[skin.joints[k]][0].x;
    sum.a += weight * load4(joint);
    sum.b += weight * load4(joint + 4);
    sum.c += weight * load4(joint + 8);
  }
  return sum;
}

inline mat3 linear_part(const PackedAffine& m) {
  return mat3(m.a[0], m.a[1], m.a[2], m.a[3], m.b[0], m.b[1], m.b[2], m.b[3], m.c[0]);
}

inline vec3 transform_point(const PackedAffine& m, vec3 p) {
  const Float4 y = __builtin_shufflevector(m.a, m.b, 3, 4, 5, 5);
  const Float4 z = __builtin_shufflevector(m.b, m.c, 2, 3, 4, 4);
  const Float4 t = __builtin_shufflevector(m.c, m.c, 1, 2, 3, 3);
  const Float4 image = m.a * p.x + y * p.y + z * p.z + t;
  return vec3(image[0], image[1], image[2]);
}

// Where the skin takes a vertex that rests, or was morphed to, `p`.
inline vec3 skin_point(const SkinMotion& skin, const Pose& pose, uint32_t vertex, vec3 p) {
  return transform_point(blend_joints(skin, pose, vertex), p);
}

inline vec3 position(const SkinMotion& skin, const Pose& pose, uint32_t vertex) {
  return skin_point(skin, pose, vertex, skin.rest[vertex]);
}

}  // namespace sinew
