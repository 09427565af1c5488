// Shapes, implicit surfaces and noise that study scenes are made of.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/surface_checks.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/implicit_mesh.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr double kPi = 3.14159265358979;

TEST(Shapes, GeodesicSphereIsClosedAndEven) {
  for (const uint32_t f : {1u, 2u, 3u, 7u, 16u}) {
    const TriangleSurface s = geodesic_sphere(f);
    EXPECT_EQ(s.triangles.size(), 20 * f * f);
    EXPECT_EQ(s.positions.size(), 10 * f * f + 2);
    EXPECT_EQ(why_not_manifold(s.triangles, s.positions.size()), "");
    for (const vec3 p : s.positions) EXPECT_NEAR(length(p), 1.0f, 1e-6f);
    double least = 1e9, most = 0.0;
    for (const uvec3 t : s.triangles) {
      const vec3 n =
          cross(s.positions[t.y] - s.positions[t.x], s.positions[t.z] - s.positions[t.x]);
      EXPECT_GT(dot(n, s.positions[t.x]), 0.0f);
      least = std::min(least, static_cast<double>(length(n)));
      most = std::max(most, static_cast<double>(length(n)));
    }
    EXPECT_LT(most / least, 1.6);
  }
  const TriangleSurface fine = geodesic_sphere(40);
  EXPECT_NEAR(signed_volume6(fine.positions, fine.triangles), 8.0 * kPi, 0.03);
}

TEST(Shapes, TubeIsClosedAndWoundOutwards) {
  const TriangleSurface tube = closed_tube(9, 5, [](float u, float v) {
    const float angle = 6.2831853f * u, r = std::sin(3.1415927f * v);
    return vec3(r * std::sin(angle), -std::cos(3.1415927f * v), r * std::cos(angle));
  });
  EXPECT_EQ(tube.triangles.size(), 90u);
  EXPECT_EQ(why_not_manifold(tube.triangles, tube.positions.size()), "");
  EXPECT_GT(signed_volume6(tube.positions, tube.triangles), 0.0);
}

TEST(Shapes, BoxesAndDiscsFaceTheRightWay) {
  const Mesh out = make_box(vec3(-1.0f), vec3(1.0f, 2.0f, 3.0f), false, 0);
  const Mesh in = make_box(vec3(-1.0f), vec3(1.0f, 2.0f, 3.0f), true, 0);
  EXPECT_NEAR(signed_volume6(out.positions, out.triangles), 6.0 * 24.0, 1e-4);
  EXPECT_NEAR(signed_volume6(in.positions, in.triangles), -6.0 * 24.0, 1e-4);
  const Mesh disc = make_disc({}, 0);
  for (const Mesh* mesh : {&out, &in, &disc}) {
    EXPECT_EQ(validate(*mesh), "");
    for (const uvec3 t : mesh->triangles) {
      const auto& p = mesh->positions;
      const vec3 n = cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
      EXPECT_GT(dot(n, mesh->normals[t.x]), 0.0f);
    }
  }
}

TEST(Shapes, OppositeHalfEdgesOfAnOpenPair) {
  const std::vector<uvec3> pair{{0, 1, 2}, {2, 1, 3}};
  const std::vector<uint32_t> opposite = opposite_half_edges(pair);
  EXPECT_EQ(opposite[1], 3u);
  EXPECT_EQ(opposite[3], 1u);
  EXPECT_EQ(std::ranges::count(opposite, kNoHalfEdge), 4);
}

TEST(ImplicitMesh, BallIsClosedRoundAndOnTheSurface) {
  const Field ball = [](vec3 p) { return length(p - vec3(0.3f, -0.2f, 0.1f)) - 0.8f; };
  const Box box{vec3(-0.7f, -1.2f, -0.9f), vec3(1.3f, 0.8f, 1.1f)};
  for (const float cell : {0.21f, 0.07f}) {
    const ImplicitMesh mesh = mesh_implicit(ball, {box, cell, 4});
    EXPECT_EQ(why_not_manifold(mesh.surface.triangles, mesh.surface.positions.size()), "");
    for (size_t v = 0; v < mesh.normals.size(); ++v) {
      EXPECT_NEAR(ball(mesh.surface.positions[v]), 0.0f, 1e-4f);
      EXPECT_GT(
          dot(mesh.normals[v], normalize(mesh.surface.positions[v] - vec3(0.3f, -0.2f, 0.1f))),
          0.999f);
    }
    for (const uvec3 t : mesh.surface.triangles) {
      const auto& p = mesh.surface.positions;
      const vec3 n = cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
      EXPECT_GT(dot(n, mesh.normals[t.x]), 0.0f);
    }
  }
  const float cell = cell_for_triangles(ball, box, 9000);
  EXPECT_NEAR(static_cast<double>(mesh_implicit(ball, {box, cell, 0}).surface.triangles.size()),
              9000.0, 450.0);
}

// Thin gaps, touching sheets, and surfaces much smaller than a cell stay closed manifolds.
TEST(ImplicitMesh, RandomBallsAreManifold) {
  constexpr uint32_t kSeed = 20261;
  Random random(kSeed);
  for (int round = 0; round < 6; ++round) {
    std::vector<vec4> balls;
    for (int i = 0; i < 25; ++i) {
      balls.push_back(vec4(random.uniform3(-1.0f, 1.0f), random.uniform(0.03f, 0.4f)));
    }
    const Field field = [&](vec3 p) {
      float d = 1e3f;
      for (const vec4& b : balls) d = std::min(d, length(p - vec3(b)) - b.w);
      return std::max(d, 0.18f - length(p));
    };
    const ImplicitMesh mesh = mesh_implicit(field, {{vec3(-1.5f), vec3(1.5f)}, 0.09f, 2});
    EXPECT_EQ(why_not_manifold(mesh.surface.triangles, mesh.surface.positions.size()), "")
        << "seed " << kSeed << ", round " << round;
    for (const vec3 p : mesh.surface.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

TEST(Noise, GradientNoiseIsZeroAtLatticePointsSmoothAndBounded) {
  EXPECT_EQ(gradient_noise(vec3(3.0f, -2.0f, 7.0f), 1), 0.0f);
  Random random(5);
  float most = 0.0f;
  for (int i = 0; i < 20000; ++i) {
    const vec3 p = random.uniform3(-9.0f, 9.0f);
    const float a = gradient_noise(p, 3);
    most = std::max(most, std::abs(a));
    EXPECT_LT(std::abs(a - gradient_noise(p + vec3(1e-3f, 0.0f, 0.0f), 3)), 6e-3f) << "seed 5";
  }
  EXPECT_GT(most, 0.6f);
  EXPECT_LT(most, 1.2f);
}

TEST(Noise, CellularNoiseFindsTheNearestPoint) {
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    const vec3 p = random.uniform3(-5.0f, 5.0f);
    const Cells cells = cellular_noise(p, 0.9f, 2);
    EXPECT_LE(cells.nearest, cells.second);
    EXPECT_NEAR(length(cells.to_nearest), cells.nearest, 1e-5f);
    EXPECT_NEAR(length(cells.to_second), cells.second, 1e-5f);
    // At the nearest point itself the distance is zero and the cell the same.
    const Cells there = cellular_noise(p + cells.to_nearest, 0.9f, 2);
    EXPECT_LT(there.nearest, 1e-5f);
    EXPECT_EQ(there.id, cells.id) << "seed 6";
  }
}

TEST(Stage, FacingTurnsMinusZ) {
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const vec3 d = i == 0 ? vec3(0.0f, 1.0f, 0.0f) : random.direction();
    const quat q = facing(d);
    EXPECT_LT(length(q * vec3(0.0f, 0.0f, -1.0f) - d), 1e-5f) << "seed 7";
    EXPECT_GE((q * vec3(0.0f, 1.0f, 0.0f)).y, -1e-5f);
  }
}

}  // namespace
}  // namespace sinew
