#include "sinew/bvh/frames/segments.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/frames/segment_search.h"

namespace sinew {
namespace {

constexpr uint32_t kLeastMeasuredFrames = 3;  // of a segment
constexpr size_t kBuffers = 4;                // of them at once
constexpr int kMostCuts = 3;                  // that are tried in full

// Frames between those that evenly_spread() makes representatives, as far as there are any.
std::vector<uint32_t> frames_between(uint32_t first, uint32_t last, uint32_t count) {
  const std::vector<uint32_t> spread = evenly_spread(first, last, 2 * count + 1);
  if (spread.size() <= 2 * count) return spread;
  std::vector<uint32_t> out;
  for (size_t i = 1; i < spread.size(); i += 2) out.push_back(spread[i]);
  return out;
}

double ratio(std::span<const Segment> segments) {
  const double rebuild = average_rebuild_cost(segments);
  return rebuild > 0.0 ? average_cost(segments) / rebuild : 1.0;
}

// The small model's cuts, made when asked for.
struct Model {
  explicit Model(SegmentSearch made) : search(std::move(made)) {}

  const Cut& cut(uint32_t segments) {
    while (cuts.size() < segments) {
      cuts.push_back(search.best_cut(static_cast<uint32_t>(cuts.size()) + 1));
    }
    return cuts[segments - 1];
  }
  // By how much the cut is dearer than new trees, as a share of these.
  double excess(uint32_t segments) { return cut(segments).cost / search.rebuild_cost() - 1.0; }

  SegmentSearch search;
  std::vector<Cut> cuts;  // into 1, 2, ...
};

class Cutter {
 public:
  Cutter(const AnimatedBoxes& animation, const SegmentConfig& config, uint32_t most_segments)
      : animation_(animation),
        config_(config),
        most_segments_(most_segments),
        weights_(frame_weights(animation, 0, animation.frame_count() - 1)),
        measured_(frames_between(0, animation.frame_count() - 1, config.measured_frames)) {
    if (!config.optimize.on_step) return;
    config_.optimize.on_step = [this, on_step = config.optimize.on_step](const OptimizeStep& step) {
      if (!on_step(step)) stopped_ = true;
      return !stopped_;
    };
  }
  Cutter(const Cutter&) = delete;  // on_step knows where this stands
  Cutter& operator=(const Cutter&) = delete;

  std::vector<Segment> run() {
    std::vector<Segment> best = make_segments({0});
    if (most_segments_ == 1 || is_good_enough(best)) return best;
    SegmentConfig search_config = config_;
    search_config.most_segments = most_segments_;
    Model model(SegmentSearch(animation_, search_config));
    if (!(model.search.rebuild_cost() > 0.0)) return best;

    double measured = ratio(best);
    uint32_t segments = 1;
    for (int tries = 0; tries < kMostCuts; ++tries) {
      const uint32_t next = next_count(model, segments, measured);
      if (next == segments) break;
      segments = next;
      std::vector<Segment> cut = make_segments(model.cut(segments).first_frames);
      measured = ratio(cut);
      const bool good = is_good_enough(cut);
      if (good || worth(measured, segments) < worth(ratio(best), best.size())) {
        best = std::move(cut);
      }
      if (good) break;
    }
    return best;
  }

 private:
  bool is_good_enough(std::span<const Segment> segments) const {
    return stopped_ || ratio(segments) <= config_.cost_limit;
  }

  // The lower, the better: a tree more must lower the cost by least_gain.
  double worth(double cost, size_t segments) const {
    return cost * std::pow(1.0 - config_.least_gain, -static_cast<double>(segments));
  }

  // How many segments to try next, more than now, or as many as now if no more are worth it.
  // `measured` is what the ratio really is for as many as now: what the model's ratio exceeds 1 by
  // tells more of how much cuts gain than of how much full trees cost.
  uint32_t next_count(Model& model, uint32_t segments, double measured) const {
    const double trust = std::max((measured - 1.0) / std::max(model.excess(segments), 1e-3), 0.1);
    uint32_t best = segments;
    double best_worth = worth(measured, segments);
    // Two more trees without a gain: others will not help either.
    for (uint32_t s = segments + 1; s <= std::min(model.search.most(), best + 2); ++s) {
      const double expected = 1.0 + trust * std::max(model.excess(s), 0.0);
      if (expected <= config_.cost_limit) return s;
      if (worth(expected, s) < best_worth) {
        best_worth = worth(expected, s);
        best = s;
      }
    }
    return best;
  }

  std::vector<Segment> make_segments(const std::vector<uint32_t>& first_frames) {
    std::vector<Segment> segments;
    for (size_t s = 0; s < first_frames.size(); ++s) {
      const uint32_t end =
          s + 1 < first_frames.size() ? first_frames[s + 1] : animation_.frame_count();
      segments.push_back(make_segment(first_frames[s], end - 1));
    }
    return segments;
  }

  Segment make_segment(uint32_t first, uint32_t last) {
    Segment segment;
    segment.first_frame = first;
    segment.last_frame = last;
    const std::vector<double>& times = animation_.times;
    segment.begin = first == 0 ? times[0] : 0.5 * (times[first - 1] + times[first]);
    std::vector<double> weights;
    segment.representatives =
        choose_frames(animation_, first, last, config_.representatives, config_.choice, &weights);
    segment.frames = sample_frames(animation_, segment.representatives, weights);
    if (animation_.primitive_count > 0) {
      segment.tree = build_optimized(segment.frames, config_.optimize);
    }
    segment.share = 0.0;
    for (uint32_t f = first; f <= last; ++f) segment.share += weights_[f];
    measure(segment);
    return segment;
  }

  void measure(Segment& segment) {
    std::vector<uint32_t> frames;
    for (const uint32_t f : measured_) {
      if (f >= segment.first_frame && f <= segment.last_frame) frames.push_back(f);
    }
    if (frames.size() < kLeastMeasuredFrames) {
      frames = evenly_spread(segment.first_frame, segment.last_frame, kLeastMeasuredFrames);
    }
    std::vector<double> costs(frames.size()), rebuilt(frames.size());
    const size_t grain = (frames.size() + kBuffers - 1) / kBuffers;
    parallel_for(frames.size(), grain, [&](size_t begin, size_t end) {
      for (size_t f = begin; f < end; ++f) {
        std::vector<Box> boxes =
            repaired_frame(animation_, frames[f], segment.representatives, segment.frames);
        costs[f] = sah_cost(segment.tree, refit(segment.tree, boxes), config_.optimize.cost);
        const auto known = rebuild_costs_.find(frames[f]);
        rebuilt[f] =
            known != rebuild_costs_.end() ? known->second : rebuild_cost(std::move(boxes), config_);
      }
    });
    const std::vector<double> all_weights =
        frame_weights(animation_, segment.first_frame, segment.last_frame);
    std::vector<double> weights = weights_by_nearness(frames, segment.first_frame, all_weights);
    segment.cost = segment.rebuild_cost = 0.0;
    for (size_t f = 0; f < frames.size(); ++f) {
      segment.cost += weights[f] * costs[f];
      segment.rebuild_cost += weights[f] * rebuilt[f];
      rebuild_costs_.emplace(frames[f], rebuilt[f]);
    }
    segment.measured_frames = std::move(frames);
    segment.measured_weights = std::move(weights);
  }

  const AnimatedBoxes& animation_;
  SegmentConfig config_;
  uint32_t most_segments_;
  std::vector<double> weights_;     // of all frames
  std::vector<uint32_t> measured_;  // frames
  std::map<uint32_t, double> rebuild_costs_;
  bool stopped_ = false;  // by the caller
};

Error usage(std::string problem, std::string remedy) {
  return {ErrorKind::usage, "", "", std::move(problem), std::move(remedy)};
}

}  // namespace

Result<std::vector<Segment>> cut_into_segments(const AnimatedBoxes& animation,
                                               const SegmentConfig& config) {
  SINEW_CHECK(config.most_segments > 0 && config.representatives > 0 && config.boundaries > 0);
  SINEW_CHECK(config.measured_frames > 0);
  if (animation.frame_count() == 0) {
    return fail(usage("the animation has no frames", "choose another clip or range of frames"));
  }
  const std::vector<double>& times = animation.times;
  for (size_t f = 0; f < times.size(); ++f) {
    if (!std::isfinite(times[f]) || (f > 0 && times[f] < times[f - 1])) {
      return fail({ErrorKind::usage, "", "frame " + std::to_string(f),
                   "its time is not after that of the frame before",
                   "cut clips into segments one by one"});
    }
  }
  uint32_t most_segments = config.most_segments;
  if (config.byte_budget > 0) {
    const size_t one = bytes_of_trees(animation.primitive_count);
    if (config.byte_budget < one) {
      return fail(usage("a budget of " + std::to_string(config.byte_budget) +
                            " bytes is too small for a single tree",
                        "give it at least " + std::to_string(one) + " bytes"));
    }
    const size_t affordable = one > 0 ? config.byte_budget / one : most_segments;
    most_segments = static_cast<uint32_t>(std::min<size_t>(most_segments, affordable));
  }
  return Cutter(animation, config, most_segments).run();
}

double average_cost(std::span<const Segment> segments) {
  double sum = 0.0;
  for (const Segment& s : segments) sum += s.share * s.cost;
  return sum;
}

double average_rebuild_cost(std::span<const Segment> segments) {
  double sum = 0.0;
  for (const Segment& s : segments) sum += s.share * s.rebuild_cost;
  return sum;
}

size_t segment_at(std::span<const Segment> segments, double time) {
  SINEW_CHECK(!segments.empty());
  const auto after =
      std::upper_bound(segments.begin(), segments.end(), time,
                       [](double t, const Segment& segment) { return t < segment.begin; });
  return after == segments.begin() ? 0 : static_cast<size_t>(after - segments.begin()) - 1;
}

size_t bytes_of_trees(uint32_t primitive_count, size_t trees) {
  return trees * (size_t{primitive_count} * kBytesATriangle + 256);
}

}  // namespace sinew
