#include "sinew/world/body_animation.h"

#include <algorithm>
#include <cmath>

#include "sinew/bvh/bounds.h"
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

constexpr double kDefaultFps = 24.0;

std::vector<double> times_of(const Scene& scene, int clip, bool moves, uint32_t most) {
  if (clip == kRestPose) return {0.0};
  const Clip& c = scene.clips[static_cast<size_t>(clip)];
  if (!moves || !(c.end > c.start)) return {c.start};
  const double fps = scene.default_fps > 0.0 ? scene.default_fps : kDefaultFps;
  const double wanted = std::ceil((c.end - c.start) * fps) + 1.0;
  const auto count = static_cast<uint32_t>(std::clamp(wanted, 2.0, double(std::max(most, 2u))));
  std::vector<double> times(count);
  for (uint32_t i = 0; i < count; ++i) {
    times[i] = c.start + (c.end - c.start) * (double(i) / double(count - 1));
  }
  return times;
}

}  // namespace

int32_t object_in_frame(const SceneBody& body, const ScenePose& pose, uint32_t frame) {
  const size_t count = body.objects.size();
  for (size_t i = 0; i < count; ++i) {
    const uint32_t object = body.objects[(frame + i) % count];
    if (pose.objects[object].present) return static_cast<int32_t>(object);
  }
  return -1;
}

AnimatedBoxes body_animation(const Scene& scene, const SceneBody& body, int clip,
                             uint32_t most_frames) {
  const Mesh& mesh = scene.meshes[body.mesh];
  const Motion motion = motion_of(mesh, body.skinned);
  AnimatedBoxes out;
  out.primitive_count = static_cast<uint32_t>(mesh.triangles.size());
  out.times = times_of(scene, clip, deforms(motion), most_frames);
  const auto boxes_at = [&scene, &body, &mesh, motion, clip](double time, uint32_t frame,
                                                             std::span<Box> boxes) {
    ScenePose pose;
    sample(scene, clip, time, pose);
    const int32_t object = object_in_frame(body, pose, frame);
    if (object < 0 && deforms(motion)) {
      std::ranges::fill(boxes, Box());
      return;
    }
    const Pose& at = object < 0 ? Pose() : pose.objects[static_cast<size_t>(object)];
    std::vector<vec3> positions;
    all_positions(motion, at, positions);
    triangle_boxes(positions, mesh.triangles, boxes);
  };
  out.boxes = [boxes_at, times = out.times](uint32_t frame, std::span<Box> boxes) {
    boxes_at(times[frame], frame, boxes);
  };
  return out;
}

}  // namespace sinew
