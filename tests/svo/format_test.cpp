// Packed attributes, Morton codes, and where voxels stand.
#include "sinew/svo/format.h"

#include <gtest/gtest.h>

#include "sinew/math/random.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {
namespace {

TEST(SvoFormat, NormalsKeepTheirDirection) {
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      for (int z = -4; z <= 4; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const vec3 d = glm::normalize(
            vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)));
        EXPECT_GT(dot(d, unpack_normal(pack_normal(7.0f * d))), 0.9998f) << x << y << z;
      }
    }
  }
  EXPECT_EQ(unpack_normal(pack_normal(vec3(0.0f))), vec3(0.0f, 0.0f, 1.0f));
  EXPECT_EQ(unpack_normal(pack_normal(vec3(0.0f, -1.0f, 0.0f))), vec3(0.0f, -1.0f, 0.0f));
}

TEST(SvoFormat, PackedColorsComeBackAsTheyWere) {
  for (uint32_t packed = 0; packed < 65536; ++packed) {
    ASSERT_EQ(pack_color(unpack_color(static_cast<uint16_t>(packed))), packed);
  }
  EXPECT_EQ(unpack_color(pack_color(vec3(2.0f, -1.0f, 1.0f))), vec3(1.0f, 0.0f, 1.0f));
}

TEST(SvoFormat, MortonCodesInterleave) {
  EXPECT_EQ(morton_of(uvec3(1, 0, 0)), 1u);
  EXPECT_EQ(morton_of(uvec3(0, 1, 0)), 2u);
  EXPECT_EQ(morton_of(uvec3(0, 0, 1)), 4u);
  EXPECT_EQ(morton_of(uvec3(4095)), (uint64_t{1} << 36) - 1);
  for (const uvec3 v : {uvec3(1, 2, 3), uvec3(4095, 0, 2048), uvec3(77, 1234, 4000)}) {
    EXPECT_EQ(voxel_of(morton_of(v)), v);
    EXPECT_EQ(voxel_of(morton_of(v) >> 9), v / 8u);
  }
}

TEST(SvoFormat, CodesSayWhereTheirVoxelsAre) {
  EXPECT_EQ(place_of(64 * 7 + 63).min, uvec3(7));
  EXPECT_EQ(place_of(64 * 1 + 2).min, uvec3(6, 0, 0));
  EXPECT_EQ(place_of(512 + 1 + 4 * 2 + 16 * 3).min, uvec3(2, 4, 6));
  EXPECT_EQ(place_of(512).side, 2u);
  EXPECT_EQ(place_of(576 + 6).min, uvec3(0, 4, 4));
  EXPECT_EQ(place_of(584).side, 8u);
}

TEST(VisibilityKey, NearerIsLessAndEverythingComesBack) {
  const VisibilityKey key = make_key(2.5f, kMostUnits - 1, 584);
  EXPECT_EQ(key_depth(key), 2.5f);
  EXPECT_EQ(key_unit(key), kMostUnits - 1);
  EXPECT_EQ(key_code(key), 584u);
  EXPECT_LT(make_key(2.4999f, kMostUnits - 1, 584), make_key(2.5f, 0, 0));
  EXPECT_LT(make_key(1e30f, kMostUnits - 1, 584), kNothing);
}

}  // namespace
}  // namespace sinew
