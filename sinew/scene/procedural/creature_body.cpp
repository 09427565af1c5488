#include "sinew/scene/procedural/creature_body.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sinew/scene/procedural/creature_skeleton.h"

namespace sinew {
namespace {

vec3 mirrored(vec3 p, float side) {
  return vec3(side * p.x, p.y, p.z);
}

using FleshList = std::vector<Flesh>;

auto adder(FleshList& flesh) {
  return [&](uint32_t joint, RoundCone shape, float blend) {
    flesh.push_back({joint, shape, blend});
  };
}

void add_trunk(FleshList& flesh) {
  const auto add = adder(flesh);
  add(kPelvis, {{0.0f, 0.585f, -0.46f}, 0.205f, {0.0f, 0.60f, -0.22f}, 0.255f}, 0.0f);
  add(kSpine, {{0.0f, 0.595f, -0.18f}, 0.268f, {0.0f, 0.60f, 0.04f}, 0.272f}, 0.08f);
  add(kChest, {{0.0f, 0.605f, 0.10f}, 0.265f, {0.0f, 0.665f, 0.30f}, 0.215f}, 0.08f);
  add(kNeckLow, {{0.0f, 0.69f, 0.34f}, 0.195f, {0.0f, 0.82f, 0.52f}, 0.155f}, 0.08f);
  add(kNeckHigh, {{0.0f, 0.83f, 0.53f}, 0.152f, {0.0f, 0.92f, 0.64f}, 0.148f}, 0.06f);
  const CreatureSkeleton skeleton = creature_skeleton();
  constexpr std::array<float, kTailJoints + 1> radii{0.190f, 0.150f, 0.120f, 0.096f, 0.077f,
                                                     0.061f, 0.050f, 0.041f, 0.030f};
  for (uint32_t i = 0; i < kTailJoints; ++i) {
    const vec3 end = i + 1 < kTailJoints ? skeleton[kTail + i + 1].position : kTailTip;
    add(kTail + i, {skeleton[kTail + i].position, radii[i], end, radii[i + 1]},
        i == 0 ? 0.10f : 0.02f);
  }
}

void add_head(FleshList& flesh) {
  const auto add = adder(flesh);
  add(kHead, {{0.0f, 0.985f, 0.72f}, 0.168f, {0.0f, 0.965f, 0.86f}, 0.150f}, 0.07f);
  add(kHead, {{0.0f, 0.945f, 0.90f}, 0.122f, {0.0f, 0.925f, 1.075f}, 0.088f}, 0.06f);
  for (const float side : {1.0f, -1.0f}) {
    // Cheek, brow over the eye, lid below it, nostril.
    add(kHead,
        {mirrored({0.085f, 0.925f, 0.745f}, side), 0.098f, mirrored({0.085f, 0.915f, 0.83f}, side),
         0.075f},
        0.05f);
    add(kHead,
        {mirrored({0.118f, 1.075f, 0.795f}, side), 0.044f, mirrored({0.098f, 1.078f, 0.925f}, side),
         0.030f},
        0.045f);
    add(kHead,
        {mirrored({0.125f, 0.972f, 0.83f}, side), 0.030f, mirrored({0.112f, 0.958f, 0.925f}, side),
         0.022f},
        0.04f);
    add(kHead,
        {mirrored({0.042f, 0.975f, 1.105f}, side), 0.034f, mirrored({0.045f, 0.965f, 1.135f}, side),
         0.028f},
        0.035f);
  }
  add(kJaw, {{0.0f, 0.868f, 0.76f}, 0.110f, {0.0f, 0.845f, 1.04f}, 0.066f}, 0.012f);
}

void add_leg(FleshList& flesh, uint32_t leg) {
  const auto add = adder(flesh);
  const CreatureSkeleton skeleton = creature_skeleton();
  const auto joint = [&](uint32_t i) { return skeleton[leg_joint(leg, i)].position; };
  const float side = side_of(leg);
  const bool fore = is_fore(leg);
  // Muscle where the leg leaves the trunk, then the long bones.
  const vec3 muscle =
      mirrored(fore ? vec3(0.175f, 0.545f, 0.25f) : vec3(0.165f, 0.535f, -0.335f), side);
  const vec3 belly = glm::mix(joint(kUpper), joint(kLower), 0.55f);
  add(leg_joint(leg, kUpper), {muscle, fore ? 0.135f : 0.165f, belly, fore ? 0.098f : 0.122f},
      0.07f);
  add(leg_joint(leg, kUpper),
      {belly, fore ? 0.098f : 0.122f, joint(kLower), fore ? 0.080f : 0.088f}, 0.05f);
  add(leg_joint(leg, kLower), {joint(kLower), fore ? 0.080f : 0.086f, joint(kFoot), 0.062f}, 0.03f);
  add(leg_joint(leg, kFoot), {joint(kFoot), 0.062f, joint(kToes), 0.056f}, 0.03f);
  for (int toe = -1; toe <= 1; ++toe) {
    const vec3 base = joint(kToes) + vec3(0.034f * static_cast<float>(toe), -0.004f, -0.005f);
    const vec3 tip =
        joint(kToes) + vec3(0.070f * static_cast<float>(toe), -0.018f, toe == 0 ? 0.105f : 0.085f);
    add(leg_joint(leg, kToes), {base, 0.044f, tip, 0.030f}, toe == -1 ? 0.03f : 0.012f);
  }
}

FleshBody make_flesh() {
  FleshList flesh;
  add_trunk(flesh);
  add_head(flesh);
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) add_leg(flesh, leg);
  std::vector<int8_t> limbs(kCreatureJoints, FleshBody::kTrunk);
  for (uint32_t j = kLegs; j < kCreatureJoints; ++j) {
    limbs[j] = static_cast<int8_t>((j - kLegs) / kLegJoints);
  }
  return FleshBody(std::move(flesh), std::move(limbs));
}

}  // namespace

CreatureBody::CreatureBody() : flesh_(make_flesh()) {}

float CreatureBody::field(vec3 p) const {
  float value = flesh_.field(p);
  // Room for the eyes and nostrils, flat soles.
  const vec3 half(std::abs(p.x), p.y, p.z);
  value = smooth_max(value, kEyeRadius - 0.004f - length(half - kEyeCenter), 0.012f);
  value = smooth_max(value, 0.016f - length(half - vec3(0.046f, 0.972f, 1.162f)), 0.012f);
  return smooth_max(value, 0.004f - p.y, 0.012f);
}

vec3 CreatureBody::leave(vec3 inside, vec3 direction) const {
  float distance = 0.0f;
  for (int i = 0; i < 64; ++i) distance -= field(inside + distance * direction);
  return inside + distance * direction;
}

}  // namespace sinew
