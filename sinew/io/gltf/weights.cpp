#include "sinew/io/gltf/weights.h"

#include <algorithm>
#include <cmath>

namespace sinew::gltf {
namespace {

// Eight-bit weights sum to 1 within a few of their steps; that much is no fault of the file.
constexpr double kTolerance = 0.02;

uint32_t most_influences(const RawWeights& raw, uint32_t vertex_count) {
  uint32_t most = 1;
  for (uint32_t v = 0; v < vertex_count; ++v) {
    const auto begin = raw.weights.begin() + static_cast<std::ptrdiff_t>(v) * raw.columns;
    const auto used = std::count_if(begin, begin + raw.columns, [](float w) { return w > 0.0f; });
    most = std::max(most, static_cast<uint32_t>(used));
  }
  return most;
}

}  // namespace

WeightChanges compact_weights(const RawWeights& raw, uint32_t vertex_count, Mesh& mesh) {
  WeightChanges changes;
  mesh.influences = most_influences(raw, vertex_count);
  mesh.joints.assign(size_t{vertex_count} * mesh.influences, 0);
  mesh.weights.assign(size_t{vertex_count} * mesh.influences, 0.0f);
  for (size_t v = 0; v < vertex_count; ++v) {
    double sum = 0.0;
    size_t out = v * mesh.influences;
    for (size_t i = v * raw.columns; i < (v + 1) * raw.columns; ++i) {
      if (!(raw.weights[i] > 0.0f)) continue;
      mesh.joints[out] = static_cast<uint16_t>(raw.joints[i]);
      mesh.weights[out] = raw.weights[i];
      sum += double{raw.weights[i]};
      ++out;
    }
    const size_t first = v * mesh.influences;
    if (sum == 0.0) {
      mesh.weights[first] = 1.0f;
      ++changes.unweighted;
      continue;
    }
    if (std::abs(sum - 1.0) > kTolerance) ++changes.normalized;
    for (size_t i = first; i < out; ++i) {
      mesh.weights[i] = static_cast<float>(double{mesh.weights[i]} / sum);
    }
  }
  return changes;
}

}  // namespace sinew::gltf
