#include "sinew/scene/procedural/creature_walk.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318531f;
constexpr vec3 kX(1.0f, 0.0f, 0.0f), kY(0.0f, 1.0f, 0.0f), kZ(0.0f, 0.0f, 1.0f);

float wave(float u) {
  return std::sin(kTwoPi * u);
}
float fraction(float x) {
  return x - std::floor(x);
}
quat turn(float angle, vec3 axis) {
  return glm::angleAxis(angle, axis);
}

const CreatureSkeleton& rest() {
  static const CreatureSkeleton skeleton = creature_skeleton();
  return skeleton;
}

LegJoints joints_of(uint32_t leg) {
  return {leg_joint(leg, kUpper), leg_joint(leg, kLower), leg_joint(leg, kFoot),
          leg_joint(leg, kToes)};
}

// Sets a leg down; `frames` holds the trunk.
void plant_leg(uint32_t leg, const Step& step, const CreatureFrames& frames, CreaturePose& pose) {
  const auto trunk = static_cast<size_t>(rest()[leg_joint(leg, kUpper)].parent);
  plant(rest(), joints_of(leg), step, frames[trunk], pose.rotation);
}

// The step of a leg at `u` of the walk's loop.
Step walk_step(const Treadmill& treadmill, uint32_t leg, float u) {
  const float stride = static_cast<float>(kWalkStrides) * u;
  const float phase = fraction(stride - touch_down(leg));  // 0 when the foot touches down
  // Fore feet step evenly before and behind the shoulder.
  const vec3 middle =
      rest()[leg_joint(leg, kToes)].position + vec3(0.0f, 0.0f, is_fore(leg) ? -0.05f : 0.0f);
  // Standing feet turn with the disc; `age` is in strides since the middle of the stance.
  const auto disc_yaw = [&](float age) {
    return disc_turn(treadmill, age / static_cast<float>(kWalkStrides));
  };
  const auto on_disc = [&](float age) {
    return treadmill.center + turn(disc_yaw(age), kY) * (middle - treadmill.center);
  };
  constexpr float kHeelUp = 0.62f, kToesUp = -0.22f;
  Step step;
  if (phase < kDutyFactor) {
    const float s = phase / kDutyFactor;
    step.ball = on_disc(phase - 0.5f * kDutyFactor);
    step.yaw = disc_yaw(phase - 0.5f * kDutyFactor);
    step.pitch =
        kHeelUp * glm::smoothstep(0.62f, 1.06f, s) + kToesUp * glm::smoothstep(0.14f, 0.0f, s);
    step.toe_pitch = 0.6f * kToesUp * glm::smoothstep(0.12f, 0.0f, s);
    return step;
  }
  const float s = (phase - kDutyFactor) / (1.0f - kDutyFactor);
  // Starts and lands with the speed of the ground.
  const float early = 0.5f * kDutyFactor + (phase - kDutyFactor);
  const float late = -0.5f * kDutyFactor - (1.0f - phase);
  const float blend = s * s * s * (s * (6.0f * s - 15.0f) + 10.0f);
  step.ball = glm::mix(on_disc(early), on_disc(late), blend);
  step.yaw = glm::mix(disc_yaw(early), disc_yaw(late), blend);
  const float lift = 0.5f - 0.5f * std::cos(kTwoPi * std::pow(s, 0.85f));
  step.ball.y += (is_fore(leg) ? 0.085f : 0.075f) * lift;
  const float end_of_stance = glm::smoothstep(0.62f, 1.06f, 1.0f);
  step.pitch = glm::mix(kHeelUp * end_of_stance, kToesUp, glm::smoothstep(0.10f, 0.95f, s)) +
               0.35f * wave(0.5f * std::min(1.0f, 1.7f * s)) * (1.0f - s);
  step.toe_pitch = 0.55f * lift + 0.6f * kToesUp * glm::smoothstep(0.6f, 1.0f, s);
  return step;
}

// Chains of the spine, neck and tail during the walk; `u` of the loop.
void walk_trunk(float u, CreaturePose& pose) {
  const float s = static_cast<float>(kWalkStrides) * u;  // in strides
  const float hind = wave(s + 0.25f);                    // +1 when the left hind foot touches down
  const float fore = wave(s + 0.25f - touch_down(kLeftFore));
  const float left = wave(s - 0.08f);  // +1 in the middle of the left hind stance
  pose.pelvis =
      rest()[kPelvis].position +
      vec3(0.016f * left, -0.022f + 0.011f * -wave(2.0f * s + 0.20f), 0.006f * wave(2.0f * s));
  pose.rotation[kPelvis] =
      turn(-0.10f * hind, kY) * turn(0.055f * left, kZ) * turn(0.020f * wave(2.0f * s + 0.1f), kX);
  pose.rotation[kSpine] = turn(0.06f * hind - 0.03f * fore + 0.02f, kY) * turn(-0.03f * left, kZ);
  pose.rotation[kChest] = turn(0.05f * hind - 0.06f * fore + 0.02f, kY) *
                          turn(0.04f * wave(s - 0.33f), kZ) *
                          turn(-0.022f * wave(2.0f * s + 0.35f), kX);
  // The neck takes back what the trunk does, a little late, so that the head is calm.
  pose.rotation[kNeckLow] =
      turn(0.045f * fore + 0.05f, kY) * turn(0.030f * wave(2.0f * s + 0.10f), kX);
  pose.rotation[kNeckHigh] =
      turn(0.040f * fore + 0.06f, kY) * turn(0.020f * wave(2.0f * s + 0.02f), kX);
  pose.rotation[kHead] = turn(0.05f + 0.07f * wave(u), kY) * turn(0.05f * wave(u + 0.3f), kZ) *
                         turn(0.045f * wave(2.0f * s - 0.10f) + 0.02f, kX);
  pose.rotation[kJaw] = turn(0.05f + 0.035f * wave(s + 0.4f), kX);
  for (uint32_t i = 0; i < kTailJoints; ++i) {
    const float k = static_cast<float>(i);
    const float sway = (0.075f + 0.018f * k) * wave(s + 0.30f - 0.085f * k);
    const float heave = (0.018f + 0.006f * k) * wave(2.0f * s - 0.09f * k);
    pose.rotation[kTail + i] = turn(sway - 0.02f, kY) * turn(heave, kX);
  }
}

void look_trunk(float u, CreaturePose& pose) {
  // A glance to the left, held, one to the right, held.
  const float glance = glm::smoothstep(0.05f, 0.20f, u) - 2.0f * glm::smoothstep(0.40f, 0.58f, u) +
                       glm::smoothstep(0.82f, 0.97f, u);
  const float breath = wave(2.0f * u);
  pose.pelvis = rest()[kPelvis].position + vec3(0.012f * glance, -0.012f + 0.006f * breath, 0.0f);
  pose.rotation[kPelvis] = turn(0.03f * glance, kY);
  pose.rotation[kSpine] = turn(0.04f * glance, kY) * turn(-0.012f * breath, kX);
  pose.rotation[kChest] = turn(0.06f * glance, kY) * turn(-0.015f * breath, kX);
  pose.rotation[kNeckLow] = turn(0.20f * glance, kY) * turn(-0.04f + 0.02f * breath, kX);
  pose.rotation[kNeckHigh] = turn(0.24f * glance, kY) * turn(-0.06f, kX);
  pose.rotation[kHead] = turn(0.26f * glance, kY) * turn(0.16f * wave(u + 0.1f) * glance, kZ) *
                         turn(0.06f + 0.03f * wave(3.0f * u), kX);
  pose.rotation[kJaw] = turn(0.06f + 0.05f * wave(2.0f * u + 0.3f), kX);
  for (uint32_t i = 0; i < kTailJoints; ++i) {
    const float k = static_cast<float>(i);
    pose.rotation[kTail + i] = turn((0.06f + 0.02f * k) * wave(u - 0.06f * k), kY) *
                               turn(0.02f * k * wave(2.0f * u - 0.10f * k), kX);
  }
}

CreaturePose standing() {
  CreaturePose pose;
  pose.rotation.fill(glm::identity<quat>());
  pose.pelvis = rest()[kPelvis].position;
  return pose;
}

Clip bake(const char* name, double seconds, uint32_t first_node,
          const std::function<CreaturePose(float u)>& pose_at) {
  constexpr double kKeysASecond = 30.0;
  const uint32_t steps = static_cast<uint32_t>(seconds * kKeysASecond);
  const std::vector<float> times = even_times(steps, seconds);
  std::vector<vec3> pelvis;
  std::vector<std::vector<quat>> rotations(kCreatureJoints);
  for (uint32_t k = 0; k <= steps; ++k) {
    // The last key is the first, so that the loop closes to the bit.
    const CreaturePose pose = pose_at(static_cast<float>(k % steps) / static_cast<float>(steps));
    pelvis.push_back(pose.pelvis);
    for (uint32_t j = 0; j < kCreatureJoints; ++j) rotations[j].push_back(pose.rotation[j]);
  }
  Clip clip;
  clip.name = name;
  clip.end = seconds;
  clip.channels.push_back(translation_channel(first_node + kPelvis, times, pelvis));
  for (uint32_t j = 0; j < kCreatureJoints; ++j) {
    clip.channels.push_back(rotation_channel(first_node + j, times, rotations[j]));
  }
  return clip;
}

}  // namespace

float disc_turn(const Treadmill& treadmill, float loops) {
  return kTwoPi * loops / static_cast<float>(treadmill.loops_a_turn);
}

float touch_down(uint32_t leg) {
  constexpr std::array<float, kCreatureLegs> kPhase{0.25f, 0.75f, 0.0f, 0.5f};
  return kPhase[leg];
}

CreatureFrames joint_frames(const CreaturePose& pose) {
  CreatureFrames frames;
  joint_frames(rest(), pose.pelvis, pose.rotation, frames);
  return frames;
}

CreaturePose walk_pose(const Treadmill& treadmill, float u) {
  CreaturePose pose = standing();
  walk_trunk(u, pose);
  const CreatureFrames frames = joint_frames(pose);
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    plant_leg(leg, walk_step(treadmill, leg, u), frames, pose);
  }
  return pose;
}

CreaturePose look_pose(float u) {
  CreaturePose pose = standing();
  look_trunk(u, pose);
  const CreatureFrames frames = joint_frames(pose);
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    plant_leg(leg, {rest()[leg_joint(leg, kToes)].position, 0.0f, 0.0f, 0.0f}, frames, pose);
  }
  return pose;
}

Clip walk_clip(const Treadmill& treadmill, uint32_t first_node, uint32_t disc_node) {
  Clip clip =
      bake("Walk", kWalkSeconds, first_node, [&](float u) { return walk_pose(treadmill, u); });
  const std::vector<float> times = even_times(1, kWalkSeconds);
  clip.channels.push_back(rotation_channel(
      disc_node, times, {glm::identity<quat>(), turn(disc_turn(treadmill, 1.0f), kY)}));
  return clip;
}

Clip look_clip(uint32_t first_node, uint32_t disc_node) {
  Clip clip = bake("Look", kLookSeconds, first_node, look_pose);
  clip.channels.push_back(rotation_channel(disc_node, {0.0f}, {glm::identity<quat>()}));
  return clip;
}

}  // namespace sinew
