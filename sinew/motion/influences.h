// Which joints move a point of a body: what a pick of an animated character wants to know.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/motion/motion.h"

namespace sinew {

struct JointWeight {
  uint32_t joint = 0;   // index among the joint matrices of the pose
  float weight = 0.0f;  // > 0; of one point they sum to 1, up to rounding
};

// The joints that move the point at these barycentric coordinates of the triangle, the heaviest
// first. Empty if the motion has no skin.
std::vector<JointWeight> joint_weights(const Motion& motion, uvec3 triangle, vec3 barycentrics);

}  // namespace sinew
