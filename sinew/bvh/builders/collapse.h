// How a binary tree becomes an eight-wide one: as the wide nodes of least area in sum, which is how
// many of them a ray is expected to enter.
// Based on: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", HPG 2017: dynamic programming over subtrees that become one to eight
// children of one node. Differs: leaves stay as the binary tree has them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/bvh/tree.h"
#include "sinew/bvh/wide.h"

namespace sinew {

struct WideChildren {
  std::array<uint32_t, kWidth> node;
  uint32_t count = 0;

  void add(uint32_t child) { node[count++] = child; }
};

// Every node is added once, children before parents.
class WideCollapse {
 public:
  explicit WideCollapse(const Tree& tree) : tree_(tree), subtrees_(tree.nodes.size()) {}

  void add_leaf(uint32_t node) { subtrees_[node].closed = true; }
  // `area`: of the node's box, in any unit.
  void add_inner(uint32_t node, float area);
  // From now on the node is one child of whatever it hangs below.
  void close(uint32_t node) { subtrees_[node].closed = true; }

  // The binary nodes (two to eight) that become the children of the inner node.
  WideChildren children_of(uint32_t node) const;

 private:
  // A subtree that becomes at most 1, 2 ... 8 children.
  struct Subtree {
    float cost[kWidth] = {};
    uint8_t left[kWidth] = {};  // how many of them its left side gets; 0: it is one child itself
    bool closed = false;
  };
  float cost_of(uint32_t node, uint32_t children) const {
    const Subtree& subtree = subtrees_[node];
    return subtree.cost[subtree.closed ? 0 : children - 1];
  }
  void collect(uint32_t node, uint32_t children, WideChildren& out) const;

  const Tree& tree_;
  std::vector<Subtree> subtrees_;
};

}  // namespace sinew
