// One vertex of a RigidMotion.
#pragma once

#include "sinew/motion/motion.h"

namespace sinew {

inline vec3 position(const RigidMotion& motion, const Pose&, uint32_t vertex) {
  return motion.rest[vertex];
}

}  // namespace sinew
