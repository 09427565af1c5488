// One vertex of a MorphMotion. Targets are added in order; those of weight 0 are skipped, since
// most of a face's targets rest at any one time.
// Based on: glTF 2.0 specification, section 3.7.2.2 (morph targets).
#pragma once

#include "sinew/motion/skin.h"

namespace sinew {

inline uint32_t target_count(const MorphMotion& motion) {
  if (motion.rest.empty()) return 0;
  return static_cast<uint32_t>(motion.deltas.size() / motion.rest.size());
}

// Calls add(weight, deltas of the target, one a vertex) for each target that counts.
template <class Add>
void for_each_target(const MorphMotion& motion, const Pose& pose, const Add& add) {
  const size_t stride = motion.rest.size();
  for (uint32_t target = 0; target < target_count(motion); ++target) {
    const float weight = pose.weights[target];
    if (weight != 0.0f) add(weight, motion.deltas.subspan(target * stride, stride));
  }
}

inline vec3 position(const MorphMotion& motion, const Pose& pose, uint32_t vertex) {
  vec3 p = motion.rest[vertex];
  for_each_target(motion, pose, [&](float weight, std::span<const vec3> deltas) {
    p += weight * deltas[vertex];
  });
  return motion.skin.influences == 0 ? p : skin_point(motion.skin, pose, vertex, p);
}

}  // namespace sinew
