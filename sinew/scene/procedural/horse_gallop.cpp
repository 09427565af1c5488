#include "sinew/scene/procedural/horse_gallop.h"

#include <cmath>

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318531f;
constexpr vec3 kX(1.0f, 0.0f, 0.0f), kY(0.0f, 1.0f, 0.0f);

// +1 at `peak` of the stride, -1 half a stride later.
float swing(float stride, float peak) {
  return std::cos(kTwoPi * (stride - peak));
}

// When the hoof of a leg comes down, as a share of a stride.
float touch_down(const Gallop& gallop, uint32_t leg) {
  const bool leading = (leg % 2 == 1) == gallop.right_lead;
  if (leg < 2) return leading ? 0.50f : 0.34f;
  return leading ? 0.13f : 0.0f;
}

double stride_at(const Gallop& gallop, double time) {
  return time / gallop.stride_seconds + gallop.phase;
}
double time_of(const Gallop& gallop, double stride) {
  return (stride - gallop.phase) * gallop.stride_seconds;
}

// Where the ball of a foot stands for the `count`th time, in the world: beneath the place that its
// hip or shoulder passes in the middle of the stance.
vec3 standing_place(const Gallop& gallop, uint32_t leg, double count) {
  const vec3 ball = horse_skeleton()[horse_leg(leg)[kToes]].position;
  const vec3 beneath(0.75f * ball.x, 0.0f, ball.z + (leg < 2 ? 0.03f : 0.14f));
  const JointFrame body =
      gallop.way(time_of(gallop, count + touch_down(gallop, leg) + 0.5 * kGallopDuty));
  vec3 place = body.position + body.rotation * (gallop.scale * beneath);
  place.y = gallop.ground(place.x, place.z) + gallop.scale * ball.y;
  return place;
}

vec3 to_horse(const Gallop& gallop, vec3 place, double stride) {
  const JointFrame body = gallop.way(time_of(gallop, stride));
  return conjugate(body.rotation) * (place - body.position) / gallop.scale;
}

Step gallop_step(const Gallop& gallop, uint32_t leg, double time) {
  const bool fore = leg < 2;
  const double since = stride_at(gallop, time) - touch_down(gallop, leg);
  const double count = std::floor(since);
  const auto share = static_cast<float>(since - count);
  const float landing = fore ? -0.30f : -0.12f, leaving = fore ? 0.55f : 0.70f;
  Step step;
  if (share < kGallopDuty) {
    const float s = share / kGallopDuty;
    step.ball = to_horse(gallop, standing_place(gallop, leg, count), stride_at(gallop, time));
    step.pitch = glm::mix(landing, leaving, s * s);
    step.toe_pitch = 0.55f * glm::smoothstep(0.55f, 1.0f, s);
    return step;
  }
  // In the air: from where the hoof left to where it will land, both seen from the moving body,
  // beginning and ending with some of the ground's speed.
  const float s = (share - kGallopDuty) / (1.0f - kGallopDuty);
  const double down = count + touch_down(gallop, leg);
  const vec3 from = to_horse(gallop, standing_place(gallop, leg, count), down + kGallopDuty);
  const vec3 to = to_horse(gallop, standing_place(gallop, leg, count + 1.0), down + 1.0);
  const float way = gallop.speed * gallop.stride_seconds * (1.0f - kGallopDuty) / gallop.scale;
  const vec3 tangent(0.0f, 0.0f, -0.40f * way);
  const float s2 = s * s, s3 = s2 * s;
  step.ball = (2.0f * s3 - 3.0f * s2 + 1.0f) * from + (s3 - 2.0f * s2 + s) * tangent +
              (3.0f * s2 - 2.0f * s3) * to + (s3 - s2) * tangent;
  const float half = std::sin(0.5f * kTwoPi * std::pow(s, 0.85f)), fold = half * half;
  step.ball.y += (fore ? 0.40f : 0.34f) * fold;
  step.pitch =
      glm::mix(leaving, landing, glm::smoothstep(0.0f, 1.0f, s)) + (fore ? 1.15f : 0.55f) * fold;
  step.toe_pitch = 0.55f * glm::smoothstep(1.0f, 0.4f, s) + (fore ? 1.55f : 1.05f) * fold;
  return step;
}

}  // namespace

bool hoof_stands(const Gallop& gallop, uint32_t leg, double time) {
  const double since = stride_at(gallop, time) - touch_down(gallop, leg);
  return since - std::floor(since) < kGallopDuty;
}

HorsePose gallop_pose(const Gallop& gallop, double time) {
  const double stride = stride_at(gallop, time);
  const auto u = static_cast<float>(stride - std::floor(stride));
  HorsePose pose;
  pose.rotation.fill(glm::identity<quat>());
  // Highest when all hooves are in the air, croup up while the fore hooves stand; the back rounds
  // as the hind legs come forward, and the neck takes back what the trunk does.
  pose.croup =
      horse_skeleton()[kCroup].position + vec3(0.0f, -0.072f + 0.045f * swing(u, 0.80f), 0.0f);
  const float rock = 0.085f * swing(u, 0.55f), round = 0.10f * swing(u, 0.93f);
  pose.rotation[kCroup] = glm::angleAxis(rock - 0.9f * round, kX);
  pose.rotation[kLoin] = glm::angleAxis(0.9f * round, kX);
  pose.rotation[kWithers] = glm::angleAxis(0.5f * round, kX);
  pose.rotation[kNeck] = glm::angleAxis(0.16f - 0.4f * rock + 0.08f * swing(u, 0.62f), kX);
  pose.rotation[kNape] = glm::angleAxis(0.10f + 0.07f * swing(u, 0.68f), kX);
  pose.rotation[kSkull] = glm::angleAxis(-0.30f - 0.10f * swing(u, 0.70f), kX);
  for (uint32_t i = 0; i < kHorseTail; ++i) {
    const float k = static_cast<float>(i);
    pose.rotation[kDock + i] =
        glm::angleAxis(0.10f * std::sin(kTwoPi * (0.5f * static_cast<float>(stride) - 0.11f * k)),
                       kY) *
        glm::angleAxis((i == 0 ? 0.42f : 0.14f) + 0.10f * swing(u, 0.15f + 0.12f * k), kX);
  }
  std::array<JointFrame, kHorseJoints> frames;
  joint_frames(horse_skeleton(), pose.croup, pose.rotation, frames);
  for (uint32_t leg = 0; leg < kHorseLegCount; ++leg) {
    const LegJoints joints = horse_leg(leg);
    const auto trunk = static_cast<size_t>(horse_skeleton()[joints[kUpper]].parent);
    plant(horse_skeleton(), joints, gallop_step(gallop, leg, time), frames[trunk], pose.rotation);
  }
  return pose;
}

}  // namespace sinew
