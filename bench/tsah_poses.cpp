#include "bench/tsah_poses.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <utility>
#include <vector>

#include "bench/tsah_methods.h"
#include "bench/workload.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/bvh/frames/segments.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kFrames = 10;  // of every clip
constexpr std::array kCharacters = {
    std::pair("robot-expressive", "skinned/robot-expressive/RobotExpressive.glb"),
    std::pair("fox", "khronos-gltf/Fox/glTF-Binary/Fox.glb")};

// The vertices of a character in some frames of all its clips, and at rest.
class Poses {
 public:
  explicit Poses(const Scene& scene) {
    ScenePose pose;
    FlatScene flat;
    sample(scene, kRestPose, 0.0, pose);
    flatten(scene, pose, flat);
    triangles_ = flat.triangles;
    rest_ = boxes_of(flat.positions);
    for (int c = 0; c < static_cast<int>(scene.clips.size()); ++c) {
      const Clip& clip = scene.clips[static_cast<size_t>(c)];
      auto& frames = clips_.emplace_back();
      for (uint32_t f = 0; f < kFrames; ++f) {
        sample(scene, c, clip.start + (clip.end - clip.start) * f / (kFrames - 1), pose);
        flatten(scene, pose, flat);
        frames.push_back(flat.positions);
      }
    }
  }

  size_t clips() const { return clips_.size(); }
  size_t triangles() const { return triangles_.size(); }
  const std::vector<Box>& rest() const { return rest_; }

  std::vector<Box> boxes(size_t clip, uint32_t frame) const {
    return boxes_of(clips_[clip][frame]);
  }
  // Half of the one, half of the other, vertex by vertex.
  std::vector<Box> blended(size_t a, size_t b, uint32_t frame) const {
    std::vector<vec3> positions = clips_[a][frame];
    for (size_t i = 0; i < positions.size(); ++i) {
      positions[i] = 0.5f * (positions[i] + clips_[b][frame][i]);
    }
    return boxes_of(positions);
  }
  AnimatedBoxes animation(size_t clip) const {
    AnimatedBoxes out;
    out.primitive_count = static_cast<uint32_t>(triangles_.size());
    for (uint32_t f = 0; f < kFrames; ++f) out.times.push_back(f);
    out.boxes = [this, clip](uint32_t frame, std::span<Box> boxes) {
      triangle_boxes(clips_[clip][frame], triangles_, boxes);
    };
    return out;
  }

 private:
  std::vector<Box> boxes_of(std::span<const vec3> positions) const {
    std::vector<Box> boxes(triangles_.size());
    triangle_boxes(positions, triangles_, boxes);
    return boxes;
  }

  std::vector<uvec3> triangles_;
  std::vector<Box> rest_;
  std::vector<std::vector<std::vector<vec3>>> clips_;  // [clip][frame][vertex]
};

Tree tree_for(const AnimatedBoxes& animation, uint32_t representatives) {
  std::vector<double> weights;
  const std::vector<uint32_t> chosen = choose_frames(
      animation, 0, animation.frame_count() - 1, representatives, FrameChoice::medoids, &weights);
  return build_optimized(sample_frames(animation, chosen, weights));
}

void measure_held_out(const std::string& name, const Scene& scene, const Poses& poses,
                      uint32_t representatives, json& rows) {
  const Tree at_rest = build_optimized(make_frame_boxes({poses.rest()}));
  for (size_t held = 0; held < poses.clips(); ++held) {
    std::vector<AnimatedBoxes> others;
    for (size_t c = 0; c < poses.clips(); ++c) {
      if (c != held) others.push_back(poses.animation(c));
    }
    const Tree of_others = tree_for(join_clips(std::move(others)), representatives);
    const Tree own = tree_for(poses.animation(held), representatives);
    const size_t next = (held + 1) % poses.clips();
    for (const bool blend : {false, true}) {
      std::vector<std::vector<Box>> frames;
      double rebuild = 0.0;
      for (uint32_t f = 0; f < kFrames; ++f) {
        frames.push_back(blend ? poses.blended(held, next, f) : poses.boxes(held, f));
        const FrameBoxes one = make_frame_boxes({frames.back()});
        rebuild += frame_costs(build_optimized(one), one)[0] / kFrames;
      }
      const FrameBoxes judged = make_frame_boxes(std::move(frames));
      const auto average = [&](const Tree& tree) {
        return power_cost(frame_costs(tree, judged), judged.weights, 0.0);
      };
      rows.push_back({{"table", "tsah_poses"},
                      {"scene", name},
                      {"triangles", poses.triangles()},
                      {"held_out", scene.clips[held].name},
                      {"blended_with", blend ? scene.clips[next].name : ""},
                      {"others", average(of_others)},
                      {"own", average(own)},
                      {"rest_pose", average(at_rest)},
                      {"rebuild", rebuild}});
    }
  }
}

}  // namespace

Result<void> measure_poses(const TsahOptions& options, json& rows, json& skipped) {
  for (const auto& [name, path] : kCharacters) {
    const std::string file = options.data + "/" + path;
    if (!std::filesystem::exists(file)) {
      skipped.push_back(fmt::format("{}: {} is not there (say where with --data)", name, file));
      continue;
    }
    SINEW_TRY(const Scene scene, load(file));
    measure_held_out(name, scene, Poses(scene), options.representatives, rows);
  }
  return {};
}

std::string poses_text(const json& rows) {
  std::string out, scene;
  for (const json& row : rows) {
    if (row["table"] != "tsah_poses") continue;
    if (scene != row["scene"]) {
      scene = row["scene"];
      out += fmt::format(
          "\n{}: {} triangles; a tree for all clips but one, in that one\n{:<28} "
          "{:>8} {:>8} {:>8} {:>8}\n",
          scene, row["triangles"].get<size_t>(), "average cost in", "others", "own", "at rest",
          "rebuild");
    }
    const std::string held = row["held_out"], other = row["blended_with"];
    out += fmt::format("{:<28} {:8.2f} {:8.2f} {:8.2f} {:8.2f}\n",
                       other.empty() ? held : fmt::format("  half {}, half {}", held, other),
                       row["others"].get<double>(), row["own"].get<double>(),
                       row["rest_pose"].get<double>(), row["rebuild"].get<double>());
  }
  return out;
}

}  // namespace sinew::bench
