// Tree: the topology of a binary hierarchy over primitives, without boxes (those are Bounds, one
// set a frame). Editable; the traced layout is made from it (wide.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sinew {

// An inner node has two children; a leaf has a range of Tree::primitives.
struct TreeNode {
  static constexpr uint32_t kLeaf = 0x80000000u;
  uint32_t a = 0;  // inner: left child.   leaf: first entry in Tree::primitives
  uint32_t b = 0;  // inner: right child.  leaf: kLeaf | number of primitives

  bool is_leaf() const { return (b & kLeaf) != 0; }
  uint32_t left() const { return a; }
  uint32_t right() const { return b; }
  uint32_t first() const { return a; }
  uint32_t count() const { return b & ~kLeaf; }

  static TreeNode inner(uint32_t left, uint32_t right) { return {left, right}; }
  static TreeNode leaf(uint32_t first, uint32_t count) { return {first, kLeaf | count}; }
};
static_assert(sizeof(TreeNode) == 8);

struct Tree {
  static constexpr uint32_t kRoot = 0;
  std::vector<TreeNode> nodes;       // nodes[kRoot] is the root; empty: no primitives
  std::vector<uint32_t> primitives;  // a permutation of 0..n-1; every leaf owns a range

  bool empty() const { return nodes.empty(); }
};

// A tree for a part of an animation.
struct TimedTree {
  double begin = 0.0;  // seconds; serves until the next one begins; the first one also before
  Tree tree;
  std::vector<float> areas;  // one a node: orders the children of eight-wide nodes (make_layout)
};

// Whether it is a tree over exactly `primitive_count` primitives: every node but the root has one
// parent, which stands before it, and every primitive is in one leaf. Empty text if so, else what
// is wrong.
std::string validate(const Tree& tree, uint32_t primitive_count);

}  // namespace sinew
