// Grids around boxes of any size and place.
#include <gtest/gtest.h>

#include <limits>

#include "sinew/math/random.h"
#include "sinew/svo/make/voxelize.h"

namespace sinew {
namespace {

// Whether the box lies within the grid, and no more than a voxel of it is empty.
void expect_fits(const VoxelGrid& grid, const Box& box) {
  for (int k = 0; k < 3; ++k) {
    const double origin = grid.origin[k], voxel = grid.voxel;
    const double low = (box.min[k] - origin) / voxel, high = (box.max[k] - origin) / voxel;
    EXPECT_GT(low, 0.0);
    EXPECT_LT(high, static_cast<double>(grid.resolution[k]));
    EXPECT_LE(grid.resolution[k], (high - low) + 2.5);
  }
}

TEST(VoxelGrid, HasTheResolutionAlongTheLongestSide) {
  const uint32_t seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    Box box;
    const float scale = std::exp2(random.uniform(-40.0f, 40.0f));
    const vec3 from = scale * random.uniform3(-1.0f, 1.0f);
    box.extend(from);
    box.extend(from + scale * random.uniform3(0.01f, 1.0f));
    const auto resolution = static_cast<uint32_t>(std::exp2(random.uniform(0.0f, 12.0f)));
    const auto grid = grid_of_resolution(box, resolution);
    ASSERT_TRUE(grid) << grid.error().message();
    const uvec3 n = grid->resolution;
    EXPECT_EQ(std::max({n.x, n.y, n.z}), resolution);
    expect_fits(*grid, box);
  }
}

TEST(VoxelGrid, ResolutionsAreFrom1To4096) {
  Box box;
  box.extend(vec3(0.0f));
  box.extend(vec3(1.0f, 2.0f, 3.0f));
  for (const uint32_t resolution : {1u, 2u, 4096u}) {
    const auto grid = grid_of_resolution(box, resolution);
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->resolution.z, resolution);
    expect_fits(*grid, box);
  }
  for (const uint32_t resolution : {0u, 4097u, 0xffffffffu}) {
    const auto grid = grid_of_resolution(box, resolution);
    ASSERT_FALSE(grid);
    EXPECT_EQ(grid.error().kind, ErrorKind::usage);
    EXPECT_NE(grid.error().message().find("1 to 4096"), std::string::npos);
  }
}

TEST(VoxelGrid, VoxelsHaveTheSideThatIsAskedFor) {
  Box box;
  box.extend(vec3(10.0f));
  box.extend(vec3(11.0f, 12.0f, 13.0f));
  const auto grid = grid_of_voxels(box, 0.25f);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->voxel, 0.25f);
  EXPECT_EQ(grid->resolution, uvec3(5, 9, 13));  // one more, for the margin
  expect_fits(*grid, box);
  for (const float side : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), 1e-4f}) {
    const auto none = grid_of_voxels(box, side);
    ASSERT_FALSE(none) << side;
    EXPECT_EQ(none.error().kind, ErrorKind::usage);
  }
}

TEST(VoxelGrid, BoxesFarAway) {
  Box box;
  box.extend(vec3(1e5f, 0.0f, -1e5f));
  box.extend(vec3(1e5f + 100.0f, 30.0f, -1e5f + 10.0f));
  const auto grid = grid_of_resolution(box, 1024);
  ASSERT_TRUE(grid) << grid.error().message();
  EXPECT_LE(grid->resolution.x, 1024u);
  EXPECT_GE(grid->resolution.x, 1022u);
  expect_fits(*grid, box);
  const auto too_fine = grid_of_voxels(box, 1e-3f);
  ASSERT_FALSE(too_fine);
  EXPECT_EQ(too_fine.error().kind, ErrorKind::bad_input);
  EXPECT_NE(too_fine.error().message().find("origin"), std::string::npos);
}

TEST(VoxelGrid, BoxesWithoutAGrid) {
  const float most = std::numeric_limits<float>::max();
  Box huge, tiny, infinite;
  huge.extend(vec3(-most));
  huge.extend(vec3(most));
  tiny.extend(vec3(0.0f));
  tiny.extend(vec3(1e-35f));
  infinite.extend(vec3(std::numeric_limits<float>::infinity()));
  for (const Box& box : {Box(), huge, tiny, infinite}) {
    for (const uint32_t resolution : {1u, 1000u}) {
      const auto grid = grid_of_resolution(box, resolution);
      ASSERT_FALSE(grid);
      EXPECT_EQ(grid.error().kind, ErrorKind::bad_input);
    }
  }
}

}  // namespace
}  // namespace sinew
