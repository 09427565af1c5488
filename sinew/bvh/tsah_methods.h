// The methods that T-SAH is measured against, over all frames of an animation.
// Based on: J. Bittner, D. Meister, "T-SAH", 2015, section 6.1; I. Wald, S. Boulos, P. Shirley,
// "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007 (best over time).
//
//   SAH0         tree_of_frame() of the first frame (T: without insertion), then refit
//   SAH*         best_over_time(): the tree of that frame which is best over all frames
//   SAH-rebuild  rebuild_costs(): every frame has a tree of its own
//   T-SAH        tsah_tree() over representative frames, then refit
//
// Every tree is full-sweep SAH with one primitive a leaf, perhaps optimised, then collapsed by the
// costs of the frames that it was made for. Frames are asked for as they are needed, so only a few
// are in memory at once. Boxes that are not finite count as make_frame_boxes() says for one frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/segments.h"
#include "sinew/bvh/tsah_reference.h"

namespace sinew {

struct MethodConfig {
  bool insertion = true;    // SAH trees are optimised by insertion (BHH13)
  uint32_t leaf_block = 1;  // see collapse_leaves(); T's cost counts single triangles
  uint32_t max_leaf = 8;    // 1: leaves are not collapsed
  TsahConfig tsah{};        // of insertion (without its callback) and of T-SAH; the cost of all
};

struct AnimationCosts {
  std::vector<double> costs;  // SAH cost (T, equation 1) of each frame
  double average = 0.0;       // by the animation's weights; of equal ones where it has none
  double maximum = 0.0;
};

// What a tree costs when it is refit to each frame.
AnimationCosts animation_costs(const Tree& tree, const AnimatedBoxes& animation,
                               const CostModel& model = {});

// The SAH tree of a single frame. Boxes must be finite and not empty.
Tree tree_of_frame(std::span<const Box> boxes, const MethodConfig& config = {});

// SAH-rebuild: each frame by its own tree_of_frame().
AnimationCosts rebuild_costs(const AnimatedBoxes& animation, const MethodConfig& config = {});

struct BestOverTime {
  Tree tree;
  uint32_t frame = 0;  // whose tree it is
  AnimationCosts costs;
};

// SAH*: of the trees of the frames `candidates` the one with the least average cost; the earlier
// one of equals. Some frame must be a candidate.
BestOverTime best_over_time(const AnimatedBoxes& animation, std::span<const uint32_t> candidates,
                            const MethodConfig& config = {});

// T-SAH with adaptive leaves: build_tsah(), then collapse_leaves() with the final weights.
Tree tsah_tree(const FrameBoxes& representatives, const MethodConfig& config = {});

}  // namespace sinew
