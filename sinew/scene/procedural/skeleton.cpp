#include "sinew/scene/procedural/skeleton.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

// The rotation that carries the plane of (along, beside) to that of (new_along, new_beside).
quat carry(vec3 along, vec3 beside, vec3 new_along, vec3 new_beside) {
  const auto frame = [](vec3 a, vec3 b) {
    const vec3 x = normalize(a), z = normalize(cross(x, b));
    return mat3(x, cross(z, x), z);
  };
  return normalize(
      glm::quat_cast(frame(new_along, new_beside) * glm::transpose(frame(along, beside))));
}

}  // namespace

void joint_frames(Skeleton rest, vec3 root, std::span<const quat> rotations,
                  std::span<JointFrame> frames) {
  for (size_t j = 0; j < rest.size(); ++j) {
    if (rest[j].parent < 0) {
      frames[j] = {rotations[j], root};
      continue;
    }
    const auto p = static_cast<size_t>(rest[j].parent);
    frames[j].rotation = frames[p].rotation * rotations[j];
    frames[j].position =
        frames[p].position + frames[p].rotation * (rest[j].position - rest[p].position);
  }
}

void plant(Skeleton rest, const LegJoints& leg, const Step& step, const JointFrame& trunk,
           std::span<quat> rotations) {
  const auto rest_at = [&](LegJoint i) { return rest[leg[i]].position; };
  const auto parent = static_cast<size_t>(rest[leg[kUpper]].parent);
  const vec3 hip = trunk.position + trunk.rotation * (rest_at(kUpper) - rest[parent].position);

  const quat yaw = glm::angleAxis(step.yaw, vec3(0.0f, 1.0f, 0.0f));
  const vec3 x_axis(1.0f, 0.0f, 0.0f);
  const quat foot = yaw * glm::angleAxis(step.pitch, x_axis);
  const vec3 ankle = step.ball + foot * (rest_at(kFoot) - rest_at(kToes));
  const float upper = length(rest_at(kLower) - rest_at(kUpper));
  const float lower = length(rest_at(kFoot) - rest_at(kLower));
  const vec3 to_ankle = ankle - hip;
  const float reach =
      std::clamp(length(to_ankle), std::abs(upper - lower) + 1e-3f, 0.999f * (upper + lower));
  const vec3 direction = normalize(to_ankle);
  // The knee keeps to the side of the line from hip to ankle that it has at rest.
  const vec3 rest_line = normalize(rest_at(kFoot) - rest_at(kUpper));
  const vec3 rest_knee = rest_at(kLower) - rest_at(kUpper);
  const vec3 rest_side = rest_knee - dot(rest_knee, rest_line) * rest_line;
  vec3 side = glm::slerp(glm::identity<quat>(), trunk.rotation, 0.5f) * rest_side;
  side = normalize(side - dot(side, direction) * direction);
  const float along = (upper * upper - lower * lower + reach * reach) / (2.0f * reach);
  const float out = std::sqrt(std::max(0.0f, upper * upper - along * along));
  const vec3 knee = hip + along * direction + out * side;

  const std::array<quat, kLegJoints> world{
      carry(rest_knee, rest_side, knee - hip, side),
      carry(rest_at(kFoot) - rest_at(kLower), rest_side, hip + reach * direction - knee, side),
      foot, yaw * glm::angleAxis(step.toe_pitch, x_axis)};
  quat above = trunk.rotation;
  for (uint32_t i = 0; i < kLegJoints; ++i) {
    rotations[leg[i]] = conjugate(above) * world[i];
    above = world[i];
  }
}

uint32_t add_skeleton(Scene& scene, Skeleton rest, const std::string& name, int32_t parent) {
  const uint32_t first = static_cast<uint32_t>(scene.nodes.size());
  Skin skin;
  skin.name = name;
  for (const SkeletonJoint& joint : rest) {
    const int32_t above = joint.parent < 0 ? parent : static_cast<int32_t>(first) + joint.parent;
    const vec3 from = joint.parent < 0 ? vec3(0.0f) : rest[joint.parent].position;
    skin.joints.push_back(add_node(scene, joint.name, joint.position - from, above));
    skin.inverse_bind.push_back(trs(-joint.position, glm::identity<quat>(), vec3(1.0f)));
  }
  scene.skins.push_back(std::move(skin));
  return first;
}

}  // namespace sinew
