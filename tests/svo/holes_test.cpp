// The hole finder finds the holes and the excess that were planted, and no others.
#include "sinew/svo/holes/holes.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "sinew/math/random.h"

namespace sinew {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

// A disc of surface, and the same disc as voxels cover it.
struct Disc {
  SurfacePicture surface;
  Visibility picture;
};
Disc make_disc(uint32_t size, float radius, float depth, float voxel) {
  Disc out;
  const size_t pixels = size_t{size} * size;
  out.surface = {size, size, std::vector<float>(pixels, kFar), std::vector<float>(pixels, 0.0f),
                 std::vector<uint16_t>(pixels, 0)};
  out.picture = {size, size, std::vector<VisibilityKey>(pixels, kNothing)};
  for (uint32_t y = 0; y < size; ++y) {
    for (uint32_t x = 0; x < size; ++x) {
      const vec2 away = vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f -
                        0.5f * static_cast<float>(size);
      const size_t pixel = size_t{y} * size + x;
      if (length(away) > radius) continue;
      out.surface.depth[pixel] = depth;
      out.surface.size[pixel] = voxel;
      out.picture.keys[pixel] = make_key(depth, 1, 2);
    }
  }
  return out;
}

TEST(Holes, NoneWhereThePictureIsTheSurface) {
  const Disc disc = make_disc(40, 12.0f, 3.0f, 0.01f);
  const HoleCount count = count_holes(disc.surface, disc.picture);
  EXPECT_EQ(count.holes, 0u);
  EXPECT_EQ(count.excess, 0u);
  EXPECT_EQ(count.surface, count.covered);
  EXPECT_NEAR(static_cast<double>(count.surface), 452.4, 20.0);
}

TEST(Holes, FindsPlantedHolesAndThoseThatShowWhatIsBehind) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Disc disc = make_disc(40, 12.0f, 3.0f, 0.01f);
    std::set<size_t> planted;
    for (int i = 0; i < 20; ++i) {
      const uint32_t x = 14 + random.next() % 12, y = 14 + random.next() % 12;
      const size_t pixel = size_t{y} * 40 + x;
      planted.insert(pixel);
      disc.picture.keys[pixel] = i % 2 ? kNothing : make_key(3.03f, 1, 2);
    }
    disc.picture.keys[20 * 40 + 30] = make_key(3.015f, 1, 2);  // within two voxels: none
    disc.picture.keys[20 * 40 + 10] = make_key(1.0f, 1, 2);    // in front: none
    std::vector<uint8_t> marks;
    const HoleCount count = count_holes(disc.surface, disc.picture, &marks);
    EXPECT_EQ(count.holes, planted.size());
    EXPECT_EQ(count.excess, 0u);
    for (size_t pixel = 0; pixel < marks.size(); ++pixel) {
      EXPECT_EQ(marks[pixel], planted.contains(pixel) ? 1 : 0);
    }
  }
}

TEST(Holes, LargerVoxelsMayLieFartherBehind) {
  Disc disc = make_disc(40, 12.0f, 3.0f, 0.1f);
  disc.picture.keys[20 * 40 + 20] = make_key(3.19f, 1, 2);
  EXPECT_EQ(count_holes(disc.surface, disc.picture).holes, 0u);
  disc.picture.keys[20 * 40 + 20] = make_key(3.21f, 1, 2);
  EXPECT_EQ(count_holes(disc.surface, disc.picture).holes, 1u);
}

TEST(Holes, ExcessBeginsOneAndAHalfPixelsOutside) {
  const uint32_t size = 40;
  for (uint32_t reach = 0; reach <= 4; ++reach) {
    SCOPED_TRACE(reach);
    Disc disc = make_disc(size, 0.0f, 3.0f, 0.01f);  // no surface
    disc.surface.depth[20 * size + 20] = 3.0f;       // but one pixel
    uint64_t expected = 0;
    for (uint32_t y = 20 - reach; y <= 20 + reach; ++y) {
      for (uint32_t x = 20 - reach; x <= 20 + reach; ++x) {
        disc.picture.keys[y * size + x] = make_key(3.0f, 1, 2);
        const int dx = int(x) - 20, dy = int(y) - 20;
        expected += 4 * (dx * dx + dy * dy) > 9;  // (dx, dy) is longer than 1.5
      }
    }
    EXPECT_EQ(count_holes(disc.surface, disc.picture).excess, expected);
  }
}

TEST(Holes, ASurfaceBetweenPixelCentresIsNearToo) {
  const uint32_t size = 40;
  Disc disc = make_disc(size, 0.0f, 3.0f, 0.01f);
  disc.surface.touched[20 * size + 20] = 1u << 3;  // x 20.75 to 21, y 20 to 20.25
  const auto excess_at = [&](uint32_t x, uint32_t y) {
    Visibility picture{size, size, std::vector<VisibilityKey>(size_t{size} * size, kNothing)};
    picture.keys[y * size + x] = make_key(3.0f, 1, 2);
    return count_holes(disc.surface, picture).excess;
  };
  EXPECT_EQ(excess_at(20, 20), 0u);
  EXPECT_EQ(excess_at(19, 20), 0u);  // 1.375 from the middle of it
  EXPECT_EQ(excess_at(22, 20), 1u);  // 1.625
  EXPECT_EQ(excess_at(20, 19), 0u);
  EXPECT_EQ(excess_at(20, 18), 1u);
}

}  // namespace
}  // namespace sinew
