// What every tree must hold, whoever made it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "sinew/bvh/bounds.h"
#include "sinew/bvh/tree.h"

namespace sinew::test {

// Every primitive once, every node reached once, every box inside its parent's.
inline void expect_valid(const Tree& tree, std::span<const Box> boxes, uint32_t max_leaf) {
  ASSERT_FALSE(tree.empty());
  const Bounds bounds = refit(tree, boxes);
  std::vector<int> seen(boxes.size(), 0), visited(tree.nodes.size(), 0);
  std::vector<uint32_t> stack = {Tree::kRoot};
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    ASSERT_LT(node, tree.nodes.size());
    ASSERT_EQ(visited[node]++, 0);
    const TreeNode& n = tree.nodes[node];
    if (n.is_leaf()) {
      EXPECT_GE(n.count(), 1u);
      EXPECT_LE(n.count(), max_leaf);
      for (uint32_t i = 0; i < n.count(); ++i) {
        const uint32_t primitive = tree.primitives[n.first() + i];
        ++seen[primitive];
        EXPECT_TRUE(bounds[node].contains(boxes[primitive]));
      }
    } else {
      for (const uint32_t child : {n.left(), n.right()}) {
        EXPECT_TRUE(bounds[node].contains(bounds[child]));
        stack.push_back(child);
      }
    }
  }
  EXPECT_EQ(std::accumulate(visited.begin(), visited.end(), 0), int(tree.nodes.size()));
  for (const int times : seen) EXPECT_EQ(times, 1);
}

inline void expect_depth_first(const Tree& tree) {
  uint32_t next = 0;
  std::vector<uint32_t> stack = {Tree::kRoot};
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
    ASSERT_EQ(node, next++);
    if (tree.nodes[node].is_leaf()) continue;
    stack.push_back(tree.nodes[node].right());
    stack.push_back(tree.nodes[node].left());
  }
}

inline void expect_same(const Tree& a, const Tree& b) {
  EXPECT_EQ(a.primitives, b.primitives);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].a, b.nodes[i].a);
    EXPECT_EQ(a.nodes[i].b, b.nodes[i].b);
  }
}

}  // namespace sinew::test
