#include "sinew/io/gltf/affine.h"

#include <algorithm>
#include <cmath>

namespace sinew::gltf {
namespace {

// Turns columns p and q of `a` until they are orthogonal, and those of `v` with them. True if there
// was something to do.
bool make_orthogonal(glm::dmat3& a, glm::dmat3& v, int p, int q) {
  constexpr double kCosine = 1e-15;
  const double pp = dot(a[p], a[p]), qq = dot(a[q], a[q]), pq = dot(a[p], a[q]);
  if (!(std::abs(pq) > kCosine * std::sqrt(pp * qq))) return false;
  const double zeta = (qq - pp) / (2.0 * pq);
  const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
  const double c = 1.0 / std::sqrt(1.0 + t * t), s = c * t;
  for (glm::dmat3* m : {&a, &v}) {
    const glm::dvec3 column = (*m)[p];
    (*m)[p] = c * column - s * (*m)[q];
    (*m)[q] = s * column + c * (*m)[q];
  }
  return true;
}

// Unit columns along those of `a`, in its order; where `a` has none, any that make a rotation.
glm::dmat3 complete_rotation(const glm::dmat3& a, const glm::dvec3& lengths) {
  const double tiny = 1e-14 * std::max({lengths.x, lengths.y, lengths.z});
  glm::dmat3 u(0.0);
  bool known[3];
  for (int k = 0; k < 3; ++k) {
    known[k] = lengths[k] > tiny;
    if (known[k]) u[k] = a[k] / lengths[k];
  }
  for (int k = 0; k < 3; ++k) {
    if (known[k]) continue;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    if (known[i] && known[j]) {
      u[k] = cross(u[i], u[j]);
    } else {
      const glm::dvec3 other = known[i] ? u[i] : known[j] ? u[j] : glm::dvec3(0.0);
      const int axis = std::abs(other.x) < 0.5 ? 0 : std::abs(other.y) < 0.5 ? 1 : 2;
      glm::dvec3 direction(0.0);
      direction[axis] = 1.0;
      u[k] = normalize(direction - dot(direction, other) * other);
    }
    known[k] = true;
  }
  return u;
}

}  // namespace

std::optional<Affine> affine_of(std::span<const float> m) {
  constexpr float kTolerance = 1e-5f;
  const bool affine = std::abs(m[3]) <= kTolerance && std::abs(m[7]) <= kTolerance &&
                      std::abs(m[11]) <= kTolerance && std::abs(m[15] - 1.0f) <= kTolerance;
  if (!affine) return std::nullopt;
  return Affine(vec3(m[0], m[1], m[2]), vec3(m[4], m[5], m[6]), vec3(m[8], m[9], m[10]),
                vec3(m[12], m[13], m[14]));
}

std::optional<Transform> decompose(const Affine& matrix) {
  constexpr float kMostShear = 1e-3f;  // cosine between axes
  if (is_singular(matrix)) return std::nullopt;
  const mat3 linear = linear_part(matrix);
  Transform result;
  result.translation = matrix[3];
  result.scale = vec3(length(linear[0]), length(linear[1]), length(linear[2]));
  if (glm::determinant(linear) < 0.0f) result.scale.x = -result.scale.x;
  const mat3 axes(linear[0] / result.scale.x, linear[1] / result.scale.y,
                  linear[2] / result.scale.z);
  for (int k = 0; k < 3; ++k) {
    if (std::abs(dot(axes[k], axes[(k + 1) % 3])) > kMostShear) return std::nullopt;
  }
  result.rotation = normalize(glm::quat_cast(axes));
  return result;
}

// The singular value decomposition by one-sided Jacobi rotations. Based on: M. Hestenes, "Inversion
// of Matrices by Biorthogonalization and Related Results", 1958.
TransformPair decompose_any(const Affine& matrix) {
  constexpr int kMostSweeps = 30;  // three or four do
  const glm::dmat3 linear(linear_part(matrix));
  glm::dmat3 a = linear, v(1.0);
  bool changed = true;
  for (int sweep = 0; sweep < kMostSweeps && changed; ++sweep) {
    changed = make_orthogonal(a, v, 0, 1);
    changed |= make_orthogonal(a, v, 0, 2);
    changed |= make_orthogonal(a, v, 1, 2);
  }
  glm::dvec3 scale(length(a[0]), length(a[1]), length(a[2]));
  glm::dmat3 u = complete_rotation(a, scale);
  if (glm::determinant(u) < 0.0) {
    u[0] = -u[0];
    scale.x = -scale.x;
  }
  TransformPair result;
  result.outer.translation = matrix[3];
  result.outer.rotation = quat(normalize(glm::quat_cast(u)));
  result.outer.scale = vec3(scale);
  result.inner = quat(normalize(glm::quat_cast(transpose(v))));
  return result;
}

}  // namespace sinew::gltf
