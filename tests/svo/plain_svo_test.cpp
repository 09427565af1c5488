// Octrees of plain voxels: what goes in comes out, at every level; poses of what does not deform.
#include <gtest/gtest.h>

#include "sinew/base/parallel.h"
#include "sinew/svo/levels.h"
#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/posed.h"
#include "svo/svo_oracle.h"

namespace sinew {
namespace {

using test::read_voxels;
using test::ReadVoxel;

VoxelGrid grid_of(uint32_t resolution) {
  return {vec3(-1.0f, 2.0f, 0.5f), 0.25f, uvec3(resolution)};
}

TEST(PlainSvo, EveryVoxelComesBackInItsPlace) {
  for (const uint32_t resolution : {1u, 7u, 64u, 65u, 300u}) {
    const uint32_t seed = 100 + resolution;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<PlainVoxel> voxels = test::random_voxels(resolution, 20000, 3, seed);
    const Result<Svo> svo = make_svo(grid_of(resolution), voxels);
    ASSERT_TRUE(svo) << svo.error().message();
    EXPECT_EQ(validate(*svo), "");
    EXPECT_EQ(svo->voxel_count(), voxels.size());
    std::map<VoxelMorton, ReadVoxel> back;
    for (const ReadVoxel& v : read_voxels(*svo)) {
      EXPECT_TRUE(back.emplace(morton_of(v.voxel), v).second) << "a voxel twice";
    }
    ASSERT_EQ(back.size(), voxels.size());
    for (const PlainVoxel& v : voxels) {
      ASSERT_TRUE(back.contains(v.voxel));
      const ReadVoxel& read = back[v.voxel];
      EXPECT_EQ(read.normal, v.normal);
      EXPECT_EQ(read.color, v.color);
      EXPECT_EQ(read.material, v.material);
    }
  }
}

TEST(PlainSvo, CopiesOfACellShareAllCorners) {
  const std::vector<PlainVoxel> voxels = test::random_voxels(40, 20000, 4, 7);
  const Svo svo = *make_svo(grid_of(40), voxels);
  uint32_t copies = 0;
  for (size_t c = 1; c < svo.cells.size(); ++c) {
    if (svo.cells[c].place != svo.cells[c - 1].place) continue;
    ++copies;
    EXPECT_TRUE(std::ranges::equal(svo.cells[c].corner, svo.cells[c - 1].corner));
    EXPECT_NE(svo.cells[c].material, svo.cells[c - 1].material);
  }
  EXPECT_GT(copies, 100u);
}

// Two voxels in one level-1 voxel, a third in another brick: means by hand.
TEST(PlainSvo, MeansOfAttributes) {
  const uint16_t x = pack_normal(vec3(1, 0, 0)), y = pack_normal(vec3(0, 1, 0));
  const uint16_t red = pack_color(vec3(1, 0, 0)), green = pack_color(vec3(0, 1, 0));
  const std::vector<PlainVoxel> voxels = {{morton_of(uvec3(0, 0, 0)), x, red, 0},
                                          {morton_of(uvec3(1, 0, 0)), y, green, 0},
                                          {morton_of(uvec3(4, 0, 0)), x, red, 0}};
  const Svo svo = *make_svo(grid_of(8), voxels);
  EXPECT_EQ(validate(svo), "");
  ASSERT_EQ(svo.cells.size(), 1u);
  EXPECT_EQ(coarse_voxels(svo.cells[0], svo.bricks.data()), 0b101u);
  EXPECT_EQ(svo.cells[0].bricks, 0b11u);
  const auto look = [&](VoxelCode code) {
    return voxel_attributes(svo, svo.blocks[0], svo.cells[0], code);
  };
  EXPECT_NEAR(look(512).spread, std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(dot(look(512).normal, normalize(vec3(1, 1, 0))), 1.0f, 1e-5f);
  EXPECT_NEAR(length(look(512).color - vec3(0.5f, 0.5f, 0.0f)), 0.0f, 1e-5f);
  EXPECT_EQ(look(514).normal, vec3(1, 0, 0));
  EXPECT_EQ(look(514).spread, 1.0f);
  EXPECT_EQ(look(64).color, vec3(1, 0, 0));
  EXPECT_EQ(svo.brick_level.normals[0], pack_normal(vec3(1, 1, 0)));
  EXPECT_EQ(svo.brick_level.spreads[0], 180);  // sqrt(1/2) * 255
  EXPECT_EQ(look(576).spread, 180.0f / 255.0f);
  EXPECT_EQ(look(577).normal, vec3(1, 0, 0));
  EXPECT_EQ(svo.cell_level.normals[0], pack_normal(vec3(2, 1, 0)));
  EXPECT_EQ(svo.cell_level.spreads[0], 190);  // sqrt(5) / 3 * 255
  EXPECT_EQ(svo.cell_level.colors[0], pack_color(vec3(2.0f / 3.0f, 1.0f / 3.0f, 0)));
  ASSERT_EQ(svo.nodes.size(), 3u);  // levels 6, 5, 4
  EXPECT_EQ(svo.node_level.normals[0], svo.cell_level.normals[0]);
  EXPECT_EQ(svo.node_level.spreads[0], svo.cell_level.spreads[0]);
}

TEST(PlainSvo, LevelsCanBeFilteredAgain) {
  const Svo svo = *make_svo(grid_of(200), test::random_voxels(200, 50000, 2, 5));
  Svo again = svo;
  for (SvoLevel* level : {&again.brick_level, &again.cell_level}) {
    std::ranges::fill(level->normals, uint16_t{0});
    std::ranges::fill(level->colors, uint16_t{0});
    std::ranges::fill(level->spreads, uint8_t{0});
  }
  for (uint32_t b = 0; b < svo.block_count(); ++b) filter_levels(again, b);
  EXPECT_EQ(again.brick_level.normals, svo.brick_level.normals);
  EXPECT_EQ(again.brick_level.colors, svo.brick_level.colors);
  EXPECT_EQ(again.brick_level.spreads, svo.brick_level.spreads);
  EXPECT_EQ(again.cell_level.normals, svo.cell_level.normals);
  EXPECT_EQ(again.cell_level.colors, svo.cell_level.colors);
  EXPECT_EQ(again.cell_level.spreads, svo.cell_level.spreads);
}

TEST(PlainSvo, CornersStandAtRestWithinTheirBounds) {
  const Svo svo = *make_svo(grid_of(150), test::random_voxels(150, 30000, 2, 11));
  const SvoMotion motion = make_svo_motion(svo);
  PosedSvo posed;
  posed.set_pose(motion, Pose{});
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    EXPECT_FALSE(posed.is_made(b));
    posed.make_block(b);
    const PosedBlock block = posed.block(b);
    EXPECT_TRUE(block.cofactors.empty());
    const Box box = posed.bounds(svo.first_block_node() + b), root = posed.bounds(0);
    for (const vec3 p : block.positions) {
      EXPECT_TRUE(box.contains(p));
      EXPECT_TRUE(root.contains(p));
    }
    for (uint32_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      const SvoCell& cell = svo.cells[c];
      const vec3 min = svo.grid.origin + svo.grid.voxel * vec3(test::cell_min(svo.blocks[b], cell));
      EXPECT_EQ(map_point(cell, block, vec3(0.0f)), min);
      EXPECT_EQ(map_point(cell, block, vec3(0.5f, 1.0f, 0.25f)),
                min + 8.0f * svo.grid.voxel * vec3(0.5f, 1.0f, 0.25f));
      EXPECT_EQ(map_normals(cell, block, vec3(0.5f)), mat3(1.0f));
    }
  }
  EXPECT_EQ(posed.blocks_made(), svo.block_count());
}

TEST(PlainSvo, BadInputIsRefused) {
  const VoxelGrid grid = grid_of(8);
  EXPECT_FALSE(make_svo(grid, std::span<const PlainVoxel>{}));
  const std::vector<PlainVoxel> outside = {{morton_of(uvec3(8, 0, 0))}};
  EXPECT_FALSE(make_svo(grid, outside));
  const std::vector<PlainVoxel> twice = {{5}, {5}}, disorder = {{6}, {5}};
  EXPECT_FALSE(make_svo(grid, twice));
  EXPECT_FALSE(make_svo(grid, disorder));
  EXPECT_FALSE(make_svo(grid_of(4097), twice));
  EXPECT_FALSE(make_svo(grid_of(0), twice));
}

}  // namespace
}  // namespace sinew
