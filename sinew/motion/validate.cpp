// Whether a motion holds together, and whether a pose fits it.
#include <algorithm>

#include "sinew/motion/keyframes.h"
#include "sinew/motion/morph.h"
#include "sinew/motion/motion.h"

namespace sinew {
namespace {

bool fits(const RigidMotion&, const Pose&) {
  return true;
}
bool fits(const SkinMotion& motion, const Pose& pose) {
  return pose.joints.size() >= motion.joint_count;
}
bool fits(const MorphMotion& motion, const Pose& pose) {
  return pose.weights.size() == target_count(motion) && fits(motion.skin, pose);
}
bool fits(const KeyframeMotion& motion, const Pose& pose) {
  const uint32_t keys = key_count(motion);
  if (motion.vertex_count == 0) return true;
  if (pose.key >= keys || !(pose.key_fraction >= 0.0f && pose.key_fraction <= 1.0f)) return false;
  return pose.key + 1 < keys || pose.key_fraction == 0.0f;
}
bool fits(const FreeMotion& motion, const Pose& pose) {
  const VertexRange changed = pose.changed;
  const bool all = changed.first == 0 && changed.count >= motion.vertex_count;
  return pose.positions.size() == motion.vertex_count &&
         (all || uint64_t{changed.first} + changed.count <= motion.vertex_count);
}

std::string problem(const RigidMotion&) {
  return {};
}
std::string problem_of_skin(const SkinMotion& skin, size_t vertices) {
  if (skin.joints.size() != vertices * skin.influences) {
    return "skin: the count of joint indices is not vertices * influences";
  }
  if (skin.weights.size() != skin.joints.size()) {
    return "skin: the count of weights is not that of joint indices";
  }
  const auto largest = std::ranges::max_element(skin.joints);
  if (largest != skin.joints.end() && *largest >= skin.joint_count) {
    return "skin: joint index " + std::to_string(*largest) + " where there are " +
           std::to_string(skin.joint_count) + " joints";
  }
  return {};
}
std::string problem(const SkinMotion& motion) {
  if (motion.influences == 0) return "skin: no influences";
  return problem_of_skin(motion, motion.rest.size());
}
std::string problem(const MorphMotion& motion) {
  const size_t stride = motion.rest.size();
  if (stride == 0 ? !motion.deltas.empty() : motion.deltas.size() % stride != 0) {
    return "morph: the count of deltas is no multiple of the vertices";
  }
  return problem_of_skin(motion.skin, motion.skin.influences == 0 ? 0 : stride);
}
std::string problem(const KeyframeMotion& motion) {
  if (motion.vertex_count == 0) return motion.keys.empty() ? "" : "keyframes: keys of no vertices";
  if (motion.keys.empty()) return "keyframes: no keys";
  if (motion.keys.size() % motion.vertex_count != 0) {
    return "keyframes: the count of positions is no multiple of the vertices";
  }
  return {};
}
std::string problem(const FreeMotion&) {
  return {};
}

}  // namespace

bool pose_fits(const Motion& motion, const Pose& pose) {
  return std::visit([&](const auto& m) { return fits(m, pose); }, motion);
}

std::string validate(const Motion& motion) {
  return std::visit([](const auto& m) { return problem(m); }, motion);
}

}  // namespace sinew
