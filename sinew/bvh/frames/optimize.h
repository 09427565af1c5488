// One tree for a whole animation: built over the boxes of several frames at once, then improved by
// moving subtrees to better places.
// Based on: J. Bittner, D. Meister, "T-SAH", 2015; J. Bittner, M. Hapala, V. Havran, "Fast
// Insertion-Based Optimization of Bounding Volume Hierarchies", 2013; D. Meister, J. Bittner,
// "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018. Differs from T: it
// minimises power_cost(); the slow twin that does what T says is tsah_reference.h.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/frames/frames.h"
#include "sinew/bvh/tree.h"

namespace sinew {

struct OptimizeStep {
  double seconds = 0.0;       // since the start
  uint64_t moved = 0;         // subtrees, so far
  std::vector<double> costs;  // C_i of every frame
};

struct OptimizeConfig {
  uint32_t exponent = 0;  // k: the higher, the more the dearest frames count
  CostModel cost{};
  // Called after each pass; returning false ends the optimisation with the tree as it is.
  std::function<bool(const OptimizeStep&)> on_step{};
};

// A tree with one primitive a leaf, built top-down (binned SAH) over all frames at once. The same
// for any number of threads.
Tree build_over_frames(const FrameBoxes& frames, const OptimizeConfig& config = {});

// Improves a tree that has one primitive a leaf until it gets no better; the result is never dearer
// than the start, has one primitive a leaf, nodes in depth-first order, and is the same for any
// number of threads. With one frame this is plain SAH optimisation.
Tree optimize(const Tree& start, const FrameBoxes& frames, const OptimizeConfig& config = {});

// build_over_frames(), then optimize().
Tree build_optimized(const FrameBoxes& frames, const OptimizeConfig& config = {});

// Adaptive leaf size (T, section 5.4): a subtree whose cost as one leaf is less becomes a leaf, of
// at most max_leaf primitives. A leaf of n costs intersection * ceil(n / leaf_block) * leaf_block.
// g: area_weights() of the tree.
Tree collapse_leaves(const Tree& tree, const FrameBoxes& frames, std::span<const double> g,
                     const CostModel& model, uint32_t leaf_block, uint32_t max_leaf);

// A tree with one primitive a leaf as it is traced: leaves as BuildConfig's defaults have them, and
// areas over the frames. It begins at time 0.
TimedTree traced_tree(const Tree& tree, const FrameBoxes& frames, double exponent);

}  // namespace sinew
