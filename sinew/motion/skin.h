// One vertex of a SkinMotion: the joints' matrices are blended, then the point is mapped once.
// Based on: glTF 2.0 specification, section 3.7.3.3 (skinned mesh attributes).
#pragma once

#include "sinew/motion/motion.h"

namespace sinew {

// sum_k weight_k * joints[index_k], in the order of k, from zero. Unused influences are added like
// all others: 0 * a finite matrix changes nothing, and a branch on the weight costs twice the time
// because it is never predicted well.
inline Affine blend_joints(const SkinMotion& skin, const Pose& pose, uint32_t vertex) {
  Affine blended(0.0f);
  const size_t begin = size_t{vertex} * skin.influences;
  for (size_t k = begin; k < begin + skin.influences; ++k) {
    const float weight = skin.weights[k];
    const Affine& joint = pose.joints[skin.joints[k]];
    for (int column = 0; column < 4; ++column) blended[column] += weight * joint[column];
  }
  return blended;
}

inline vec3 skin_point(const SkinMotion& skin, const Pose& pose, uint32_t vertex, vec3 rest) {
  return transform_point(blend_joints(skin, pose, vertex), rest);
}

inline vec3 position(const SkinMotion& skin, const Pose& pose, uint32_t vertex) {
  return skin_point(skin, pose, vertex, skin.rest[vertex]);
}

}  // namespace sinew
