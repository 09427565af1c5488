#include "sinew/io/gltf/affine.h"

#include <cmath>

namespace sinew::gltf {

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

}  // namespace sinew::gltf
