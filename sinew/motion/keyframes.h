// One vertex of a KeyframeMotion: (1 - u) * key + u * next key, which gives each key back exactly.
#pragma once

#include <algorithm>

#include "sinew/motion/motion.h"

namespace sinew {

inline uint32_t key_count(const KeyframeMotion& motion) {
  if (motion.vertex_count == 0) return 0;
  return static_cast<uint32_t>(motion.keys.size() / motion.vertex_count);
}

inline vec3 position(const KeyframeMotion& motion, const Pose& pose, uint32_t vertex) {
  const uint32_t next = std::min(pose.key + 1, key_count(motion) - 1);
  const vec3 a = motion.keys[size_t{pose.key} * motion.vertex_count + vertex];
  const vec3 b = motion.keys[size_t{next} * motion.vertex_count + vertex];
  return (1.0f - pose.key_fraction) * a + pose.key_fraction * b;
}

}  // namespace sinew
