// MovableTree: a binary tree of which nodes are taken out and put back elsewhere, with the boxes of
// every node in every frame. What the reference of T-SAH works on (tsah_reference.h).
// Based on: J. Bittner, M. Hapala, V. Havran, "Fast Insertion-Based Optimization of Bounding Volume
// Hierarchies", 2013 (removal and insertion); J. Bittner, D. Meister, "T-SAH", 2015, figure 2 (an
// array of boxes a node).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/frames/frames.h"
#include "sinew/bvh/tree.h"
#include "sinew/math/box.h"

namespace sinew {

class MovableTree {
 public:
  static constexpr uint32_t kNone = 0xffffffffu;

  struct Node {
    uint32_t parent = kNone;                      // kNone: the root
    std::array<uint32_t, 2> child{kNone, kNone};  // leaf: kNone and the primitive
  };

  // The tree must hold one primitive a leaf. Keeps a reference to nothing.
  MovableTree(const Tree& tree, const FrameBoxes& frames);

  uint32_t root() const { return root_; }
  uint32_t node_count() const { return static_cast<uint32_t>(nodes_.size()); }
  uint32_t frame_count() const { return frame_count_; }
  bool is_leaf(uint32_t node) const { return nodes_[node].child[0] == kNone; }
  uint32_t parent(uint32_t node) const { return nodes_[node].parent; }
  uint32_t child(uint32_t node, int which) const { return nodes_[node].child[which]; }
  uint32_t sibling(uint32_t node) const;
  // One a frame.
  std::span<const Box> boxes(uint32_t node) const {
    return {boxes_.data() + size_t{node} * frame_count_, frame_count_};
  }

  // Takes out a node that is not the root: its sibling gets the place of its parent, which is
  // returned, free for insert(). The node keeps what hangs below it.
  uint32_t remove(uint32_t node);

  // Puts `node` back: the free node `link` gets the place of `at`, and both as its children.
  void insert(uint32_t node, uint32_t at, uint32_t link);

  // C_i of every frame (T, equation 1); 0 where the root has no area. Nothing may be taken out.
  std::vector<double> costs(const CostModel& model) const;

  // The topology alone, to come back to it; `boxes` follow.
  struct State {
    std::vector<Node> nodes;
    uint32_t root = 0;
  };
  State state() const { return {nodes_, root_}; }

  // One primitive a leaf, nodes in depth-first order.
  static Tree to_tree(const State& state);

 private:
  void replace_child(uint32_t parent, uint32_t old_child, uint32_t new_child);
  bool fit(uint32_t node);
  void fit_upwards(uint32_t node);

  uint32_t root_ = 0, frame_count_ = 0;
  std::vector<Node> nodes_;
  std::vector<Box> boxes_;  // [node][frame]
};

}  // namespace sinew
