// The voxeliser against tests of every voxel with every triangle.
#include "sinew/svo/make/voxelize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "shapes.h"
#include "sinew/base/parallel.h"
#include "svo/voxel_oracle.h"

namespace sinew {
namespace {

using test::Shape;

constexpr auto kPlain = [](const SurfaceBatch& batch) {
  std::fill(batch.normals.begin(), batch.normals.end(), uint16_t{0});
  std::fill(batch.colors.begin(), batch.colors.end(), uint16_t{0});
};

VoxelSurface voxelized(const Shape& shape, const VoxelGrid& grid, const VoxelizeOptions& options) {
  Result<VoxelSurface> surface = voxelize(shape.positions, shape.triangles, grid, kPlain, options);
  EXPECT_TRUE(surface) << surface.error().message();
  return std::move(*surface);
}

// Every invariant of fragments.h.
void expect_valid(const VoxelSurface& surface) {
  uint64_t voxels = 0;
  for (size_t i = 0; i < surface.fragments.size(); ++i) {
    const VoxelFragment& f = surface.fragments[i];
    ASSERT_TRUE(glm::all(glm::lessThan(voxel_of(f.voxel), surface.grid.resolution)));
    voxels += i == 0 || f.voxel != surface.fragments[i - 1].voxel;
    if (i == 0) continue;
    const VoxelFragment& before = surface.fragments[i - 1];
    ASSERT_TRUE(before.voxel < f.voxel ||
                (before.voxel == f.voxel && before.triangle < f.triangle));
  }
  EXPECT_EQ(surface.voxels, voxels);
}

using Pairs = std::set<std::pair<VoxelMorton, uint32_t>>;

Pairs pairs_of(const VoxelSurface& surface) {
  Pairs pairs;
  for (const VoxelFragment& f : surface.fragments) pairs.insert({f.voxel, f.triangle});
  return pairs;
}

Pairs brute_force(const Shape& shape, const VoxelGrid& grid, Shell shell) {
  Pairs pairs;
  for (uint32_t t = 0; t < shape.triangles.size(); ++t) {
    glm::dvec3 v[3];
    for (int k = 0; k < 3; ++k) {
      v[k] = (glm::dvec3(shape.positions[shape.triangles[t][k]]) - glm::dvec3(grid.origin)) /
             static_cast<double>(grid.voxel);
    }
    if (cross(v[1] - v[0], v[2] - v[0]) == glm::dvec3(0.0)) continue;
    for (uint32_t z = 0; z < grid.resolution.z; ++z) {
      for (uint32_t y = 0; y < grid.resolution.y; ++y) {
        for (uint32_t x = 0; x < grid.resolution.x; ++x) {
          if (test::shell_has(v, glm::dvec3(x, y, z), shell)) {
            pairs.insert({morton_of({x, y, z}), t});
          }
        }
      }
    }
  }
  return pairs;
}

void expect_exact(const Shape& shape, const VoxelGrid& grid) {
  for (const Shell shell : {Shell::thin, Shell::conservative}) {
    const VoxelSurface surface = voxelized(shape, grid, {.shell = shell});
    expect_valid(surface);
    EXPECT_EQ(pairs_of(surface), brute_force(shape, grid, shell))
        << (shell == Shell::thin ? "thin" : "conservative");
  }
}

TEST(Voxelize, RandomTrianglesAsBruteForceSays) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const float size = std::exp2(random.uniform(-7.0f, 0.0f));
    const Shape shape = test::random_triangles(6, seed, size);
    // From a block to several of them.
    const auto resolution = static_cast<uint32_t>(random.uniform(1.0f, 90.0f));
    const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), resolution);
    ASSERT_TRUE(grid) << grid.error().message();
    expect_exact(shape, *grid);
  }
}

TEST(Voxelize, CoordinatesOnFacesAsBruteForceSays) {
  for (uint32_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Shape shape;
    // Halves of voxels, so that corners, edges and planes often run between voxels.
    const auto corner = [&] { return glm::floor(random.uniform3(2.0f, 44.0f)) * 0.5f; };
    for (uint32_t i = 0; i < 24; ++i) {
      vec3 a = corner(), b = corner(), c = corner();
      if (i % 4 == 0) b.z = a.z, c.z = a.z;
      if (i % 4 == 1) b.x = a.x + (b.y - a.y), c.x = a.x + (c.y - a.y);  // a diagonal plane
      if (i % 4 == 2) b = a + vec3(1.0f, 0.0f, 0.5f), c = a + vec3(0.0f, 0.5f, 1.0f);
      shape.positions.insert(shape.positions.end(), {a, b, c});
      shape.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    expect_exact(shape, {vec3(-4.0f), 1.0f, uvec3(40)});
    expect_exact(shape, {vec3(-53.0f), 1.0f, uvec3(76)});  // over a border between blocks
  }
}

TEST(Voxelize, TrianglesThatLeaveTheGridAreCut) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Shape shape = test::random_triangles(10, seed, 3.0f);
    expect_exact(shape, {vec3(0.1f), 1.0f / 32.0f, uvec3(20, 33, 7)});
  }
}

TEST(Voxelize, SliversAndHugeTriangles) {
  Shape shape;
  shape.positions = {{0.0f, 0.0f, 0.0f},    {1.0f, 1.0f, 1.0f},    {1.0f, 1.0f, 1.0000001f},
                     {-1e7f, 0.5f, -1e7f},  {1e7f, 0.5f, -1e7f},   {0.0f, 0.51f, 1e7f},
                     {0.25f, 0.25f, 0.25f}, {0.25f, 0.25f, 0.75f}, {0.2500001f, 0.25f, 0.25f}};
  shape.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  expect_exact(shape, {vec3(-0.01f), 1.0f / 16.0f, uvec3(17)});
}

TEST(Voxelize, WhatIsNoTriangleHasNoFragments) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  Shape shape;
  shape.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}, {infinity, 0, 0}, {2, 0, 0}};
  shape.triangles = {{0, 1, 3}, {0, 0, 1}, {0, 1, 4}, {0, 1, 5}, {0, 1, 2}, {3, 3, 3}};
  const Box box = surface_box(shape.positions, shape.triangles);
  EXPECT_EQ(box.min, vec3(0.0f));
  EXPECT_EQ(box.max, vec3(1.0f, 1.0f, 0.0f));
  const auto grid = grid_of_resolution(box, 8);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->resolution, uvec3(8, 8, 1));
  const VoxelSurface surface = voxelized(shape, *grid, {.shell = Shell::conservative});
  EXPECT_GT(surface.voxels, 30u);
  for (const VoxelFragment& f : surface.fragments) EXPECT_EQ(f.triangle, 4u);
  shape.triangles.resize(4);
  EXPECT_TRUE(surface_box(shape.positions, shape.triangles).empty());
  EXPECT_EQ(voxelized(shape, *grid, {}).voxels, 0u);
}

TEST(Voxelize, SameBitsForAnyNumberOfThreads) {
  const Shape shape = test::sphere(5);
  const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 200);
  ASSERT_TRUE(grid);
  const VoxelizeOptions options{.shell = Shell::conservative, .solid = true};
  const VoxelSurface many = voxelized(shape, *grid, options);
  const ThreadLimit limit(1);
  const VoxelSurface one = voxelized(shape, *grid, options);
  ASSERT_EQ(one.fragments.size(), many.fragments.size());
  EXPECT_TRUE(std::equal(one.fragments.begin(), one.fragments.end(), many.fragments.begin(),
                         [](const VoxelFragment& a, const VoxelFragment& b) {
                           return a.voxel == b.voxel && a.triangle == b.triangle;
                         }));
}

TEST(Voxelize, LooksAreAskedForAtTheNearestPoints) {
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Shape shape = test::random_triangles(20, seed, 0.3f);
    const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 40);
    ASSERT_TRUE(grid);
    // Which point that was: weights in 8 bits each.
    const auto look = [](const SurfaceBatch& batch) {
      for (size_t i = 0; i < batch.u.size(); ++i) {
        batch.normals[i] = static_cast<uint16_t>(std::clamp(batch.u[i], 0.0f, 1.0f) * 65535.0f);
        batch.colors[i] = static_cast<uint16_t>(std::clamp(batch.v[i], 0.0f, 1.0f) * 65535.0f);
        ASSERT_LT(batch.u[i] + batch.v[i], 1.0001f);
      }
    };
    const auto surface =
        voxelize(shape.positions, shape.triangles, *grid, look, {.shell = Shell::conservative});
    ASSERT_TRUE(surface);
    EXPECT_GT(surface->fragments.size(), 500u);
    for (const VoxelFragment& f : surface->fragments) {
      glm::dvec3 v[3];
      for (int k = 0; k < 3; ++k) v[k] = shape.positions[shape.triangles[f.triangle][k]];
      const glm::dvec3 center(grid->center(voxel_of(f.voxel)));
      const double u = f.normal / 65535.0, w = f.color / 65535.0;
      const glm::dvec3 point = v[0] + u * (v[1] - v[0]) + w * (v[2] - v[0]);
      const double nearest = length(test::nearest_point(v, center) - center);
      // As near as there is any: a voxel's hundredth for float and the 16 bits.
      ASSERT_LT(length(point - center), nearest + 0.01 * grid->voxel);
    }
  }
}

TEST(Voxelize, WhatTheLookLeavesOutIsNotThere) {
  const Shape shape = test::sphere(3);
  const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 50);
  ASSERT_TRUE(grid);
  const auto look = [](const SurfaceBatch& batch) {
    kPlain(batch);
    if (batch.triangle % 2 == 0) std::fill(batch.present.begin(), batch.present.end(), uint8_t{0});
  };
  const auto surface = voxelize(shape.positions, shape.triangles, *grid, look);
  ASSERT_TRUE(surface);
  expect_valid(*surface);
  EXPECT_GT(surface->voxels, 1000u);
  for (const VoxelFragment& f : surface->fragments) EXPECT_EQ(f.triangle % 2, 1u);
}

// Whether each voxel is in the surface, x fastest.
std::vector<uint8_t> dense(const VoxelSurface& surface) {
  const uvec3 n = surface.grid.resolution;
  std::vector<uint8_t> bits(size_t{n.x} * n.y * n.z, 0);
  for (const VoxelFragment& f : surface.fragments) {
    const uvec3 v = voxel_of(f.voxel);
    bits[v.x + n.x * (v.y + size_t{n.y} * v.z)] = 1;
  }
  return bits;
}

// Adds to the shell whatever cannot be reached from the border.
std::vector<uint8_t> filled(std::vector<uint8_t> shell, uvec3 n) {
  std::vector<glm::ivec3> stack;
  const auto visit = [&](glm::ivec3 v) {
    if (any(lessThan(v, glm::ivec3(0))) || any(greaterThanEqual(v, glm::ivec3(n)))) return;
    uint8_t& bit = shell[static_cast<size_t>(v.x) +
                         n.x * (static_cast<size_t>(v.y) + size_t{n.y} * static_cast<size_t>(v.z))];
    if (bit != 0) return;
    bit = 2;
    stack.push_back(v);
  };
  for (int z = 0; z < static_cast<int>(n.z); ++z) {
    for (int y = 0; y < static_cast<int>(n.y); ++y) {
      for (int x = 0; x < static_cast<int>(n.x); ++x) {
        const glm::ivec3 v(x, y, z);
        if (any(equal(v, glm::ivec3(0))) || any(equal(v + 1, glm::ivec3(n)))) visit(v);
      }
    }
  }
  while (!stack.empty()) {
    const glm::ivec3 v = stack.back();
    stack.pop_back();
    for (int k = 0; k < 3; ++k) {
      glm::ivec3 step(0);
      step[k] = 1;
      visit(v + step);
      visit(v - step);
    }
  }
  for (uint8_t& bit : shell) bit = bit != 2;
  return shell;
}

TEST(Voxelize, SolidsAreWhatCannotBeReachedFromOutside) {
  for (const uint32_t resolution : {1u, 2u, 5u, 63u, 64u, 65u, 130u}) {
    for (const Shell shell : {Shell::thin, Shell::conservative}) {
      SCOPED_TRACE(testing::Message() << resolution << " voxels");
      const Shape shape = test::sphere(4);
      const auto grid =
          grid_of_resolution(surface_box(shape.positions, shape.triangles), resolution);
      ASSERT_TRUE(grid);
      const VoxelSurface hollow = voxelized(shape, *grid, {.shell = shell});
      const VoxelSurface solid = voxelized(shape, *grid, {.shell = shell, .solid = true});
      expect_valid(solid);
      EXPECT_EQ(dense(solid), filled(dense(hollow), grid->resolution));
      if (resolution < 130) continue;
      const double radius = 1.0 / grid->voxel;
      EXPECT_NEAR(static_cast<double>(solid.voxels), 4.18879 * radius * radius * radius,
                  0.05 * static_cast<double>(solid.voxels));
    }
  }
}

TEST(Voxelize, OpenMeshesHoldWhatTheirShellsEnclose) {
  Shape shape = test::sphere(4);
  std::erase_if(shape.triangles, [&](uvec3 t) { return shape.positions[t.x].z > 0.5f; });
  const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 100);
  ASSERT_TRUE(grid);
  const VoxelSurface bowl = voxelized(shape, *grid, {.solid = true});
  EXPECT_EQ(bowl.voxels, voxelized(shape, *grid, {}).voxels);
}

// In a maze of random voxels the flood has to turn round, within blocks and between them.
TEST(Voxelize, MazesAreFlooded) {
  for (uint32_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Shape shape = test::random_triangles(seed == 1 ? 6000 : 60000, seed, 0.03f);
    const VoxelGrid grid{vec3(-0.1f), 1.2f / 150.0f, uvec3(150)};
    const VoxelSurface hollow = voxelized(shape, grid, {});
    const VoxelSurface solid = voxelized(shape, grid, {.solid = true});
    expect_valid(solid);
    EXPECT_GT(solid.voxels, hollow.voxels);
    EXPECT_EQ(dense(solid), filled(dense(hollow), grid.resolution));
  }
}

TEST(Voxelize, ThinShellsLetNothingThroughAndAreThinner) {
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Shape shape = test::sphere(4);
    const quat turn = normalize(quat(random.uniform(), random.uniform(), 0.3f, 0.7f));
    for (vec3& p : shape.positions) p = turn * p * vec3(1.0f, 0.4f, 0.7f);
    const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 130);
    ASSERT_TRUE(grid);
    const VoxelSurface thin = voxelized(shape, *grid, {});
    const VoxelSurface thick = voxelized(shape, *grid, {.shell = Shell::conservative});
    const Pairs all = pairs_of(thick);
    for (const auto& pair : pairs_of(thin)) ASSERT_TRUE(all.contains(pair));
    EXPECT_LT(static_cast<double>(thin.voxels), 0.7 * static_cast<double>(thick.voxels));
    const std::vector<uint8_t> solid = filled(dense(thin), grid->resolution);
    const uvec3 middle = grid->resolution / 2u;
    EXPECT_EQ(
        solid[middle.x + grid->resolution.x * (middle.y + size_t{grid->resolution.y} * middle.z)],
        1);
  }
}

TEST(Voxelize, MoreMemoryThanAllowedIsAnError) {
  const Shape shape = test::sphere(3);
  const auto grid = grid_of_resolution(surface_box(shape.positions, shape.triangles), 100);
  ASSERT_TRUE(grid);
  for (const bool solid : {false, true}) {
    const auto surface = voxelize(shape.positions, shape.triangles, *grid, kPlain,
                                  {.solid = solid, .memory_limit = solid ? 4u << 20 : 1u << 16});
    ASSERT_FALSE(surface);
    EXPECT_EQ(surface.error().kind, ErrorKind::runtime);
  }
}

}  // namespace
}  // namespace sinew
