// The reference of holes: a sphere in voxels that cover it, and one with voxels torn out.
#include "sinew/svo/holes/hole_reference.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"
#include "sinew/svo/thesis/thesis_corners.h"
#include "svo/thesis_shapes.h"

namespace sinew {
namespace {

// The voxels that many points of a sphere of radius 0.4 lie in.
std::vector<ThesisVoxel> sphere_voxels(const VoxelGrid& grid) {
  std::vector<VoxelMorton> places;
  const test::Shape sphere = test::sphere(7);
  for (const uvec3 t : sphere.triangles) {
    const vec3 p =
        0.4f * (sphere.positions[t.x] + sphere.positions[t.y] + sphere.positions[t.z]) / 3.0f;
    places.push_back(morton_of(uvec3((p - grid.origin) / grid.voxel)));
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  std::vector<ThesisVoxel> out(places.size());
  for (size_t i = 0; i < places.size(); ++i) out[i].voxel = places[i];
  return out;
}

class HoleReferenceTest : public testing::Test {
 protected:
  void SetUp() override {
    shape_ = test::sphere(5);
    for (vec3& p : shape_.positions) p *= 0.4f;
    voxels_ = sphere_voxels(grid_);
    std::vector<PlainVoxel> plain;
    for (const ThesisVoxel& voxel : voxels_) plain.push_back({voxel.voxel, 0, 0, 0});
    auto svo = make_svo(grid_, plain);
    ASSERT_TRUE(svo);
    svo_ = std::move(*svo);
    motion_ = make_svo_motion(svo_);
    posed_.set_pose(motion_, Pose{});
  }
  SvoSource source() const { return {shape_.triangles, {}, RigidMotion{shape_.positions}}; }
  Visibility draw(const std::vector<ThesisVoxel>& voxels) {
    Visibility picture;
    CornerScratch scratch;
    const CornerVoxels corners = make_corner_voxels(grid_, voxels, 0);
    const CornerInstance instance{&corners, {}, placement_, 0};
    rasterize_corners({&instance, 1}, view_, scratch, picture);
    return picture;
  }

  VoxelGrid grid_ = test::unit_grid(64);
  test::Shape shape_;
  std::vector<ThesisVoxel> voxels_;
  Svo svo_;
  SvoMotion motion_;
  PosedSvo posed_;
  Affine placement_ = trs(vec3(0.1f, 0.05f, 0.0f),
                          glm::angleAxis(0.7f, normalize(vec3(1.0f, 2.0f, 3.0f))), vec3(1.2f));
  RasterView view_ = test::make_view(3.0f, 200.0f, 128, 120);
};

TEST_F(HoleReferenceTest, WholeSphereHasNoHoles) {
  const HoleReference reference(source(), svo_, 0.5f);
  EXPECT_LT(reference.lost(), reference.points() / 1000);
  SurfacePicture surface;
  reference.draw_lattice(posed_, placement_, view_, surface);
  const HoleCount count = count_holes(surface, draw(voxels_));
  EXPECT_GT(count.surface, 2000u);
  EXPECT_EQ(count.holes, 0u);
  EXPECT_LT(count.excess, count.covered / 20);  // turned boxes of 1.3 pixels reach out by as much
}

TEST_F(HoleReferenceTest, LatticeAtRestIsTheSurface) {
  const HoleReference reference(source(), svo_, 1.0f);
  const DistanceSummary distance = reference.distance(posed_);
  EXPECT_GT(distance.points, 1000u);
  EXPECT_LT(distance.largest, 1e-3);
  SurfacePicture by_lattice, truly;
  reference.draw_lattice(posed_, placement_, view_, by_lattice);
  reference.draw_true(Pose{}, placement_, view_, truly);
  size_t different = 0;
  for (size_t i = 0; i < truly.depth.size(); ++i) {
    different += std::isfinite(truly.depth[i]) != std::isfinite(by_lattice.depth[i]);
  }
  EXPECT_LE(different, 6u);  // pixel centres at the very edge
  // Depth at the middle of the sphere: analytic.
  const vec4 center(vec3(placement_[3]), 1.0f);
  const float w = dot(view_.w, center);
  const auto x = static_cast<size_t>(dot(view_.x, center) / w);
  const auto y = static_cast<size_t>(dot(view_.y, center) / w);
  EXPECT_NEAR(truly.depth[y * 128 + x], dot(view_.depth, center) - 1.2f * 0.4f, 2e-3f);
}

TEST_F(HoleReferenceTest, TornOutVoxelsAreHolesAndStrangersExcess) {
  const HoleReference reference(source(), svo_, 0.5f);
  SurfacePicture surface;
  reference.draw_lattice(posed_, placement_, view_, surface);
  // Whoever is in front in the middle of the sphere, and a few around it.
  Visibility picture = draw(voxels_);
  std::vector<ThesisVoxel> torn = voxels_;
  const vec4 center(vec3(placement_[3]), 1.0f);
  const vec2 middle = vec2(dot(view_.x, center), dot(view_.y, center)) / dot(view_.w, center);
  std::vector<VisibilityKey> gone;
  for (int dy = -4; dy <= 4; ++dy) {
    for (int dx = -4; dx <= 4; ++dx) {
      const auto x = static_cast<size_t>(int(middle.x) + dx);
      const auto y = static_cast<size_t>(int(middle.y) + dy);
      gone.push_back(picture.keys[y * 128 + x]);
    }
  }
  std::vector<size_t> numbers;
  for (const VisibilityKey key : gone) {
    numbers.push_back(size_t{key_unit(key)} << 10 | key_code(key));
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  for (size_t i = numbers.size(); i-- > 0;) torn.erase(torn.begin() + ptrdiff_t(numbers[i]));
  torn.push_back({.voxel = morton_of({63, 63, 63})});
  const HoleCount count = count_holes(surface, draw(torn));
  EXPECT_GT(count.holes, 4u);
  EXPECT_LT(count.holes, 150u);
  EXPECT_GT(count.excess, 0u);
}

TEST_F(HoleReferenceTest, LargerPiecesGiveTheSamePicture) {
  SurfacePicture fine, coarse;
  HoleReference(source(), svo_, 0.3f).draw_true(Pose{}, placement_, view_, fine);
  HoleReference(source(), svo_, 8.0f).draw_true(Pose{}, placement_, view_, coarse);
  size_t different = 0;
  for (size_t i = 0; i < fine.depth.size(); ++i) {
    different += std::abs(fine.depth[i] - coarse.depth[i]) > 1e-3f;
  }
  EXPECT_LE(different, 6u);
}

}  // namespace
}  // namespace sinew
