// Stand-in until derived bounds are merged: exact boxes from the vertices.
#pragma once

#include <vector>

#include "sinew/motion/motion.h"

namespace sinew {

struct ClusterVertices {
  std::span<const uint32_t> first;
  std::span<const uint32_t> vertices;
};
struct ClusterConfig {};
struct ClusterBounds {
  std::vector<uint32_t> first, vertices;
};
inline ClusterBounds make_cluster_bounds(const Motion&, const ClusterVertices& clusters,
                                         const ClusterConfig& = {}) {
  return {{clusters.first.begin(), clusters.first.end()},
          {clusters.vertices.begin(), clusters.vertices.end()}};
}
inline void derive_bounds(const ClusterBounds& clusters, const Motion& motion, const Pose& pose,
                          uint32_t begin, std::span<Box> out) {
  for (size_t i = 0; i < out.size(); ++i) {
    const uint32_t first = clusters.first[begin + i], last = clusters.first[begin + i + 1];
    out[i] = bounds(motion, pose, std::span(clusters.vertices).subspan(first, last - first));
  }
}
inline Box derive_body_bounds(const ClusterBounds& clusters, const Motion& motion,
                              const Pose& pose) {
  return bounds(motion, pose, clusters.vertices);
}
inline bool derivable(const Motion& motion) {
  return !std::holds_alternative<FreeMotion>(motion);
}

}  // namespace sinew
