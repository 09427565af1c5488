// How a binary tree becomes an eight-wide one: the largest child box is opened first.
// Based on: I. Wald, C. Benthin, S. Boulos, "Getting Rid of Packets: Efficient SIMD Single-Ray
// Traversal using Multi-branching BVHs", 2008.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sinew/bvh/tree.h"
#include "sinew/bvh/wide.h"

namespace sinew {

struct WideChildren {
  std::array<uint32_t, kWidth> node;
  uint32_t count = 0;
};

// The binary nodes (two to eight) that become the children of the inner node `node`. closed(child)
// says which must stay whole; `areas` has one value a node.
template <class Closed>
WideChildren open_children(const Tree& tree, std::span<const float> areas, uint32_t node,
                           const Closed& closed) {
  WideChildren out{{tree.nodes[node].left(), tree.nodes[node].right()}, 2};
  while (out.count < kWidth) {
    uint32_t widest = out.count;
    float widest_area = -1.0f;
    for (uint32_t i = 0; i < out.count; ++i) {
      if (closed(out.node[i])) continue;
      const float area = areas[out.node[i]];
      if (area > widest_area) {
        widest = i;
        widest_area = area;
      }
    }
    if (widest == out.count) break;
    const TreeNode& opened = tree.nodes[out.node[widest]];
    out.node[widest] = opened.left();
    out.node[out.count++] = opened.right();
  }
  return out;
}

}  // namespace sinew
