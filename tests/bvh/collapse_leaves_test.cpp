// Adaptive leaves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/cost.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/math/random.h"
#include "tree_checks.h"

namespace sinew {
namespace {

Box bar(float a, float b) {
  return {vec3(a, 0, 0), vec3(b, 1, 1)};
}

Tree pair_tree() {
  Tree tree;
  tree.nodes = {TreeNode::inner(1, 2), TreeNode::leaf(0, 1), TreeNode::leaf(1, 1)};
  tree.primitives = {0, 1};
  return tree;
}

// Primitives that scatter: clumps fly apart, each its own way. Frame 0 is all in one place.
FrameBoxes explosion(uint32_t primitives, uint32_t frame_count, uint32_t seed) {
  std::vector<std::vector<Box>> frames(frame_count, std::vector<Box>(primitives));
  for (uint32_t frame = 0; frame < frame_count; ++frame) {
    Random random(seed);
    for (uint32_t p = 0; p < primitives; ++p) {
      const vec3 low = random.uniform3(0.0f, 1.0f);
      const vec3 size = random.uniform3(0.01f, 0.05f);
      Random clump(1000 + p % 12);
      const vec3 at = low + (0.8f * static_cast<float>(frame)) * clump.direction();
      frames[frame][p] = {at, at + size};
    }
  }
  return make_frame_boxes(std::move(frames));
}

// What collapse_leaves minimises: areas by g, leaves by blocks.
double model_cost(const Tree& tree, const FrameBoxes& frames, std::span<const double> g,
                  const CostModel& model, uint32_t block) {
  double sum = 0.0;
  for (uint32_t f = 0; f < frames.frame_count(); ++f) {
    const Bounds bounds = refit(tree, frames.frames[f]);
    for (size_t n = 0; n < tree.nodes.size(); ++n) {
      const TreeNode& node = tree.nodes[n];
      const double weight = node.is_leaf() ? double(model.intersection) * block *
                                                 std::ceil(double(node.count()) / block)
                                           : model.traversal;
      sum += g[f] * weight * half_area(bounds[n]);
    }
  }
  return sum;
}

TEST(CollapseLeaves, ByHand) {
  // Two unit cubes, side by side in frame 0 and far apart in frame 1:
  //   frame 0  root [0,2] 5:    3 * 5 + 2 (3 + 3) = 27 as two leaves, 2 * 2 * 5 = 20 as one
  //   frame 1  root [0,10] 21:  3 * 21 + 2 (3 + 3) = 75,              2 * 2 * 21 = 84
  // Half and half: 51 against 52. 0.6 and 0.4: 46.2 against 45.6.
  const FrameBoxes frames = make_frame_boxes({{bar(0, 1), bar(1, 2)}, {bar(0, 1), bar(9, 10)}});
  const auto leaves = [&](double g0, double g1, uint32_t block, uint32_t max_leaf) {
    const double g[] = {g0, g1};
    const Tree tree = collapse_leaves(pair_tree(), frames, g, {}, block, max_leaf);
    test::expect_valid(tree, frames.frames[0], max_leaf);
    return (tree.nodes.size() + 1) / 2;
  };
  EXPECT_EQ(leaves(1.0, 0.0, 1, 8), 1u);
  EXPECT_EQ(leaves(1.0, 0.0, 1, 1), 2u);
  EXPECT_EQ(leaves(0.0, 1.0, 1, 8), 2u);
  EXPECT_EQ(leaves(0.5, 0.5, 1, 8), 2u);
  EXPECT_EQ(leaves(0.6, 0.4, 1, 8), 1u);
  // Four triangles cost as much as one: 3 * 21 + 8 (3 + 3) = 111 against 8 * 21 = 168 in frame 1,
  // 3 * 5 + 8 (3 + 3) = 63 against 40 in frame 0; half and half 87 against 104, 2/3 and 1/3 79
  // against 82.7, 3/4 and 1/4 75 against 72.
  EXPECT_EQ(leaves(0.5, 0.5, 4, 8), 2u);
  EXPECT_EQ(leaves(0.75, 0.25, 4, 8), 1u);
}

// The least cost of a subtree, tried by recursion.
double least_cost(const Tree& tree, std::span<const float> areas, uint32_t node, uint32_t block,
                  uint32_t max_leaf, uint32_t& count) {
  const TreeNode& n = tree.nodes[node];
  const auto as_leaf = [&](uint32_t k) { return 2.0 * block * std::ceil(double(k) / block); };
  if (n.is_leaf()) {
    count = n.count();
    return as_leaf(count) * areas[node];
  }
  uint32_t left = 0, right = 0;
  double cost = 3.0 * areas[node] + least_cost(tree, areas, n.left(), block, max_leaf, left) +
                least_cost(tree, areas, n.right(), block, max_leaf, right);
  count = left + right;
  if (count <= max_leaf) cost = std::min(cost, as_leaf(count) * areas[node]);
  return cost;
}

TEST(CollapseLeaves, IsTheCheapestWayAndNeverDearer) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    const FrameBoxes frames = explosion(400, 3, seed);
    const Tree tree = build_sweep(frames.frames[1], {.leaf_block = 1, .max_leaf = 1});
    const std::vector<double> g = area_weights(tree, frames, frame_costs(tree, frames), 2.0);
    for (const uint32_t block : {1u, 4u}) {
      for (const uint32_t max_leaf : {1u, 3u, 8u, 400u}) {
        const Tree out = collapse_leaves(tree, frames, g, {}, block, max_leaf);
        test::expect_valid(out, frames.frames[0], max_leaf);
        test::expect_depth_first(out);
        const double cost = model_cost(out, frames, g, {}, block);
        EXPECT_LE(cost, model_cost(tree, frames, g, {}, block));
        uint32_t count = 0;
        const std::vector<float> areas = weighted_areas(tree, frames, g);
        EXPECT_NEAR(cost, least_cost(tree, areas, 0, block, max_leaf, count), 1e-4 * cost);
        // Once more, there is nothing left to win.
        EXPECT_EQ(collapse_leaves(out, frames, g, {}, block, max_leaf).nodes.size(),
                  out.nodes.size());
      }
    }
  }
  EXPECT_TRUE(collapse_leaves(Tree(), {}, {}, {}, 1, 8).empty());
}

}  // namespace
}  // namespace sinew
