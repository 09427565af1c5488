// Files of trees: what is written comes back, and nothing else is taken for it.
#include "sinew/bvh/frames/tree_file.h"

#include <gtest/gtest.h>

#include "sinew/math/random.h"

namespace sinew {
namespace {

TreeFile small() {
  const Tree three{{TreeNode::inner(1, 2), TreeNode::leaf(0, 1), TreeNode::leaf(1, 2)}, {2, 0, 1}};
  const Tree one{{TreeNode::leaf(0, 1)}, {0}};
  return {.key = 0x123456789abcdef0u,
          .clip = 2,
          .bodies = {{{0.0, three, {3.0f, 1.0f, 2.0f}}, {1.5, three, {4.0f, 1.0f, 1.0f}}},
                     {{0.0, one, {0.5f}}},
                     {{0.0, Tree(), {}}}}};
}

TEST(TreeFile, ComesBackAsItWas) {
  const TreeFile before = small();
  const std::vector<uint8_t> bytes = encode_trees(before);
  const Result<TreeFile> after = decode_trees(bytes);
  ASSERT_TRUE(after) << after.error().message();
  EXPECT_EQ(after->key, before.key);
  EXPECT_EQ(after->clip, before.clip);
  ASSERT_EQ(after->bodies.size(), before.bodies.size());
  EXPECT_EQ(encode_trees(*after), bytes);
  EXPECT_EQ(after->bodies[0][1].begin, 1.5);
  EXPECT_EQ(after->bodies[0][1].areas, before.bodies[0][1].areas);
  EXPECT_EQ(after->bodies[0][0].tree.primitives, before.bodies[0][0].tree.primitives);
}

TEST(TreeFile, EveryFlippedBitIsSeen) {
  std::vector<uint8_t> bytes = encode_trees(small());
  for (size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      bytes[i] ^= uint8_t(1 << bit);
      EXPECT_FALSE(decode_trees(bytes)) << "byte " << i << ", bit " << bit;
      bytes[i] ^= uint8_t(1 << bit);
    }
  }
  EXPECT_TRUE(decode_trees(bytes));
}

TEST(TreeFile, EveryCutIsSeen) {
  std::vector<uint8_t> bytes = encode_trees(small());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decode_trees(std::span(bytes).first(size))) << size << " bytes";
  }
  bytes.push_back(0);
  EXPECT_FALSE(decode_trees(bytes));
}

// Right checksums around what are no trees.
TEST(TreeFile, WhatIsNoTreeIsRefused) {
  const auto refused = [](auto change) {
    TreeFile file = small();
    change(file);
    return !decode_trees(encode_trees(file));
  };
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][0].tree.primitives[0] = 1; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][0].tree.nodes[0].a = 0; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][0].tree.nodes[1].a = 1u << 30; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][1].begin = 0.0; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[1][0].begin = NAN; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][0].areas[1] = NAN; }));
  EXPECT_TRUE(refused([](TreeFile& f) { f.bodies[0][0].areas[2] = -1.0f; }));
  EXPECT_FALSE(refused([](TreeFile&) {}));
}

}  // namespace
}  // namespace sinew
