// An animation cut into segments, each with a tree of its own, where one tree is not enough.
// T (T-SAH 2015) leaves this to future work; docs/tsah.md says how it is done here.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sinew/bvh/optimize.h"

namespace sinew {

// An animation as seen by a builder: frames at times that rise, and the boxes of all primitives in
// any of them. boxes(frame, out) must be callable from several threads at once; it may leave boxes
// that are not finite.
struct AnimatedBoxes {
  uint32_t primitive_count = 0;
  std::vector<double> times;    // seconds, or whatever the caller likes; rising
  std::vector<double> weights;  // of the frames; empty: by the time around each
  std::function<void(uint32_t frame, std::span<Box> out)> boxes;

  uint32_t frame_count() const { return static_cast<uint32_t>(times.size()); }
};

enum class FrameChoice : uint8_t {
  uniform,  // T's: evenly spread over the frames, first and last included
  medoids,  // poses that are nearest to all others, by the distances of boxes
};

// `count` frames of [first, last], fewer if there are fewer distinct ones, with weights by the time
// (or the sum of the given weights) that each stands for.
std::vector<uint32_t> choose_frames(const AnimatedBoxes& animation, uint32_t first, uint32_t last,
                                    uint32_t count, FrameChoice choice,
                                    std::vector<double>* weights = nullptr);

// The boxes of those frames.
FrameBoxes sample_frames(const AnimatedBoxes& animation, std::span<const uint32_t> frames,
                         std::span<const double> weights);

struct SegmentConfig {
  OptimizeConfig optimize{};
  uint32_t representatives = 5;  // frames a segment
  FrameChoice choice = FrameChoice::uniform;
  uint32_t most_segments = 1;  // at most; the fewest that keep the limit are taken
  double cost_limit = 1.15;    // average cost of a segment's tree over a build's for each frame
  size_t byte_budget = 0;      // of all trees (bytes_of_trees); 0: no limit
  uint32_t boundaries = 16;    // candidates, between them intervals of equal time
};

struct Segment {
  double begin = 0.0;         // from this time on; the first one also before
  Tree tree;                  // one primitive a leaf
  FrameBoxes frames;          // its representatives
  double cost = 0.0;          // average over its sampled frames
  double rebuild_cost = 0.0;  // the same where every frame has its own tree
};

// The smallest number of segments, at most most_segments, whose trees keep the cost limit; if none
// does, the number with the least total cost that the byte budget allows. At least one.
std::vector<Segment> cut_into_segments(const AnimatedBoxes& animation, const SegmentConfig& config);

}  // namespace sinew
