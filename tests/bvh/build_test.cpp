#include "sinew/bvh/builders/build.h"

#include <gtest/gtest.h>

#include "shapes.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/cost.h"
#include "sinew/bvh/update/update.h"
#include "sinew/bvh/wide.h"
#include "tree_checks.h"

namespace sinew {
namespace {

using test::expect_valid;

std::vector<Box> boxes_of(const test::Shape& shape) {
  std::vector<Box> boxes(shape.triangles.size());
  triangle_boxes(shape.positions, shape.triangles, boxes);
  return boxes;
}

Tree build_hlbvh_median(std::span<const Box> boxes, const BuildConfig& config) {
  return build_hlbvh(boxes, HlbvhSplit::median, config);
}
Tree build_hlbvh_sah(std::span<const Box> boxes, const BuildConfig& config) {
  return build_hlbvh(boxes, HlbvhSplit::sah, config);
}

using Builder = Tree (*)(std::span<const Box>, const BuildConfig&);
class TreeBuilder : public testing::TestWithParam<Builder> {};
INSTANTIATE_TEST_SUITE_P(All, TreeBuilder,
                         testing::Values(&build_binned, &build_sweep, &build_hlbvh_median,
                                         &build_hlbvh_sah));

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
    test::expect_same(GetParam()(boxes, BuildConfig()), reference);
  }
}

TEST_P(TreeBuilder, NodesStandInDepthFirstOrder) {
  test::expect_depth_first(GetParam()(boxes_of(test::random_triangles(20000, 5)), BuildConfig()));
}

TEST_P(TreeBuilder, TheTreeCanBeTraced) {
  const auto shape = test::sphere(5);
  const auto boxes = boxes_of(shape);
  const Tree tree = GetParam()(boxes, BuildConfig());
  const Bvh8Layout layout = *make_layout(tree, half_areas(refit(tree, boxes)), shape.triangles,
                                         static_cast<uint32_t>(shape.positions.size()));
  Bvh8 bvh;
  update_full(layout, shape.positions, bvh);
  EXPECT_EQ(validate(layout, bvh, shape.positions, shape.triangles), "");
}

TEST(Hlbvh, SplitsInTheSpatialMiddle) {
  // Centroids 0.5, 1.5 .. 15.5 on the x axis lie in a box of 15 units: cells of the first eight
  // have the code's highest x bit clear, those of the others set. Again in halves, quarters.
  std::vector<Box> boxes;
  for (int i = 0; i < 16; ++i) boxes.push_back({vec3(i, 0, 0), vec3(i + 1, 1, 1)});
  // Seven more at the right end: the spatial middle stays where it is, the primitives' would not.
  for (int i = 0; i < 7; ++i) boxes.push_back(boxes[15]);
  BuildConfig config;
  config.max_leaf = 1;
  for (const HlbvhSplit split : {HlbvhSplit::median, HlbvhSplit::sah}) {
    expect_valid(build_hlbvh(boxes, split, config), boxes, 1);
  }
  const Tree tree = build_hlbvh(boxes, HlbvhSplit::median, config);
  const Bounds bounds = refit(tree, boxes);
  const TreeNode& root = tree.nodes[Tree::kRoot];
  EXPECT_EQ(bounds[root.left()].max.x, 8.0f);
  EXPECT_EQ(bounds[root.right()].min.x, 8.0f);
  EXPECT_EQ(bounds[tree.nodes[root.left()].left()].max.x, 4.0f);
}

TEST(Hlbvh, FewPrimitivesAreOneLeafEvenFromManyClusters) {
  const auto boxes = boxes_of(test::random_triangles(8, 3));
  for (const HlbvhSplit split : {HlbvhSplit::median, HlbvhSplit::sah}) {
    EXPECT_EQ(build_hlbvh(boxes, split).nodes.size(), 1u);
  }
}

TEST(Hlbvh, ManyPrimitivesInOneCellMakeABalancedTree) {
  // All but one at a point, so that no bit of their codes tells them apart.
  std::vector<Box> boxes(100001, Box{vec3(0.0f), vec3(0.0f)});
  boxes[77] = {vec3(1.0f), vec3(1.0f)};
  for (const HlbvhSplit split : {HlbvhSplit::median, HlbvhSplit::sah}) {
    const Tree tree = build_hlbvh(boxes, split);
    expect_valid(tree, boxes, 8);
    // 100,000 are halved 14 times until eight or fewer are left: 2^14 leaves and that of the one.
    EXPECT_EQ(tree.nodes.size(), 2 * ((1u << 14) + 1) - 1);
  }
}

TEST(Hlbvh, SahIsNoWorseThanMediansAndBothNearBinned) {
  const auto boxes = boxes_of(test::sphere(6));
  const auto cost = [&](const Tree& tree) { return sah_cost(tree, refit(tree, boxes)); };
  const double median = cost(build_hlbvh(boxes, HlbvhSplit::median));
  EXPECT_LT(cost(build_hlbvh(boxes, HlbvhSplit::sah)), 1.01 * median);
  EXPECT_LT(median, 1.5 * cost(build_binned(boxes)));
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
