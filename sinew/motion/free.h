// One vertex of a FreeMotion.
#pragma once

#include "sinew/motion/motion.h"

namespace sinew {

inline vec3 position(const FreeMotion&, const Pose& pose, uint32_t vertex) {
  return pose.positions[vertex];
}

}  // namespace sinew
