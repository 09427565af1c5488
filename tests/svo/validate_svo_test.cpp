// Damaged octrees: validate() says so, or everything may be read.
#include <gtest/gtest.h>

#include <functional>

#include "sinew/svo/levels.h"
#include "sinew/svo/posed.h"
#include "svo/skinned_shape.h"
#include "svo/svo_oracle.h"

namespace sinew {
namespace {

Svo small_svo() {
  test::SkinnedShape body;
  body.shape = test::sphere(2);
  body.follow_along(vec3(0.2f, 0.3f, 0.8f), 4);
  std::vector<vec3> bulge;
  for (const vec3 p : body.shape.positions) bulge.push_back(0.1f * p);
  body.add_target(bulge);
  return *make_svo(*body.voxelized(80), body.source());
}

TEST(ValidateSvo, NamesWhatIsWrong) {
  const Svo good = small_svo();
  ASSERT_EQ(validate(good), "");
  const std::vector<std::function<void(Svo&)>> damages = {
      [](Svo& s) { s.grid.voxel = 0.0f; },
      [](Svo& s) { s.grid.resolution = uvec3(4097); },
      [](Svo& s) { s.grid.resolution.x = 40; },
      [](Svo& s) { s.root_level = 13; },
      [](Svo& s) { s.root_level = 6; },
      [](Svo& s) { s.nodes[0].count = 0; },
      [](Svo& s) { ++s.nodes[1].first; },
      [](Svo& s) { s.nodes.back().level = 5; },
      [](Svo& s) { s.nodes.pop_back(); },
      [](Svo& s) { s.blocks.pop_back(); },
      [](Svo& s) { s.blocks[0].first_cell = 1; },
      [](Svo& s) { s.blocks[1].first_brick += 1; },
      [](Svo& s) { std::swap(s.blocks[0].x, s.blocks[1].x); },
      [](Svo& s) { s.blocks[1].first_joint = 0; },
      [](Svo& s) { s.cells[3].place = 512; },
      [](Svo& s) { s.cells[3].corner[2] = 60000; },
      [](Svo& s) { std::swap(s.cells[3].corner[2], s.cells[3].corner[3]); },
      [](Svo& s) { s.cells[3].first_voxel += 1; },
      [](Svo& s) { s.cells[3].voxels += 1; },
      [](Svo& s) { s.cells[3].bricks = 0; },
      [](Svo& s) { std::swap(s.cells[3], s.cells[5]); },
      [](Svo& s) { s.bricks[7] = 0; },
      [](Svo& s) { s.bricks[7] ^= 1; },
      [](Svo& s) { s.normals.pop_back(); },
      [](Svo& s) { s.color_ends.pop_back(); },
      [](Svo& s) { s.color_selectors.push_back(0); },
      [](Svo& s) { s.colors.push_back(0); },
      [](Svo& s) { s.brick_level.spreads.clear(); },
      [](Svo& s) { s.node_level.normals.push_back(0); },
      [](Svo& s) { s.corner_places[4] = 729; },
      [](Svo& s) { s.corner_joints[4][1] = 250; },
      [](Svo& s) { s.corner_weights[4][0] ^= 1; },
      [](Svo& s) { s.joint_palette[0] = 4; },
      [](Svo& s) { s.targets[0].target = 1; },
      [](Svo& s) { s.targets[0].first_delta += 1; },
      [](Svo& s) { s.targets[0].unit = -1.0f; },
      [](Svo& s) { s.deltas.pop_back(); },
      [](Svo& s) { s.morph_weights.clear(); },
      [](Svo& s) { s.morph_weights[0] = std::numeric_limits<float>::infinity(); },
      [](Svo& s) { s.joints = 0; },
  };
  for (size_t i = 0; i < damages.size(); ++i) {
    Svo bad = good;
    damages[i](bad);
    EXPECT_NE(validate(bad), "") << "damage " << i;
  }
}

template <class T>
void damage(std::vector<T>& values, Random& random) {
  if (values.empty()) return;
  const size_t i = random.next() % values.size();
  auto* const bytes = reinterpret_cast<uint8_t*>(&values[i]);
  const size_t byte = random.next() % sizeof(T);
  bytes[byte] = static_cast<uint8_t>(
      random.next() % 4 == 0 ? random.next() : bytes[byte] ^ 1u << random.next() % 8);
}

// Reads everything that an octree offers.
void use(Svo& svo) {
  for (const test::ReadVoxel& v : test::read_voxels(svo)) {
    const SvoBlock& block = svo.blocks[v.block];
    voxel_attributes(svo, block, svo.cells[v.cell], v.code);
  }
  for (uint32_t b = 0; b < svo.block_count(); ++b) filter_levels(svo, b);
  const SvoMotion motion = make_svo_motion(svo);
  const std::vector<Affine> joints(svo.joints, identity_affine());
  Pose pose;
  pose.joints = joints;
  pose.weights = svo.morph_weights;
  PosedSvo posed;
  posed.set_pose(motion, pose);
  for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
  posed.bounds(0);
}

// For the address sanitizer: what validate() passes may be used.
TEST(ValidateSvo, WhatPassesMayBeUsed) {
  const Svo good = small_svo();
  const uint32_t seed = 4242;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  int passed = 0;
  for (int round = 0; round < 2000; ++round) {
    Svo bad = good;
    const uint32_t times = 1 + random.next() % 3;
    for (uint32_t i = 0; i < times; ++i) {
      switch (random.next() % 11) {
        case 0:
          damage(bad.nodes, random);
          break;
        case 1:
          damage(bad.blocks, random);
          break;
        case 2:
          damage(bad.cells, random);
          break;
        case 3:
          damage(bad.bricks, random);
          break;
        case 4:
          damage(bad.corner_places, random);
          break;
        case 5:
          damage(bad.corner_joints, random);
          break;
        case 6:
          damage(bad.corner_weights, random);
          break;
        case 7:
          damage(bad.joint_palette, random);
          break;
        case 8:
          damage(bad.targets, random);
          break;
        case 9:
          damage(bad.deltas, random);
          break;
        default:
          damage(bad.normals, random);
          break;
      }
    }
    if (!validate(bad).empty()) continue;
    ++passed;
    if (passed <= 25) use(bad);
  }
  EXPECT_GT(passed, 10);
}

}  // namespace
}  // namespace sinew
