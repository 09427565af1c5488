#include "sinew/scene/procedural/creature_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/scene/procedural/creature_skeleton.h"

namespace sinew {
namespace {

constexpr glm::ivec3 kGrid(10, 14, 34);

// Quadratic smooth minimum: exactly the minimum where the two differ by `blend` or more.
float smooth_min(float a, float b, float blend) {
  const float h = std::max(blend - std::abs(a - b), 0.0f);
  return std::min(a, b) - (blend > 0.0f ? 0.25f * h * h / blend : 0.0f);
}
float smooth_max(float a, float b, float blend) {
  return -smooth_min(-a, -b, blend);
}

vec3 mirrored(vec3 p, float side) {
  return vec3(side * p.x, p.y, p.z);
}

}  // namespace

// With the axis along t and q the distance from it, sphere s has its surface at
// sqrt((t - s)^2 + q^2) - (radius_a + m s): least where (t - s) = -m q / sqrt(1 - m^2).
float RoundCone::distance(vec3 p) const {
  const vec3 axis = b - a;
  const float length_of_axis = length(axis);
  if (length_of_axis < 1e-6f) return length(p - a) - std::max(radius_a, radius_b);
  const vec3 direction = axis / length_of_axis;
  const float t = dot(p - a, direction);
  const float q = length(p - a - t * direction);
  const float m = std::clamp((radius_b - radius_a) / length_of_axis, -0.98f, 0.98f);
  const float s = std::clamp(t + m * q / std::sqrt(1.0f - m * m), 0.0f, length_of_axis);
  return std::sqrt((t - s) * (t - s) + q * q) - (radius_a + m * s);
}

CreatureBody::CreatureBody() {
  add_trunk();
  add_head();
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) add_leg(leg);
  fill_grid();
}

void CreatureBody::add(uint32_t joint, RoundCone shape, float blend) {
  flesh_.push_back({joint, shape, blend});
}

void CreatureBody::add_trunk() {
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

void CreatureBody::add_head() {
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

void CreatureBody::add_leg(uint32_t leg) {
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

Box CreatureBody::box() const {
  Box box;
  for (const Flesh& f : flesh_) {
    box.extend({f.shape.a - f.shape.radius_a, f.shape.a + f.shape.radius_a});
    box.extend({f.shape.b - f.shape.radius_b, f.shape.b + f.shape.radius_b});
  }
  return {box.min - 0.04f, box.max + 0.04f};
}

// Flesh farther from a cell than any blend can reach does not matter there.
void CreatureBody::fill_grid() {
  grid_box_ = box();
  const vec3 cell = grid_box_.extent() / vec3(kGrid);
  for (uint32_t i = 0; i < flesh_.size(); ++i) all_flesh_.push_back(static_cast<uint8_t>(i));
  constexpr float kReach = 0.30f;  // three times the widest blend
  cell_start_.push_back(0);
  for (int i = 0; i < kGrid.x * kGrid.y * kGrid.z; ++i) {
    const vec3 at(i % kGrid.x, i / kGrid.x % kGrid.y, i / kGrid.x / kGrid.y);
    const vec3 middle = grid_box_.min + cell * (at + 0.5f);
    const float slack = kReach + length(cell);
    const float value = blend_all(middle, all_flesh_.data(), all_flesh_.data() + all_flesh_.size());
    for (const uint8_t f : all_flesh_) {
      if (flesh_[f].shape.distance(middle) < value + slack) cell_flesh_.push_back(f);
    }
    cell_start_.push_back(static_cast<uint32_t>(cell_flesh_.size()));
  }
}

float CreatureBody::blend_all(vec3 p, const uint8_t* first, const uint8_t* last) const {
  float value = 1e3f;
  for (; first != last; ++first) {
    const Flesh& f = flesh_[*first];
    value = smooth_min(value, f.shape.distance(p), f.blend);
  }
  return value;
}

float CreatureBody::field(vec3 p) const {
  const vec3 at = (p - grid_box_.min) / grid_box_.extent() * vec3(kGrid);
  float value;
  if (glm::all(glm::greaterThanEqual(at, vec3(0.0f))) && glm::all(glm::lessThan(at, vec3(kGrid)))) {
    const glm::ivec3 c(at);
    const uint32_t cell = static_cast<uint32_t>(c.x + kGrid.x * (c.y + kGrid.y * c.z));
    value = blend_all(p, &cell_flesh_[cell_start_[cell]], &cell_flesh_[cell_start_[cell + 1]]);
  } else {
    value = blend_all(p, all_flesh_.data(), all_flesh_.data() + all_flesh_.size());
  }
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

SkinWeights CreatureBody::skin_weights(vec3 p) const {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  std::array<float, kCreatureJoints> distance;
  std::array<float, kCreatureJoints> softness{};
  distance.fill(kFar);
  for (const Flesh& f : flesh_) {
    const float d = f.shape.distance(p);
    if (d >= distance[f.joint]) continue;
    distance[f.joint] = d;
    softness[f.joint] = 0.36f * std::min(0.16f, std::max(f.shape.radius_a, f.shape.radius_b));
  }
  // Only the nearest leg counts, so that nothing bleeds from leg to leg.
  std::array<float, kCreatureLegs> leg_distance;
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    leg_distance[leg] =
        *std::min_element(&distance[leg_joint(leg, 0)], &distance[leg_joint(leg, 0)] + kLegJoints);
  }
  const auto nearest_leg =
      static_cast<uint32_t>(std::ranges::min_element(leg_distance) - leg_distance.begin());
  const float nearest = *std::ranges::min_element(distance);
  std::array<std::pair<float, uint16_t>, kCreatureJoints> candidates;
  for (uint32_t j = 0; j < kCreatureJoints; ++j) {
    const bool other_leg = j >= kLegs && (j - kLegs) / kLegJoints != nearest_leg;
    const float x = (distance[j] - nearest) / std::max(softness[j], 1e-3f);
    candidates[j] = {other_leg ? 0.0f : std::exp(-x * x), static_cast<uint16_t>(j)};
  }
  constexpr uint32_t n = SkinWeights::kInfluences;
  std::ranges::partial_sort(candidates, candidates.begin() + n + 1, std::greater<>());
  // Less the greatest weight left out: so a joint fades in and out without a jump.
  SkinWeights result;
  float sum = 0.0f;
  for (uint32_t k = 0; k < n; ++k) {
    const float weight = candidates[k].first - candidates[n].first + (k == 0 ? 1e-3f : 0.0f);
    result.joints[k] = candidates[k].second;
    result.weights[k] = weight > 1e-4f ? weight : 0.0f;
    sum += result.weights[k];
  }
  for (float& w : result.weights) w /= sum;
  return result;
}

}  // namespace sinew
