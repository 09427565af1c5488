#include "sinew/bvh/builders/collapse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "sinew/math/random.h"

namespace sinew {
namespace {

struct TreeWithAreas {
  Tree tree;
  std::vector<double> area;
  std::vector<bool> closed;
};

// Random shape and areas, a child's never above its parent's; parents stand before children.
TreeWithAreas random_tree(uint32_t leaves, Random& random) {
  TreeWithAreas out;
  out.tree.nodes = {TreeNode::leaf(0, 1)};
  out.area = {1.0};
  for (uint32_t count = 1; count < leaves; ++count) {
    std::vector<uint32_t> open;
    for (uint32_t n = 0; n < out.tree.nodes.size(); ++n) {
      if (out.tree.nodes[n].is_leaf()) open.push_back(n);
    }
    const uint32_t parent = open[random.next() % open.size()];
    const auto left = static_cast<uint32_t>(out.tree.nodes.size());
    out.tree.nodes[parent] = TreeNode::inner(left, left + 1);
    for (int side = 0; side < 2; ++side) {
      out.tree.nodes.push_back(TreeNode::leaf(0, 1));
      out.area.push_back(out.area[parent] * random.uniform(0.1f, 1.0f));
    }
  }
  for (uint32_t n = 0; n < out.tree.nodes.size(); ++n) {
    out.closed.push_back(out.tree.nodes[n].is_leaf() || (n > 0 && random.next() % 8 == 0));
  }
  return out;
}

WideCollapse collapse(const TreeWithAreas& t) {
  WideCollapse out(t.tree);
  for (auto n = static_cast<uint32_t>(t.tree.nodes.size()); n-- > 0;) {
    if (t.tree.nodes[n].is_leaf()) {
      out.add_leaf(n);
    } else {
      out.add_inner(n, static_cast<float>(t.area[n]));
      if (t.closed[n]) out.close(n);
    }
  }
  return out;
}

// The least cost of the subtree as at most 1 to 8 children of one node, by trying everything.
double least_cost(const TreeWithAreas& t, uint32_t node, uint32_t children);

double least_as_node(const TreeWithAreas& t, uint32_t node) {
  const TreeNode& n = t.tree.nodes[node];
  if (n.is_leaf()) return 0.0;
  double least = 1e30;
  for (uint32_t left = 1; left < kWidth; ++left) {
    least =
        std::min(least, least_cost(t, n.left(), left) + least_cost(t, n.right(), kWidth - left));
  }
  return t.area[node] + least;
}

double least_cost(const TreeWithAreas& t, uint32_t node, uint32_t children) {
  double least = least_as_node(t, node);
  if (t.closed[node]) return least;
  const TreeNode& n = t.tree.nodes[node];
  for (uint32_t left = 1; left < children; ++left) {
    least =
        std::min(least, least_cost(t, n.left(), left) + least_cost(t, n.right(), children - left));
  }
  return least;
}

// What the collapse makes of a subtree; counts how often every leaf is reached.
double cost_of(const TreeWithAreas& t, const WideCollapse& wide, uint32_t node,
               std::vector<int>& reached) {
  if (t.tree.nodes[node].is_leaf()) {
    ++reached[node];
    return 0.0;
  }
  const WideChildren children = wide.children_of(node);
  EXPECT_GE(children.count, 2u);
  EXPECT_LE(children.count, kWidth);
  double cost = t.area[node];
  for (uint32_t i = 0; i < children.count; ++i) cost += cost_of(t, wide, children.node[i], reached);
  return cost;
}

TEST(WideCollapse, IsTheCheapestThereIs) {
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const uint32_t leaves = 2 + random.next() % 13;
    const TreeWithAreas t = random_tree(leaves, random);
    const WideCollapse wide = collapse(t);
    std::vector<int> reached(t.tree.nodes.size(), 0);
    EXPECT_NEAR(cost_of(t, wide, Tree::kRoot, reached), least_as_node(t, Tree::kRoot), 1e-5);
    for (uint32_t n = 0; n < t.tree.nodes.size(); ++n) {
      EXPECT_EQ(reached[n], t.tree.nodes[n].is_leaf() ? 1 : 0);
    }
  }
}

TEST(WideCollapse, ClosedSubtreesStayWhole) {
  // Eight leaves in a row below one another; the lowest three are closed into one.
  TreeWithAreas t;
  for (uint32_t i = 0; i < 7; ++i) {
    t.tree.nodes.push_back(TreeNode::inner(2 * i + 1, 2 * i + 2));
    t.tree.nodes.push_back(TreeNode::leaf(i, 1));
  }
  t.tree.nodes.push_back(TreeNode::leaf(7, 1));
  t.area.assign(t.tree.nodes.size(), 1.0);
  t.closed.assign(t.tree.nodes.size(), false);
  EXPECT_EQ(collapse(t).children_of(Tree::kRoot).count, 8u);
  constexpr uint32_t kLowest = 10;  // an inner node, leaves 5 to 7 below it
  t.closed[kLowest] = true;
  const WideChildren children = collapse(t).children_of(Tree::kRoot);
  ASSERT_EQ(children.count, 6u);
  EXPECT_EQ(std::count(children.node.begin(), children.node.begin() + children.count, kLowest), 1);
}

// Areas that make no sense still give every node two to eight children.
TEST(WideCollapse, AnyAreasWillDo) {
  Random random(5);
  TreeWithAreas t = random_tree(40, random);
  for (const double area : {0.0, 1e30, double(std::numeric_limits<float>::quiet_NaN())}) {
    std::ranges::fill(t.area, area);
    std::vector<int> reached(t.tree.nodes.size(), 0);
    cost_of(t, collapse(t), Tree::kRoot, reached);
    for (uint32_t n = 0; n < t.tree.nodes.size(); ++n) {
      EXPECT_EQ(reached[n], t.tree.nodes[n].is_leaf() ? 1 : 0);
    }
  }
}

}  // namespace
}  // namespace sinew
