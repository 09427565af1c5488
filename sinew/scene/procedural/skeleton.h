// Skeletons whose joints all rest with the world's axes, so that a joint's bind matrix is a
// translation, and legs that are set down where they should be.
// Based on: two-bone inverse kinematics by the law of cosines.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "sinew/scene/scene.h"

namespace sinew {

struct SkeletonJoint {
  std::string name;
  int32_t parent = -1;  // an earlier joint, or -1
  vec3 position{0.0f};  // metres, at rest
};
using Skeleton = std::span<const SkeletonJoint>;

// A leg's joints: hip or shoulder, knee or elbow, ankle, ball of the foot.
enum LegJoint : uint32_t { kUpper, kLower, kFoot, kToes };
inline constexpr uint32_t kLegJoints = 4;
using LegJoints = std::array<uint32_t, kLegJoints>;

// Where a foot's ball is, how far the foot is turned around +Y, and how foot and toes are pitched
// (radians; positive lifts the heel).
struct Step {
  vec3 ball{0.0f};
  float yaw = 0.0f;
  float pitch = 0.0f;
  float toe_pitch = 0.0f;
};

// World transform of the joint that a leg hangs from.
struct JointFrame {
  quat rotation = glm::identity<quat>();
  vec3 position{0.0f};
};

// World transforms of all joints, one a joint: `root` is where joint 0 is, `rotations` are against
// the parents (at rest all are identity).
void joint_frames(Skeleton rest, vec3 root, std::span<const quat> rotations,
                  std::span<JointFrame> frames);

// Sets the rotations of a leg's joints so that its ball is where the step says, or as near as the
// leg reaches. `trunk` is the frame of the parent of the leg's first joint.
void plant(Skeleton rest, const LegJoints& leg, const Step& step, const JointFrame& trunk,
           std::span<quat> rotations);

// Adds nodes for all joints, in order, and a skin; returns the first node.
uint32_t add_skeleton(Scene& scene, Skeleton rest, const std::string& name, int32_t parent = -1);

}  // namespace sinew
