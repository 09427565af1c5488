#include "sinew/bvh/frames/segment_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"

namespace sinew {
namespace {

constexpr uint32_t kModelFrames = 128;
constexpr uint32_t kModelPrimitives = 4096;
constexpr int kMoves = 2;  // how often boundaries move and trees follow

}  // namespace

double rebuild_cost(std::vector<Box> boxes, const SegmentConfig& config) {
  const CostModel& model = config.optimize.cost;
  if (config.rebuild == Rebuild::binned) {
    const Tree tree = build_binned(boxes, {.max_leaf = 1});
    return sah_cost(tree, refit(tree, boxes), model);
  }
  FrameBoxes frame;
  frame.frames.push_back(std::move(boxes));
  frame.weights = {1.0};
  OptimizeConfig optimize = config.optimize;
  optimize.on_step = nullptr;  // it is told of the segments' trees only
  const Tree tree = build_optimized(frame, optimize);
  return sah_cost(tree, refit(tree, frame.frames[0]), model);
}

SegmentSearch::SegmentSearch(const AnimatedBoxes& animation, const SegmentConfig& config)
    : config_(config) {
  config_.optimize.on_step = nullptr;  // it is told of full trees only
  frames_ = evenly_spread(0, animation.frame_count() - 1, kModelFrames);
  model_ = sample_boxes(animation, frames_,
                        sample_primitives(animation.primitive_count, kModelPrimitives));
  model_.weights =
      weights_by_nearness(frames_, 0, frame_weights(animation, 0, animation.frame_count() - 1));

  std::vector<double> rebuilt(frames_.size());
  parallel_for(frames_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      rebuilt[f] = sinew::rebuild_cost(model_.frames[f], config_);
    }
  });
  for (size_t f = 0; f < frames_.size(); ++f) rebuild_cost_ += model_.weights[f] * rebuilt[f];

  find_parts(animation, config.boundaries);
  estimate_intervals();
  find_coarse_cuts(config.most_segments);
}

// Parts of equal time; those without a frame do not exist. Where all times are equal there is one.
void SegmentSearch::find_parts(const AnimatedBoxes& animation, uint32_t boundaries) {
  const double begin = animation.times.front(), length = animation.times.back() - begin;
  double part_of_last = -1.0;
  for (uint32_t f = 0; f < frames_.size(); ++f) {
    const double place = length > 0.0 ? (animation.times[frames_[f]] - begin) / length : 0.0;
    const double part = std::min(std::floor(place * boundaries), boundaries - 1.0);
    if (part > part_of_last) parts_.push_back(f);
    part_of_last = std::max(part, part_of_last);
  }
  parts_.push_back(static_cast<uint32_t>(frames_.size()));
}

double SegmentSearch::cost_of(const Tree& tree, uint32_t frame) const {
  return sah_cost(tree, refit(tree, model_.frames[frame]), config_.optimize.cost);
}

SegmentSearch::Estimate SegmentSearch::estimate(Interval interval, Effort effort) const {
  const std::vector<uint32_t> chosen =
      evenly_spread(interval.first, interval.last, config_.representatives);
  FrameBoxes representatives;
  for (const uint32_t f : chosen) representatives.frames.push_back(model_.frames[f]);
  const std::span<const double> weights = model_.weights;
  representatives.weights = weights_by_nearness(
      chosen, interval.first, weights.subspan(interval.first, interval.last - interval.first + 1));
  double sum = 0.0;
  for (const double weight : representatives.weights) sum += weight;
  for (double& weight : representatives.weights) {
    weight = sum > 0.0 ? weight / sum : 1.0 / static_cast<double>(chosen.size());
  }

  Estimate out;
  out.tree = effort == Effort::build ? build_over_frames(representatives, config_.optimize)
                                     : build_optimized(representatives, config_.optimize);
  for (uint32_t f = interval.first; f <= interval.last; ++f) {
    out.cost += model_.weights[f] * cost_of(out.tree, f);
  }
  return out;
}

void SegmentSearch::estimate_intervals() {
  const size_t count = part_count();
  interval_costs_.assign(count * count, 0.0);
  parallel_for(count * count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t first = i / count, last = i % count;
      if (first > last) continue;
      interval_costs_[i] = estimate({parts_[first], parts_[last + 1] - 1}, Effort::build).cost;
    }
  });
}

void SegmentSearch::find_coarse_cuts(uint32_t most_segments) {
  const uint32_t count = part_count();
  coarse_.assign(1, std::vector<double>(interval_costs_.begin(), interval_costs_.begin() + count));
  before_.assign(1, std::vector<uint32_t>(count, 0));
  for (uint32_t segments = 2; segments <= std::min(most_segments, count); ++segments) {
    const std::vector<double>& fewer = coarse_.back();
    std::vector<double> costs(count, std::numeric_limits<double>::infinity());
    std::vector<uint32_t> firsts(count, 0);
    for (uint32_t last = segments - 1; last < count; ++last) {
      for (uint32_t first = segments - 1; first <= last; ++first) {
        const double cost = fewer[first - 1] + interval_costs_[first * count + last];
        if (cost < costs[last]) {
          costs[last] = cost;
          firsts[last] = first;
        }
      }
    }
    coarse_.push_back(std::move(costs));
    before_.push_back(std::move(firsts));
  }
}

std::vector<SegmentSearch::Interval> SegmentSearch::coarse_cut(uint32_t segments) const {
  std::vector<Interval> cut;
  uint32_t end = part_count();
  for (uint32_t s = segments; s > 0; --s) {
    const uint32_t first = before_[s - 1][end - 1];
    cut.push_back({parts_[first], parts_[end] - 1});
    end = first;
  }
  std::reverse(cut.begin(), cut.end());
  return cut;
}

// Each boundary goes where frames before it cost less in the tree on its left, and those after it
// less in the one on its right. Every segment keeps a frame.
std::vector<SegmentSearch::Interval> SegmentSearch::moved(
    const std::vector<Interval>& cut, const std::vector<Estimate>& estimates) const {
  std::vector<Interval> out = cut;
  for (size_t s = 0; s + 1 < out.size(); ++s) {
    const uint32_t first = out[s].first, last = out[s + 1].last;
    std::vector<double> change(last - first + 1);  // by which the left tree is dearer
    parallel_for(change.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const auto f = static_cast<uint32_t>(first + i);
        change[i] =
            model_.weights[f] * (cost_of(estimates[s].tree, f) - cost_of(estimates[s + 1].tree, f));
      }
    });
    double sum = 0.0, least = std::numeric_limits<double>::infinity();
    for (uint32_t f = first; f < last; ++f) {
      sum += change[f - first];
      if (sum < least) {
        least = sum;
        out[s].last = f;
      }
    }
    out[s + 1].first = out[s].last + 1;
  }
  return out;
}

Cut SegmentSearch::best_cut(uint32_t segments) const {
  SINEW_CHECK(segments >= 1 && segments <= coarse_.size());
  std::vector<Interval> cut = coarse_cut(segments);
  const auto estimate_all = [&](const std::vector<Interval>& intervals) {
    std::vector<Estimate> out(intervals.size());
    parallel_for(out.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) out[i] = estimate(intervals[i], Effort::optimize);
    });
    return out;
  };
  const auto total = [](const std::vector<Estimate>& estimates) {
    double sum = 0.0;
    for (const Estimate& e : estimates) sum += e.cost;
    return sum;
  };
  std::vector<Estimate> estimates = estimate_all(cut);
  for (int i = 0; i < kMoves; ++i) {
    std::vector<Interval> candidate = moved(cut, estimates);
    std::vector<Estimate> candidate_estimates = estimate_all(candidate);
    if (!(total(candidate_estimates) < total(estimates))) break;
    cut = std::move(candidate);
    estimates = std::move(candidate_estimates);
  }
  Cut out;
  out.cost = total(estimates);
  for (const Interval& interval : cut) out.first_frames.push_back(frames_[interval.first]);
  return out;
}

}  // namespace sinew
