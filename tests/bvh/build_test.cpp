#include "sinew/bvh/build.h"

#include <gtest/gtest.h>

#include <numeric>

#include "shapes.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/cost.h"

namespace sinew {
namespace {

std::vector<Box> boxes_of(const test::Shape& shape) {
  std::vector<Box> boxes(shape.triangles.size());
  triangle_boxes(shape.positions, shape.triangles, boxes);
  return boxes;
}

using Builder = Tree (*)(std::span<const Box>, const BuildConfig&);
class TreeBuilder : public testing::TestWithParam<Builder> {};
INSTANTIATE_TEST_SUITE_P(All, TreeBuilder, testing::Values(&build_binned, &build_sweep));

// Every primitive once, every node reached once, every box inside its parent's.
void expect_valid(const Tree& tree, std::span<const Box> boxes, uint32_t max_leaf) {
  ASSERT_FALSE(tree.empty());
  const Bounds bounds = refit(tree, boxes);
  std::vector<int> seen(boxes.size(), 0), visited(tree.nodes.size(), 0);
  std::vector<uint32_t> stack = {Tree::kRoot};
  while (!stack.empty()) {
    const uint32_t node = stack.back();
    stack.pop_back();
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

TEST_P(TreeBuilder, HoldsEveryPrimitiveOnce) {
  for (const size_t count : {1, 2, 3, 9, 100, 30000}) {
    const auto shape = test::random_triangles(count, 7);
    for (const uint32_t max_leaf : {1u, 4u, 8u}) {
      BuildConfig config;
      config.max_leaf = max_leaf;
      const auto boxes = boxes_of(shape);
      expect_valid(GetParam()(boxes, config), boxes, max_leaf);
    }
  }
}

TEST_P(TreeBuilder, EmptyInputGivesAnEmptyTree) {
  EXPECT_TRUE(GetParam()({}, BuildConfig()).empty());
}

TEST_P(TreeBuilder, CoincidentPrimitivesAreSplitAnyway) {
  const std::vector<Box> same(1000, Box{vec3(1.0f), vec3(2.0f)});
  expect_valid(GetParam()(same, BuildConfig()), same, 8);
}

TEST_P(TreeBuilder, ExtremeCoordinatesAreHandled) {
  std::vector<Box> boxes;
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const float scale = i % 2 ? 1e30f : 1e-30f;
    const vec3 p = random.uniform3(-scale, scale);
    boxes.push_back({p, p});
  }
  expect_valid(GetParam()(boxes, BuildConfig()), boxes, 8);
}

TEST_P(TreeBuilder, SameTreeForAnyThreadCount) {
  const auto boxes = boxes_of(test::random_triangles(50000, 11));
  const Tree reference = GetParam()(boxes, BuildConfig());
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    const Tree tree = GetParam()(boxes, BuildConfig());
    EXPECT_EQ(tree.primitives, reference.primitives);
    ASSERT_EQ(tree.nodes.size(), reference.nodes.size());
    for (size_t i = 0; i < tree.nodes.size(); ++i) {
      EXPECT_EQ(tree.nodes[i].a, reference.nodes[i].a);
      EXPECT_EQ(tree.nodes[i].b, reference.nodes[i].b);
    }
  }
}

TEST(TreeBuilders, SweepIsAtLeastAboutAsGoodAsBinned) {
  const auto boxes = boxes_of(test::sphere(5));
  const auto cost = [&](const Tree& tree) { return sah_cost(tree, refit(tree, boxes)); };
  EXPECT_LT(cost(build_sweep(boxes)), 1.02 * cost(build_binned(boxes)));
}

TEST(Cost, ByHand) {
  // Two unit cubes side by side: root 2 x 1 x 1 has half area 5, each leaf has 3.
  const std::vector<Box> boxes = {{vec3(0), vec3(1)}, {vec3(1, 0, 0), vec3(2, 1, 1)}};
  Tree tree;
  tree.nodes = {TreeNode::inner(1, 2), TreeNode::leaf(0, 1), TreeNode::leaf(1, 1)};
  tree.primitives = {0, 1};
  EXPECT_DOUBLE_EQ(sah_cost(tree, refit(tree, boxes)), (3.0 * 5 + 2.0 * (3 + 3)) / 5);
  EXPECT_EQ(sah_cost(Tree(), {}), 0.0);
}

}  // namespace
}  // namespace sinew
