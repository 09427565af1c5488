#include "sinew/scene/procedural/creature_skeleton.h"

namespace sinew {

CreatureSkeleton creature_skeleton() {
  CreatureSkeleton joints;
  joints[kPelvis] = {"pelvis", -1, {0.0f, 0.60f, -0.34f}};
  joints[kSpine] = {"spine", kPelvis, {0.0f, 0.62f, -0.12f}};
  joints[kChest] = {"chest", kSpine, {0.0f, 0.63f, 0.14f}};
  joints[kNeckLow] = {"neck low", kChest, {0.0f, 0.70f, 0.36f}};
  joints[kNeckHigh] = {"neck high", kNeckLow, {0.0f, 0.82f, 0.52f}};
  joints[kHead] = {"head", kNeckHigh, {0.0f, 0.93f, 0.66f}};
  joints[kJaw] = {"jaw", kHead, {0.0f, 0.89f, 0.74f}};
  joints[kEyeLeft] = {"eye left", kHead, kEyeCenter};
  joints[kEyeRight] = {"eye right", kHead, kEyeCenter * vec3(-1.0f, 1.0f, 1.0f)};

  constexpr std::array<vec3, kTailJoints> tail{
      vec3(0.0f, 0.58f, -0.55f), vec3(0.0f, 0.51f, -0.76f), vec3(0.0f, 0.44f, -0.96f),
      vec3(0.0f, 0.38f, -1.15f), vec3(0.0f, 0.34f, -1.33f), vec3(0.0f, 0.33f, -1.51f),
      vec3(0.0f, 0.36f, -1.68f), vec3(0.0f, 0.42f, -1.84f)};
  for (uint32_t i = 0; i < kTailJoints; ++i) {
    joints[kTail + i] = {"tail " + std::to_string(i + 1),
                         static_cast<int32_t>(i == 0 ? kPelvis : kTail + i - 1), tail[i]};
  }

  constexpr std::array<vec3, kLegJoints> fore{vec3(0.21f, 0.55f, 0.28f), vec3(0.315f, 0.34f, 0.13f),
                                              vec3(0.30f, 0.13f, 0.25f), vec3(0.31f, 0.05f, 0.34f)};
  constexpr std::array<vec3, kLegJoints> hind{
      vec3(0.20f, 0.55f, -0.36f), vec3(0.32f, 0.37f, -0.17f), vec3(0.31f, 0.15f, -0.37f),
      vec3(0.32f, 0.05f, -0.27f)};
  constexpr std::array<const char*, kCreatureLegs> leg_names{"left fore", "right fore", "left hind",
                                                             "right hind"};
  constexpr std::array<const char*, kLegJoints> joint_names{"upper", "lower", "foot", "toes"};
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    for (uint32_t i = 0; i < kLegJoints; ++i) {
      SkeletonJoint& joint = joints[leg_joint(leg, i)];
      joint.name = std::string(leg_names[leg]) + " " + joint_names[i];
      joint.parent = static_cast<int32_t>(i > 0          ? leg_joint(leg, i - 1)
                                          : is_fore(leg) ? uint32_t{kChest}
                                                         : uint32_t{kPelvis});
      joint.position = (is_fore(leg) ? fore : hind)[i] * vec3(side_of(leg), 1.0f, 1.0f);
    }
  }
  return joints;
}

}  // namespace sinew
