// The creature's joints: a stocky, long-tailed quadruped that faces +Z, stands on y = 0, and has
// its left side at +X. All joints rest with the world's axes, so a joint's bind matrix is a
// translation.
#pragma once

#include <array>
#include <cstdint>

#include "sinew/scene/procedural/skeleton.h"

namespace sinew {

enum CreatureJoint : uint32_t {
  kPelvis,
  kSpine,
  kChest,
  kNeckLow,
  kNeckHigh,
  kHead,
  kJaw,
  kEyeLeft,
  kEyeRight,
  kTail,              // the first of kTailJoints
  kLegs = kTail + 8,  // four legs of kLegJoints each
  kCreatureJoints = kLegs + 16
};
inline constexpr uint32_t kTailJoints = 8;

enum CreatureLeg : uint32_t { kLeftFore, kRightFore, kLeftHind, kRightHind, kCreatureLegs };

inline uint32_t leg_joint(uint32_t leg, uint32_t joint) {
  return kLegs + kLegJoints * leg + joint;
}
inline bool is_fore(uint32_t leg) {
  return leg < kLeftHind;
}
inline float side_of(uint32_t leg) {
  return leg % 2 == 0 ? 1.0f : -1.0f;
}  // +1 left, -1 right

using CreatureSkeleton = std::array<SkeletonJoint, kCreatureJoints>;

CreatureSkeleton creature_skeleton();

// Where the tail ends, and where the eyes are (left one; mirror x for the right).
inline constexpr vec3 kTailTip{0.0f, 0.50f, -2.00f};
inline constexpr vec3 kEyeCenter{0.118f, 1.018f, 0.885f};
inline constexpr float kEyeRadius = 0.072f;

}  // namespace sinew
