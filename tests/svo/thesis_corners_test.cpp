// Voxels with skinned corners, against every pixel asked about every voxel.
#include "sinew/svo/thesis/thesis_corners.h"

#include <gtest/gtest.h>

#include "svo/thesis_shapes.h"

namespace sinew {
namespace {

using test::make_view, test::random_joints, test::random_voxels, test::unit_grid;

TEST(ThesisCorners, CoverTheBoxesOfTheirProjectedCorners) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::vector<ThesisVoxel> voxels = random_voxels(random, 8, 60, 4);
    const CornerVoxels corners = make_corner_voxels(unit_grid(8), voxels, 4);
    const std::vector<Affine> joints = random_joints(random, 4);
    const RasterView view = make_view(2.0f, 40.0f, 48, 40);
    Visibility picture;
    CornerScratch scratch;
    const CornerInstance instance{&corners, joints, identity_affine(), 3};
    EXPECT_EQ(rasterize_corners({&instance, 1}, view, scratch, picture), voxels.size());
    std::vector<VisibilityKey> expected(picture.keys.size(), kNothing);
    for (uint32_t v = 0; v < voxels.size(); ++v) {
      vec2 low(1e9f), high(-1e9f);
      float depth = 0.0f;
      for (uint32_t k = 0; k < 8; ++k) {
        const uvec3 place = voxel_of(voxels[v].voxel) + uvec3(k & 1, k >> 1 & 1, k >> 2);
        const uint32_t c = corners.corner[v][k];
        ASSERT_EQ(corners.rest[c], corners.grid.origin + corners.grid.voxel * vec3(place));
        const vec4 p(thesis_point(corners.skin[c], joints, corners.rest[c]), 1.0f);
        const vec2 at = vec2(dot(view.x, p), dot(view.y, p)) / dot(view.w, p);
        low = glm::min(low, at);
        high = glm::max(high, at);
        depth += dot(view.depth, p);
      }
      for (uint32_t pixel = 0; pixel < expected.size(); ++pixel) {
        const vec2 center =
            vec2(static_cast<float>(pixel % 48), static_cast<float>(pixel / 48)) + 0.5f;
        if (glm::all(glm::lessThanEqual(low, center)) &&
            glm::all(glm::lessThanEqual(center, high))) {
          expected[pixel] =
              std::min(expected[pixel], make_key(0.125f * depth, 3 + (v >> 10), v & 1023));
        }
      }
    }
    EXPECT_EQ(picture.keys, expected);
  }
}

TEST(ThesisCorners, NeighboursShareCornersWithTheMeanOfTheirWeights) {
  std::vector<ThesisVoxel> voxels(2);
  voxels[0].voxel = morton_of({1, 1, 1});
  voxels[0].skin = {{0, 0, 0, 0}, {1.0f, 0.0f, 0.0f, 0.0f}};
  voxels[1].voxel = morton_of({2, 1, 1});
  voxels[1].skin = {{1, 0, 0, 0}, {1.0f, 0.0f, 0.0f, 0.0f}};
  const CornerVoxels corners = make_corner_voxels(unit_grid(4), voxels, 2);
  EXPECT_EQ(corners.rest.size(), 12u);
  for (uint32_t k = 0; k < 8; k += 2) {
    EXPECT_EQ(corners.corner[0][k + 1], corners.corner[1][k]);
    const ThesisWeights& shared = corners.skin[corners.corner[1][k]];
    EXPECT_EQ(shared.weights, (std::array<float, 4>{0.5f, 0.5f, 0.0f, 0.0f}));
    EXPECT_EQ(corners.skin[corners.corner[0][k]].weights[0], 1.0f);
  }
}

}  // namespace
}  // namespace sinew
