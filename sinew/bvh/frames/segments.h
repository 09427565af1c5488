// An animation cut into segments, each with a tree of its own, where one tree is not enough.
// T (T-SAH 2015) cuts one scene into three equal parts by hand and leaves the rest to future work;
// docs/tsah.md says how it is done here. Trees share the mesh and its motion, and changing from one
// to the next costs nothing: every frame's boxes are refit anyway.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/frames/frame_choice.h"
#include "sinew/bvh/frames/optimize.h"

namespace sinew {

// What a new tree for every frame is, by which costs are judged; one primitive a leaf.
enum class Rebuild : uint8_t {
  binned,     // what a program can afford while it runs
  optimized,  // build_optimized() for each, as T's SAH-rebuild has it: 1.1 to 1.3 times cheaper to
              // trace, and as dear to measure as several more segments
};

struct SegmentConfig {
  OptimizeConfig optimize{};
  uint32_t representatives = 5;  // frames a segment
  FrameChoice choice = FrameChoice::uniform;
  uint32_t most_segments = 1;
  // Average cost over the clip, relative to a new tree for every frame. 0: as cheap as
  // most_segments and byte_budget allow.
  double cost_limit = 1.15;
  Rebuild rebuild = Rebuild::optimized;
  size_t byte_budget = 0;    // of all trees, by bytes_of_trees(); 0: no limit
  double least_gain = 0.01;  // another tree must save this share of the average cost
  uint32_t boundaries = 16;  // where segments may begin at first: so many equal parts of the clip
  // Frames whose costs, rebuilds among them, are measured in full; a segment has three at least.
  uint32_t measured_frames = 12;
};

struct Segment {
  double begin = 0.0;  // from this time on; the first one also before, the last one also after
  uint32_t first_frame = 0, last_frame = 0;
  Tree tree;                              // one primitive a leaf
  std::vector<uint32_t> representatives;  // rising
  FrameBoxes frames;                      // their boxes
  double share = 1.0;                     // of the clip's time, or of its frames' weights
  double cost = 0.0;                      // average over measured frames, most of them held out
  double rebuild_cost = 0.0;              // the same where every frame has a new tree
  std::vector<uint32_t> measured_frames;
  std::vector<double> measured_weights;  // of these; sum 1
};

// The smallest number of segments, at most most_segments and as many as the byte budget allows,
// that keep the cost limit; if none does, the number with the least cost, of which each tree is
// worth its bytes (least_gain). The clip's single tree is always made first.
//
// That the number is the smallest is as sure as the estimate behind it: costs of all intervals of
// boundaries come from a model of some thousand primitives in at most 128 frames, corrected by what
// full trees turned out to cost; that the limit is kept is measured. Boundaries are then moved from
// frame to frame of the model. The time is that of the returned trees and of the single one, seldom
// of another cut or two.
//
// The same for any number of threads. Errors: no frames, times that are not finite or fall (several
// clips in one, see join_clips(), have no order to cut along), a byte budget below a single tree.
Result<std::vector<Segment>> cut_into_segments(const AnimatedBoxes& animation,
                                               const SegmentConfig& config);

// Averages over the whole clip.
double average_cost(std::span<const Segment> segments);
double average_rebuild_cost(std::span<const Segment> segments);

// Which segment is shown at a time; there must be one.
size_t segment_at(std::span<const Segment> segments, double time);

// By about how much memory grows for `trees` of a body with `primitive_count` triangles and one
// object: bytes_of() of the layout, and of one pose with everything made, since an object keeps the
// boxes of trees that rest. Connected meshes take 80 bytes a triangle and tree (15 in the layout,
// 27 in nodes of the pose, 38 in packed triangles), and scattered triangles, which fill packets
// badly, up to 200. Further objects of the same body take their poses once more.
inline constexpr size_t kBytesATriangle = 96;
size_t bytes_of_trees(uint32_t primitive_count, size_t trees = 1);

}  // namespace sinew
