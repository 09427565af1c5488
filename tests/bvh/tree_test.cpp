// Trees given by the caller: what is checked of them, and a Bvh made from one.
#include "sinew/bvh/tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/bvh/bvh.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

Tree three() {
  return {{TreeNode::inner(1, 2), TreeNode::leaf(0, 1), TreeNode::leaf(1, 2)}, {2, 0, 1}};
}

TEST(TreeValidate, TellsWhatIsWrong) {
  EXPECT_EQ(validate(three(), 3), "");
  EXPECT_EQ(validate(Tree(), 0), "");
  EXPECT_NE(validate(Tree(), 1), "");
  EXPECT_NE(validate(three(), 4), "");
  const auto broken = [](auto change) {
    Tree tree = three();
    change(tree);
    return validate(tree, 3);
  };
  EXPECT_NE(broken([](Tree& t) { t.primitives[0] = 1; }), "");
  EXPECT_NE(broken([](Tree& t) { t.primitives[0] = 7; }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[0] = TreeNode::inner(1, 1); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[0] = TreeNode::inner(1, 3); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[0] = TreeNode::inner(0, 1); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[0] = TreeNode::leaf(0, 3); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[2] = TreeNode::leaf(1, 1); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[2] = TreeNode::leaf(1, 3); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[2] = TreeNode::leaf(0xffffffffu, 2); }), "");
  EXPECT_NE(broken([](Tree& t) { t.nodes[2] = TreeNode::leaf(1, 0); }), "");
}

TEST(BvhFromTree, HitsWhatTheBuiltOneHits) {
  constexpr uint32_t kCount = 500;
  Random random(7);
  std::vector<vec3> positions(3 * kCount);
  std::vector<uvec3> triangles(kCount);
  for (uint32_t i = 0; i < kCount; ++i) {
    const vec3 at = random.uniform3(-1.0f, 1.0f);
    for (uint32_t k = 0; k < 3; ++k) positions[3 * i + k] = at + random.uniform3(-0.1f, 0.1f);
    triangles[i] = uvec3(3 * i, 3 * i + 1, 3 * i + 2);
  }
  std::vector<Box> boxes(kCount);
  triangle_boxes(positions, triangles, boxes);
  const Tree tree = build_sweep(boxes, {.max_leaf = 1});
  const Bvh built = *build(positions, triangles);
  const Bvh given = *build(positions, triangles, tree);
  // Areas without sense make slow trees, no wrong ones.
  std::vector<float> areas(tree.nodes.size());
  const float odd[] = {NAN, INFINITY, -1.0f, 0.0f, 1e30f, 1.0f};
  for (float& area : areas) area = odd[random.next() % 6];
  const Bvh slow = *build(positions, triangles, tree, areas);
  for (int i = 0; i < 2000; ++i) {
    const vec3 from = 3.0f * random.direction();
    const Ray ray{.origin = from, .direction = random.uniform3(-1.0f, 1.0f) - from};
    const std::optional<Hit> a = built.closest_hit(ray);
    for (const Bvh* other : {&given, &slow}) {
      const std::optional<Hit> b = other->closest_hit(ray);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a) continue;
      ASSERT_EQ(a->primitive, b->primitive);
      ASSERT_EQ(a->t, b->t);
    }
  }
}

TEST(BvhFromTree, RefusesWhatDoesNotFit) {
  const std::vector<vec3> positions = {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)};
  const std::vector<uvec3> triangles = {uvec3(0, 1, 2)};
  EXPECT_FALSE(build(positions, triangles, three()));
  EXPECT_FALSE(
      build(positions, std::vector<uvec3>{uvec3(0, 1, 3)}, Tree{{TreeNode::leaf(0, 1)}, {0}}));
  EXPECT_TRUE(build(positions, triangles, Tree{{TreeNode::leaf(0, 1)}, {0}}));
}

}  // namespace
}  // namespace sinew
