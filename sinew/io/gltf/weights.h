// Skin weights as files hold them, and as SkinMotion wants them: normalised, the used influences
// first, as few columns as the fullest vertex needs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/scene/mesh.h"

namespace sinew::gltf {

// Vertex-major columns: [vertex * columns + k].
struct RawWeights {
  uint32_t columns = 0;
  std::vector<uint32_t> joints;
  std::vector<float> weights;
};

struct WeightChanges {
  uint64_t normalized = 0;  // vertices whose weights did not sum to 1
  uint64_t unweighted = 0;  // vertices without any weight, now bound to joint 0
};

// Fills mesh.influences, mesh.joints and mesh.weights. Joints of used influences must be below
// 65536. Negative weights count as 0.
WeightChanges compact_weights(const RawWeights& raw, uint32_t vertex_count, Mesh& mesh);

}  // namespace sinew::gltf
