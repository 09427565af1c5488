// Where to cut an animation, found on a small model of it: some thousand of its primitives in at
// most 128 of its frames. Part of segments.cpp.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sinew/bvh/frames/segments.h"

namespace sinew {

// What the frame's own tree costs. Boxes must be finite.
double rebuild_cost(std::vector<Box> boxes, const SegmentConfig& config);

// Segments by their first frames; the first is 0.
struct Cut {
  std::vector<uint32_t> first_frames;
  double cost = 0.0;  // of the model: average over the clip
};

class SegmentSearch {
 public:
  // The times of the animation must not fall.
  SegmentSearch(const AnimatedBoxes& animation, const SegmentConfig& config);

  // The most segments into which the model can be cut, and may.
  uint32_t most() const { return static_cast<uint32_t>(coarse_.size()); }
  double rebuild_cost() const { return rebuild_cost_; }

  // The cheapest cut into 1..most() segments: at the boundaries by dynamic programming over trees
  // that are only built, then with optimised trees and every boundary moved to the frame that suits
  // its neighbours best.
  Cut best_cut(uint32_t segments) const;

 private:
  struct Interval {
    uint32_t first, last;  // frames of the model
  };
  enum class Effort { build, optimize };
  struct Estimate {
    Tree tree;
    double cost = 0.0;  // sum of weight * cost over the interval's frames
  };
  void find_parts(const AnimatedBoxes& animation, uint32_t boundaries);
  void estimate_intervals();
  void find_coarse_cuts(uint32_t most_segments);
  std::vector<Interval> coarse_cut(uint32_t segments) const;
  std::vector<Interval> moved(const std::vector<Interval>& cut,
                              const std::vector<Estimate>& estimates) const;
  Estimate estimate(Interval interval, Effort effort) const;
  uint32_t part_count() const { return static_cast<uint32_t>(parts_.size()) - 1; }
  double cost_of(const Tree& tree, uint32_t frame) const;

  SegmentConfig config_;
  std::vector<uint32_t> frames_;  // of the animation
  FrameBoxes model_;
  double rebuild_cost_ = 0.0;
  std::vector<uint32_t> parts_;                // first model frame of every part, and the end
  std::vector<double> interval_costs_;         // [first part * parts + last part]
  std::vector<std::vector<double>> coarse_;    // [segments - 1][parts - 1]: cost up to there
  std::vector<std::vector<uint32_t>> before_;  // the same: first part of the last segment
};

}  // namespace sinew
