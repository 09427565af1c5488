// FrameTree: the form of a binary tree in which it is optimised over several frames. An inner node
// is a record of two slots, one a child; a slot holds what the child is and its boxes in all
// frames, so one look at a record tells everything about both children.
//
//   slot 2r      child word | area | boxes        record r: its left child
//   slot 2r + 1  child word | area | boxes                  its right child
//
// Record 0 is no node: its first slot holds the root, which so can get a parent like any node. A
// tree of n primitives has n records then, and n - 1 inner nodes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/buffer.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/bvh/frames/optimize_kernels.h"
#include "sinew/bvh/tree.h"

namespace sinew {

class FrameTree {
 public:
  // The tree must have one primitive a leaf, and at least two. Boxes are relative to those of the
  // root, whose half area is then 1 in every frame (0 where it has none).
  FrameTree(const Tree& tree, const FrameBoxes& frames, const OptimizeConfig& config);

  uint32_t slot_count() const { return 2 * records_; }
  FrameView view();

  // C_i of every frame; what move() makes of them is a little rounded until refresh().
  const std::vector<double>& costs() const { return costs_; }

  // Computes the costs, g = v_i C_i^k (T's w_i, by time) from them, and all areas anew.
  void refresh();

  // Moves the subtree in `slot` beside what `to` holds if that makes power_cost() less, by as much
  // as areas that fall by `least`, and the tree no deeper than can be traced; returns whether it
  // did. Boxes and areas stay exact.
  bool move(uint32_t slot, uint32_t to, float least = 0.0f);

  // Whether moves have changed what the record of the slot holds since forget_changes().
  bool changed(uint32_t slot) const { return changed_[slot >> 1] != 0; }
  void forget_changes() { std::ranges::fill(changed_, uint8_t{0}); }

  // Nodes in depth-first order.
  Tree tree() const;

 private:
  void copy_topology(const Tree& tree);
  bool worth_it(float least) const;
  void copy_slot(uint32_t from, uint32_t to);
  bool too_deep(uint32_t slot, uint32_t to) const;
  uint32_t height_of(uint32_t slot) const;
  void set_heights(uint32_t record);

  uint32_t records_ = 0;
  uint32_t frames_ = 0;
  uint32_t padding_ = 0;          // floats a row
  Buffer<float> boxes_;           // [slot][row][padding]
  Buffer<float> areas_;           // [slot]
  Buffer<uint32_t> child_;        // [slot]
  Buffer<uint32_t> parent_;       // [record]
  std::vector<uint8_t> changed_;  // [record]
  std::vector<uint32_t> height_;  // [record]: inner nodes on the way to its deepest leaf
  Buffer<float> g_;               // [padding]
  OptimizeConfig config_;
  std::vector<double> weights_;  // v_i
  std::vector<double> costs_;
  double most_ = 0.0;           // of the costs at the last refresh()
  Buffer<float> rest_, saved_;  // of move(): one box, and half areas in every frame
};

}  // namespace sinew
