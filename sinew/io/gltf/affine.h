// 4x4 matrices of glTF files as affine maps.
#pragma once

#include <optional>
#include <span>

#include "sinew/math/affine.h"

namespace sinew::gltf {

// `values` are 16 numbers, column-major. Nothing if the last row is not (0, 0, 0, 1), as far as
// rounding in exporters may put it off.
std::optional<Affine> affine_of(std::span<const float> values);

struct Transform {
  vec3 translation{0.0f};
  quat rotation = glm::identity<quat>();
  vec3 scale{1.0f};
};
// The transform that makes this matrix; nothing if it shears or flattens.
std::optional<Transform> decompose(const Affine& matrix);

// Any map, shearing or flat, as two that glTF nodes can be: `outer` after `inner`.
struct TransformPair {
  Transform outer;
  quat inner = glm::identity<quat>();  // the identity unless the map shears
};
TransformPair decompose_any(const Affine& matrix);

}  // namespace sinew::gltf
