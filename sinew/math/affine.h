// Affine maps of 3-space: three axis columns and a translation, 48 bytes.
#pragma once

#include <cmath>

#include "sinew/math/vec.h"

namespace sinew {

// Column-major 3x4: columns 0..2 are the images of the axes, column 3 is the translation.
using Affine = glm::mat4x3;
static_assert(sizeof(Affine) == 48);

inline Affine identity_affine() {
  return Affine(1.0f);
}

inline vec3 transform_point(const Affine& m, vec3 p) {
  return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}
inline vec3 transform_vector(const Affine& m, vec3 v) {
  return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}
inline mat3 linear_part(const Affine& m) {
  return mat3(m[0], m[1], m[2]);
}

// a after b.
inline Affine compose(const Affine& a, const Affine& b) {
  return Affine(transform_vector(a, b[0]), transform_vector(a, b[1]), transform_vector(a, b[2]),
                transform_point(a, b[3]));
}

// Maps normals (up to length): the cofactor matrix, defined for singular maps too. It carries the
// sign of the determinant, so mirrored maps keep normals on the outside.
inline mat3 cofactor(const Affine& m) {
  return mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
}

// Computed in double. Meaningless if determinant is 0; ask is_singular first.
inline Affine inverse_affine(const Affine& m) {
  const glm::dmat3 inverse_linear = glm::inverse(glm::dmat3(linear_part(m)));
  const glm::dvec3 translation = -(inverse_linear * glm::dvec3(m[3]));
  return Affine(vec3(inverse_linear[0]), vec3(inverse_linear[1]), vec3(inverse_linear[2]),
                vec3(translation));
}

// True if the map flattens space or holds a value that is not finite, so rays cannot be carried
// back through it.
inline bool is_singular(const Affine& m) {
  const glm::dmat3 l(linear_part(m));
  const double scale = length(l[0]) * length(l[1]) * length(l[2]);
  const double det = std::abs(glm::determinant(l));
  return !(det > 1e-12 * scale) || !(det > 1e-60) || !std::isfinite(scale) ||
         !std::isfinite(m[3].x + m[3].y + m[3].z);
}

inline Affine trs(vec3 translation, quat rotation, vec3 scale) {
  const mat3 r = glm::mat3_cast(rotation);
  return Affine(r[0] * scale.x, r[1] * scale.y, r[2] * scale.z, translation);
}

}  // namespace sinew
