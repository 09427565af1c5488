// How the creature moves: a walk on a turning disc, and looking around while standing.
// Based on: M. Hildebrand, "Symmetrical gaits of horses", Science 150, 1965 (the lateral-sequence
// walk and its duty factor).
#pragma once

#include <array>

#include "sinew/scene/clip.h"
#include "sinew/scene/procedural/creature_skeleton.h"

namespace sinew {

// The disc that the creature walks on: its middle, and how far one loop of the walk turns it.
struct Treadmill {
  vec3 center{-4.0f, 0.0f, 0.0f};
  uint32_t loops_a_turn = 24;  // the ground's pattern must repeat this often
};

inline constexpr double kWalkSeconds = 2.0;  // one loop: two strides
inline constexpr uint32_t kWalkStrides = 2;
inline constexpr double kLookSeconds = 4.0;
inline constexpr float kDutyFactor = 0.66f;  // share of a stride that a foot stands

struct CreaturePose {
  vec3 pelvis{0.0f};                           // position
  std::array<quat, kCreatureJoints> rotation;  // against the parent; at rest all are identity
};

// The disc's turn (radians around +Y) after `loops` of the walk.
float disc_turn(const Treadmill& treadmill, float loops);

// When the foot of `leg` touches down, as a share of a stride.
float touch_down(uint32_t leg);

// At `u` in [0, 1] of the loop.
CreaturePose walk_pose(const Treadmill& treadmill, float u);
CreaturePose look_pose(float u);

// World transforms of all joints.
using CreatureFrames = std::array<JointFrame, kCreatureJoints>;
CreatureFrames joint_frames(const CreaturePose& pose);

// Bakes a loop; joint j animates node first_node + j, the disc's turn animates `disc_node`.
Clip walk_clip(const Treadmill& treadmill, uint32_t first_node, uint32_t disc_node);
Clip look_clip(uint32_t first_node, uint32_t disc_node);

}  // namespace sinew
