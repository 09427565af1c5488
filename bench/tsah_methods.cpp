#include "bench/tsah_methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bench/measure.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/bvh/frames/segments.h"
#include "sinew/bvh/tsah/tsah_reference.h"

namespace sinew::bench {
namespace {

constexpr CostModel kPaperCost{};  // c_T = 3, c_I = 2
constexpr uint32_t kMostInLeaf = 8;
constexpr uint32_t kSegmentFrames = 50;                      // that segments are chosen from
constexpr double kLargeScene = 5e5, kMiddlingScene = 1.5e5;  // triangles

template <class Make>
MethodTrees one_tree(std::string name, const FrameBoxes& frames, uint32_t exponent,
                     const Make& make) {
  MethodTrees out{.name = std::move(name)};
  Tree deep;
  out.seconds = 1e-3 * milliseconds([&] { deep = make(); });
  out.parts.push_back(finish(deep, frames, exponent, 0.0));
  return out;
}

MethodTrees tsah(std::string name, const FrameBoxes& frames, uint32_t exponent) {
  return one_tree(std::move(name), frames, exponent,
                  [&] { return build_optimized(frames, OptimizeConfig{.exponent = exponent}); });
}

std::vector<double> weights_of(const Tree& deep, const FrameBoxes& frames, uint32_t exponent) {
  return area_weights(deep, frames, frame_costs(deep, frames, kPaperCost), exponent);
}

double average(std::span<const double> costs) {
  double sum = 0.0;
  for (const double cost : costs) sum += cost;
  return sum / double(std::max<size_t>(costs.size(), 1));
}

// Frames that stand for the animation better than even ones may, chosen by what their trees cost in
// the others. The time to choose them counts.
MethodTrees tsah_of_medoids(const FlatClip& clip, uint32_t representatives) {
  const AnimatedBoxes animation = clip.animation(kSegmentFrames);
  FrameBoxes frames;
  const double choosing = 1e-3 * milliseconds([&] {
                            std::vector<double> weights;
                            const std::vector<uint32_t> chosen =
                                choose_frames(animation, 0, kSegmentFrames - 1, representatives,
                                              FrameChoice::medoids, &weights);
                            frames = sample_frames(animation, chosen, weights);
                          });
  MethodTrees out = tsah(fmt::format("{}, medoids", kTsah), frames, 0);
  out.seconds += choosing;
  out.note = fmt::format("{} frames", frames.frame_count());
  return out;
}

// T's own algorithm.
void add_reference(const FlatClip& clip, uint32_t representatives, std::vector<MethodTrees>& out) {
  const FrameBoxes frames = boxes_at(clip, even_frames(representatives));
  for (const uint32_t k : {0u, 2u, 4u}) {
    out.push_back(one_tree(fmt::format("T-SAH reference k={}", k), frames, k,
                           [&] { return build_tsah(frames, TsahConfig{.exponent = double(k)}); }));
  }
}

// The tree of a single frame that costs least over the animation. The middle frame is among the
// candidates.
MethodTrees best_over_time(const FlatClip& clip) {
  const double n = clip.triangle_count();
  const uint32_t candidates = n > kLargeScene ? 3 : n > kMiddlingScene ? 5 : 9;
  const FrameBoxes judged = boxes_at(clip, even_frames(n > kLargeScene ? 5 : 13));
  MethodTrees out{.name = std::string(kSahBest)};
  double least = 0.0, where = 0.0;
  for (const double u : even_frames(candidates)) {
    const FrameBoxes frame = boxes_at(clip, std::span(&u, 1));
    Tree deep;
    double cost = 0.0;
    out.seconds += 1e-3 * milliseconds([&] {
                     deep = best_tree_of_frame(frame);
                     cost = average(frame_costs(deep, judged, kPaperCost));
                   });
    if (!out.parts.empty() && cost >= least) continue;
    least = cost, where = u;
    out.parts = {finish(deep, frame, 0, 0.0)};
  }
  out.note = fmt::format("best of {} candidates: the frame at {:.0f}%", candidates, 100.0 * where);
  return out;
}

// T's three trees for its Museum: 0-32, 33-65 and 66-99 percent.
MethodTrees thirds(const FlatClip& clip, uint32_t representatives) {
  MethodTrees out{.name = std::string(kSegments3)};
  for (int i = 0; i < 3; ++i) {
    std::vector<double> u = even_frames(representatives);
    for (double& at : u) at = (i + at) / 3.0;
    const FrameBoxes frames = boxes_at(clip, u);
    Tree deep;
    out.seconds += 1e-3 * milliseconds([&] { deep = build_optimized(frames); });
    out.parts.push_back(finish(deep, frames, 0, i / 3.0));
  }
  return out;
}

Result<MethodTrees> automatic_segments(const FlatClip& clip, uint32_t representatives) {
  MethodTrees out{.name = std::string(kSegmentsAuto)};
  const AnimatedBoxes animation = clip.animation(kSegmentFrames);
  Result<std::vector<Segment>> segments;
  out.seconds = 1e-3 * milliseconds([&] {
                  segments = cut_into_segments(
                      animation, {.representatives = representatives, .most_segments = 4});
                });
  if (!segments) return fail(std::move(segments).error());
  for (const Segment& segment : *segments) {
    out.parts.push_back(finish(segment.tree, segment.frames, 0, segment.begin));
    out.note += fmt::format("{}{:.2f}", out.note.empty() ? "begin at " : ", ", segment.begin);
  }
  return out;
}

void add_single_frame_trees(const FlatClip& clip, std::vector<MethodTrees>& out) {
  const double first = 0.0, middle = 0.5;
  const FrameBoxes first_frame = boxes_at(clip, std::span(&first, 1));
  const FrameBoxes middle_frame = boxes_at(clip, std::span(&middle, 1));
  out.push_back(
      one_tree(std::string(kSahFirst), first_frame, 0, [&] { return sweep_tree(first_frame); }));
  out.push_back(one_tree("SAH0 + insertion", first_frame, 0,
                         [&] { return best_tree_of_frame(first_frame); }));
  out.push_back(one_tree(std::string(kSahMiddle), middle_frame, 0,
                         [&] { return best_tree_of_frame(middle_frame); }));
  out.push_back(best_over_time(clip));
}

}  // namespace

const TreePart& MethodTrees::at(double u) const {
  size_t i = 0;
  while (i + 1 < parts.size() && parts[i + 1].begin <= u) ++i;
  return parts[i];
}

FrameBoxes boxes_at(const FlatClip& clip, std::span<const double> u) {
  std::vector<std::vector<Box>> frames(u.size(), std::vector<Box>(clip.triangle_count()));
  for (size_t i = 0; i < u.size(); ++i) clip.boxes(u[i], frames[i]);
  return make_frame_boxes(std::move(frames));
}

std::vector<double> even_frames(uint32_t count) {
  std::vector<double> u;
  for (uint32_t i = 0; i < count; ++i) u.push_back(frame_at(i, count));
  return u;
}

Tree sweep_tree(const FrameBoxes& frame) {
  return build_sweep(frame.frames[0], {.traversal_cost = kPaperCost.traversal,
                                       .intersection_cost = kPaperCost.intersection,
                                       .leaf_block = 1,
                                       .max_leaf = 1});
}

Tree best_tree_of_frame(const FrameBoxes& frame) {
  return optimize(sweep_tree(frame), frame);
}

Tree cost_leaves(const Tree& deep, const FrameBoxes& frames, uint32_t exponent) {
  return collapse_leaves(deep, frames, weights_of(deep, frames, exponent), kPaperCost, 1,
                         kMostInLeaf);
}

TreePart finish(const Tree& deep, const FrameBoxes& frames, uint32_t exponent, double begin) {
  TreePart out{.begin = begin};
  out.tree = cost_leaves(deep, frames, exponent);
  TimedTree traced = traced_tree(deep, frames, exponent);
  out.traced = std::move(traced.tree);
  out.areas = std::move(traced.areas);
  return out;
}

Result<std::vector<MethodTrees>> make_methods(const FlatClip& clip, const MethodConfig& config) {
  std::vector<MethodTrees> out;
  add_single_frame_trees(clip, out);
  const uint32_t few = config.representatives, many = 2 * few;
  {
    const FrameBoxes frames = boxes_at(clip, even_frames(few));
    for (const uint32_t k : {0u, 2u, 4u}) {
      out.push_back(tsah(fmt::format("T-SAH k={}", k), frames, k));
    }
  }
  out.push_back(
      tsah(fmt::format("{}, {} frames", kTsah, many), boxes_at(clip, even_frames(many)), 0));
  out.push_back(tsah_of_medoids(clip, few));
  if (config.reference) add_reference(clip, few, out);
  if (config.segments) {
    out.push_back(thirds(clip, few));
    SINEW_TRY(MethodTrees automatic, automatic_segments(clip, few));
    out.push_back(std::move(automatic));
  }
  return out;
}

const MethodTrees* find(std::span<const MethodTrees> methods, std::string_view name) {
  const auto found = std::ranges::find(methods, name, &MethodTrees::name);
  return found == methods.end() ? nullptr : &*found;
}

}  // namespace sinew::bench
