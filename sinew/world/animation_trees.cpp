#include "sinew/world/animation_trees.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/builders/derived_upper.h"
#include "sinew/bvh/frames/camera_frames.h"
#include "sinew/motion/clusters.h"
#include "sinew/world/animation_key.h"
#include "sinew/world/body_animation.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

constexpr const char* kAllClips = "all";

constexpr uint32_t kFramesReported = 5;  // of rebuilds, where nothing is to be decided by them
constexpr uint32_t kFramesJudged = 25;   // of the poses of all clips
constexpr uint32_t kMostExponent = 64;

// A representative frame: of which clip, and when.
struct FrameTime {
  int clip = kRestPose;
  uint32_t frame = 0;  // within the clip
  double time = 0.0;
};

// One body, and what is known of its animation.
class BodyOptimizer {
 public:
  BodyOptimizer(const Scene& scene, const SceneBody& body, const AnimationTreeOptions& options,
                std::span<const int> clips, OptimizeConfig config)
      : scene_(scene), body_(body), options_(options), config_(std::move(config)) {
    const Mesh& mesh = scene.meshes[body.mesh];
    motion_ = motion_of(mesh, body.skinned);
    const bool moves = deforms(motion_);
    std::vector<AnimatedBoxes> animations;
    for (const int clip : moves ? clips : clips.first(1)) {
      AnimatedBoxes one = body_animation(scene, body, clip, options.most_samples);
      for (uint32_t f = 0; f < one.frame_count(); ++f) frames_.push_back({clip, f, one.times[f]});
      animations.push_back(std::move(one));
    }
    is_one_clip_ = animations.size() == 1;
    animation_ = is_one_clip_ ? std::move(animations.front()) : join_clips(std::move(animations));
    report_ = {.name = mesh.name,
               .triangles = animation_.primitive_count,
               .deforms = moves,
               .frames = animation_.frame_count()};
  }

  Result<std::vector<TimedTree>> run(size_t byte_budget) {
    const auto start = std::chrono::steady_clock::now();
    SINEW_TRY(std::vector<Segment> segments, is_one_clip_ ? cut(byte_budget) : pose_space());
    std::vector<TimedTree> trees;
    for (Segment& segment : segments) {
      add_view(segment);
      trees.push_back(finish(segment));
    }
    report_.segments = static_cast<uint32_t>(segments.size());
    report_.rebuild_cost = is_one_clip_ ? average_rebuild_cost(segments) : 0.0;
    report_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    judge(segments);
    return trees;
  }

  const BodyTreeReport& report() const { return report_; }

 private:
  Result<std::vector<Segment>> cut(size_t byte_budget) const {
    SegmentConfig config;
    config.optimize = config_;
    config.representatives = options_.frames;
    config.choice = options_.choice;
    config.most_segments = options_.most_segments;
    config.cost_limit = options_.cost_limit;
    config.byte_budget = byte_budget;
    if (options_.most_segments == 1) config.measured_frames = kFramesReported;
    return cut_into_segments(animation_, config);
  }

  // One tree for the poses of all clips.
  Result<std::vector<Segment>> pose_space() const {
    Segment all;
    all.last_frame = animation_.frame_count() - 1;
    std::vector<double> weights;
    all.representatives =
        choose_frames(animation_, 0, all.last_frame, options_.frames, options_.choice, &weights);
    all.frames = sample_frames(animation_, all.representatives, weights);
    all.tree = build_optimized(all.frames, config_);
    all.measured_frames = evenly_spread(0, all.last_frame, kFramesJudged);
    const size_t measured = all.measured_frames.size();
    all.measured_weights.assign(measured, 1.0 / double(measured));
    std::vector<Segment> segments;
    segments.push_back(std::move(all));
    return segments;
  }

  // Goes on with the expected camera's views as frames.
  void add_view(Segment& segment) const {
    if (!options_.view || !(options_.view_share > 0.0f)) return;
    const Mesh& mesh = scene_.meshes[body_.mesh];
    std::vector<ViewFrame> views;
    for (size_t i = 0; i < segment.representatives.size(); ++i) {
      const FrameTime& at = frames_[segment.representatives[i]];
      ScenePose pose;
      sample(scene_, at.clip, at.time, pose);
      const int32_t object = object_in_frame(body_, pose, at.frame);
      if (object < 0) continue;
      std::vector<vec3> positions(vertex_count(motion_));
      world_positions(scene_, pose, static_cast<uint32_t>(object), positions);
      ViewFrame view{std::vector<Box>(mesh.triangles.size()), segment.frames.weights[i]};
      view_boxes(positions, mesh.triangles, options_.view(pose), view.boxes);
      views.push_back(std::move(view));
    }
    append_view_frames(segment.frames, std::move(views), options_.view_share);
    segment.tree = optimize(segment.tree, segment.frames, config_);
  }

  TimedTree finish(const Segment& segment) const {
    TimedTree out = traced_tree(segment.tree, segment.frames, options_.exponent);
    out.begin = segment.begin;
    if (!options_.derived_boxes || !report_.deforms || !derivable(motion_)) return out;
    out.tree = over_derived_boxes(out.tree, segment);
    const std::vector<double> costs = frame_costs(out.tree, segment.frames);
    const std::vector<double> g = area_weights(out.tree, segment.frames, costs, options_.exponent);
    out.areas = weighted_areas(out.tree, segment.frames, g);
    return out;
  }

  Tree over_derived_boxes(const Tree& tree, const Segment& segment) const {
    std::vector<ScenePose> poses;
    std::vector<Pose> of_body;
    std::vector<double> weights;
    for (size_t i = 0; i < segment.representatives.size(); ++i) {
      const FrameTime& at = frames_[segment.representatives[i]];
      sample(scene_, at.clip, at.time, poses.emplace_back());
      const int32_t object = object_in_frame(body_, poses.back(), at.frame);
      if (object < 0) continue;
      of_body.push_back(poses.back().objects[static_cast<size_t>(object)]);
      weights.push_back(segment.frames.weights[i]);
    }
    const Mesh& mesh = scene_.meshes[body_.mesh];
    return suit_derived_boxes(tree, motion_, mesh.triangles, of_body, weights, config_);
  }

  // The honest costs: over frames of which most were no representatives, and the same as the
  // rebuilds', so that the quotient is what the cost limit is about.
  void judge(std::span<const Segment> segments) {
    const Segment& first = segments.front();
    const uint32_t middle_frame = (animation_.frame_count() - 1) / 2;
    const Tree middle =
        build_binned(repaired_frame(animation_, middle_frame, first.representatives, first.frames),
                     {.max_leaf = 1});
    for (const Segment& segment : segments) {
      for (size_t i = 0; i < segment.measured_frames.size(); ++i) {
        const std::vector<Box> at = repaired_frame(animation_, segment.measured_frames[i],
                                                   segment.representatives, segment.frames);
        const double weight = segment.share * segment.measured_weights[i];
        const double cost = sah_cost(segment.tree, refit(segment.tree, at));
        report_.cost += weight * cost;
        report_.highest_cost = std::max(report_.highest_cost, cost);
        report_.middle_frame_cost += weight * sah_cost(middle, refit(middle, at));
      }
    }
  }

  const Scene& scene_;
  const SceneBody& body_;
  const AnimationTreeOptions& options_;
  OptimizeConfig config_;
  Motion motion_;
  AnimatedBoxes animation_;
  std::vector<FrameTime> frames_;  // one a frame of animation_
  bool is_one_clip_ = true;
  BodyTreeReport report_;
};

Result<std::vector<int>> clips_of(const Scene& scene, const std::string& name) {
  if (name != kAllClips) {
    SINEW_TRY(const int clip, find_clip(scene, name));
    return std::vector<int>{clip};
  }
  std::vector<int> clips(scene.clips.size());
  std::iota(clips.begin(), clips.end(), 0);
  if (clips.empty()) clips.push_back(kRestPose);
  return clips;
}

Result<void> check_options(const AnimationTreeOptions& options, size_t clips) {
  const auto usage = [](const char* problem, const char* remedy) {
    return fail({ErrorKind::usage, "", "", problem, remedy});
  };
  if (options.frames == 0 || options.most_segments == 0) {
    return usage("a tree needs at least one frame, a clip at least one segment", "give 1 or more");
  }
  if (options.exponent > kMostExponent) {
    return usage("such an exponent leaves one frame alone to count", "give 0 to 64");
  }
  if (clips > 1 && options.most_segments > 1) {
    return usage("the poses of several clips have no order that could be cut into segments",
                 "choose one clip, or one segment");
  }
  if (!(options.view_share >= 0.0f && options.view_share <= 1.0f)) {
    return usage("the camera's share must be between 0 and 1", "give 0.5 for half of the cost");
  }
  return {};
}

// Every body's part of the budget: one tree, and of the rest by its size. 0: no limit.
Result<std::vector<size_t>> share_budget(const Scene& scene, std::span<const SceneBody> bodies,
                                         size_t budget) {
  std::vector<size_t> shares(bodies.size());
  if (budget == 0) return shares;
  uint64_t triangles = 0;
  size_t least = 0;
  for (size_t b = 0; b < bodies.size(); ++b) {
    const size_t count = scene.meshes[bodies[b].mesh].triangles.size();
    shares[b] = bytes_of_trees(static_cast<uint32_t>(count));
    least += shares[b];
    triangles += count;
  }
  if (budget < least) {
    return fail(
        {ErrorKind::usage, "", "",
         "a budget of " + std::to_string(budget) + " bytes is too small for one tree a body",
         "give at least " + std::to_string(least) + " bytes"});
  }
  const uint64_t rest = budget - least, all = std::max<uint64_t>(triangles, 1);
  for (size_t b = 0; b < bodies.size(); ++b) {
    const uint64_t count = scene.meshes[bodies[b].mesh].triangles.size();
    shares[b] += rest / all * count + rest % all * count / all;  // no product overflows
  }
  return shares;
}

}  // namespace

Result<AnimationTrees> optimize_trees(const Scene& scene, const AnimationTreeOptions& options) {
  SINEW_TRY(const std::vector<int> clips, clips_of(scene, options.clip));
  SINEW_CHECKED(check_options(options, clips.size()));
  AnimationTrees out;
  out.trees.key = animation_key(scene);
  out.trees.clip = clips.size() == 1 ? clips.front() : TreeFile::kAllClips;
  const std::vector<SceneBody> bodies = scene_bodies(scene);
  SINEW_TRY(const std::vector<size_t> budgets, share_budget(scene, bodies, options.byte_budget));
  for (uint32_t b = 0; b < bodies.size(); ++b) {
    const Mesh& mesh = scene.meshes[bodies[b].mesh];
    OptimizeConfig config{.exponent = options.exponent};
    if (options.on_step) {
      config.on_step = [&, b](const OptimizeStep& step) {
        return options.on_step({b, static_cast<uint32_t>(bodies.size()), mesh.name, step});
      };
    }
    BodyOptimizer body(scene, bodies[b], options, clips, std::move(config));
    SINEW_TRY(out.trees.bodies.emplace_back(), body.run(budgets[b]));
    out.bodies.push_back(body.report());
  }
  return out;
}

Result<void> check_trees(const TreeFile& trees, const Scene& scene, int clip) {
  const auto unfit = [](std::string problem) {
    return fail({ErrorKind::bad_input, "", "", std::move(problem),
                 "make it again with `sinew optimize`, with the same --hide"});
  };
  const std::vector<SceneBody> bodies = scene_bodies(scene);
  if (trees.key != animation_key(scene) || trees.bodies.size() != bodies.size()) {
    return unfit("its trees were made for another scene, or for other objects of it");
  }
  for (size_t b = 0; b < bodies.size(); ++b) {
    const size_t triangles = scene.meshes[bodies[b].mesh].triangles.size();
    if (trees.bodies[b].front().tree.primitives.size() != triangles) {
      return unfit("its trees were made for other meshes");
    }
    if (trees.bodies[b].size() > 1 && trees.clip != clip) {
      return unfit("its trees follow another clip");
    }
  }
  return {};
}

}  // namespace sinew
