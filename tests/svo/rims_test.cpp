// Where a surface ends: which triangles are there, and that their voxels leave no holes.
#include "sinew/svo/make/rims.h"

#include <gtest/gtest.h>

#include "sinew/svo/draw/rasterize.h"
#include "sinew/svo/holes/hole_reference.h"
#include "svo/skinned_shape.h"
#include "svo/thesis_shapes.h"

namespace sinew {
namespace {

TEST(Rims, ClosedSmoothSurfacesHaveNone) {
  const test::Shape sphere = test::sphere(4);
  const auto rims = rim_triangles(sphere.positions, sphere.triangles);
  EXPECT_EQ(std::ranges::count(rims, 1), 0);
}

TEST(Rims, AreTheTrianglesAtTheBorderOfAPlate) {
  test::Shape plate;
  test::add_plate(plate, vec2(0.0f), vec2(1.0f), 0.0f, 5);
  const auto rims = rim_triangles(plate.positions, plate.triangles);
  for (size_t t = 0; t < rims.size(); ++t) {
    int at_border = 0;  // edges
    for (int k = 0; k < 3; ++k) {
      const vec3 a = plate.positions[plate.triangles[t][k]];
      const vec3 b = plate.positions[plate.triangles[t][(k + 1) % 3]];
      at_border += (a.x == b.x && (a.x == 0.0f || a.x == 1.0f)) ||
                   (a.y == b.y && (a.y == 0.0f || a.y == 1.0f));
    }
    EXPECT_EQ(rims[t], at_border > 0) << t;
  }
}

TEST(Rims, AreSharpFoldsWhicheverWayTrianglesTurn) {
  for (const float angle : {0.3f, 1.2f, 1.4f, 3.0f}) {  // from flat
    for (const bool flipped : {false, true}) {
      // Two triangles, whose other edges are closed by copies of them that turn little or not.
      test::Shape fold;
      fold.positions = {
          {0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(angle), 0, std::sin(angle)}, {0, -1, 0}};
      fold.triangles = {{0, 1, 2}, {1, 0, 3}};
      if (flipped) fold.triangles[1] = {0, 1, 3};
      for (const uvec3 t : {uvec3(0, 1, 2), uvec3(1, 0, 3)}) {
        for (int k = 1; k < 3; ++k) {  // wings in the same planes
          const auto wing = static_cast<uint32_t>(fold.positions.size());
          const vec3 a = fold.positions[t[k]], b = fold.positions[t[(k + 1) % 3]];
          fold.positions.push_back(a + b - fold.positions[t[(k + 2) % 3]]);
          fold.triangles.push_back({t[(k + 1) % 3], t[k], wing});
        }
      }
      const auto rims = rim_triangles(fold.positions, fold.triangles);
      EXPECT_EQ(rims[0], angle > 1.318f) << angle << flipped;
      EXPECT_EQ(rims[1], angle > 1.318f) << angle << flipped;
    }
  }
}

// An open sheet before another one of another limb, tilted and moved at random; holes and strays.
struct Counts {
  HoleCount sum;
  uint64_t strays = 0;
};
Counts count_sheets(uint32_t seed, bool with_rims, bool own_sheets = true) {
  Random random(seed);
  test::SkinnedShape body;
  test::add_plate(body.shape, vec2(-0.5f), vec2(0.5f), 0.0f, 6);
  const auto first = static_cast<uint32_t>(body.shape.positions.size());
  test::add_plate(body.shape, vec2(-0.45f), vec2(0.4f), 0.02f, 7);
  const float angle = random.uniform(0.1f, 1.4f);
  const glm::quat turn = glm::angleAxis(angle, random.direction());
  for (vec3& p : body.shape.positions) p = turn * p;
  for (uint32_t v = 0; v < body.shape.positions.size(); ++v) body.follow(v, v >= first ? 1 : 0);
  const std::vector<uint8_t> rims = rim_triangles(body.shape.positions, body.shape.triangles);
  VoxelizeOptions options;
  if (with_rims) options.rims = rims;
  const VoxelSurface surface = *body.voxelized(48, options);
  const SvoSource source = body.source();
  const Svo svo = *make_svo(surface, source);
  const HoleReference reference(source, svo, 0.25f, own_sheets ? &surface : nullptr);
  const SvoMotion motion = make_svo_motion(svo);
  Counts out;
  out.strays = reference.strays();
  PosedSvo posed;
  RasterScratchPtr scratch = make_raster_scratch();
  for (int picture = 0; picture < 4; ++picture) {
    std::vector<Affine> joints(2, identity_affine());
    joints[1] =
        trs(0.3f * random.direction(), glm::angleAxis(0.6f, random.direction()), vec3(1.0f));
    Pose pose;
    pose.joints = joints;
    pose.placement =
        trs(vec3(0.0f), glm::angleAxis(random.uniform(0.0f, 3.0f), random.direction()), vec3(1.0f));
    posed.set_pose(motion, pose);
    const RasterView view = test::make_view(4.0f, 800.0f, 320, 320);  // 4 pixels a voxel
    SurfacePicture truth;
    reference.draw_lattice(posed, pose.placement, view, truth);
    const VoxelInstance instance{&posed, pose.placement, 0};
    Visibility drawn;
    rasterize({&instance, 1}, view, {}, *scratch, drawn);
    out.sum += count_holes(truth, drawn);
  }
  return out;
}

TEST(Rims, OpenSheetsBeforeOthersHaveNoHoles) {
  uint64_t without = 0, by_voxels = 0;
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Counts counts = count_sheets(seed, true);
    EXPECT_GT(counts.sum.surface, 10000u);
    EXPECT_EQ(counts.sum.holes, 0u);
    EXPECT_EQ(counts.strays, 0u);
    without += count_sheets(seed, false).sum.holes;
    by_voxels += count_sheets(seed, true, false).sum.holes;
  }
  // What the test is for: ends of sheets, and points that go with whatever sheet has their voxel.
  EXPECT_GT(without, 0u);
  EXPECT_GT(by_voxels, 0u);
}

}  // namespace
}  // namespace sinew
