#include "sinew/io/aff/animated.h"

#include <gtest/gtest.h>

#include <map>

#include "sinew/math/random.h"

namespace sinew::aff {
namespace {

TEST(AffAnimated, ComplexityIsTheExponentOfFour) {
  EXPECT_EQ(complexity_of(1), 0);
  EXPECT_EQ(complexity_of(1024), 5);
  EXPECT_EQ(complexity_of(65'536), 8);
  for (const size_t other : {0, 2, 12, 1000, 2048}) EXPECT_FALSE(complexity_of(other)) << other;
}

TEST(AffAnimated, SpheresAreFoundByTheirPointsAlone) {
  const uint32_t seed = 3;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  std::vector<vec3> points;
  for (int i = 0; i < 40; ++i) points.push_back(vec3(1, 20, -3) + 0.8f * random.direction());
  const auto sphere = sphere_through(points);
  ASSERT_TRUE(sphere);
  EXPECT_NEAR(distance(sphere->center, vec3(1, 20, -3)), 0.0f, 1e-5f);
  EXPECT_NEAR(sphere->radius, 0.8f, 1e-5f);

  EXPECT_FALSE(sphere_through(std::span(points).first(15))) << "too few to tell";
  points[7] *= 1.001f;
  EXPECT_FALSE(sphere_through(points));
  for (vec3& p : points) p.y = 0.0f;
  EXPECT_FALSE(sphere_through(points)) << "a plane";
  EXPECT_FALSE(sphere_through(std::vector<vec3>(20, vec3(1.0f)))) << "a point";
}

TEST(AffAnimated, SplitTrianglesShareTheMiddlesOfTheirEdges) {
  // A square of two triangles in two keys.
  AnimatedTriangles in;
  in.times = {0.0f, 1.0f};
  in.materials = {0, 4};
  const vec3 square[4] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  for (const auto& triangle : {std::array{0, 1, 2}, {0, 2, 3}}) {
    for (const float lift : {0.0f, 5.0f}) {
      for (const int corner : triangle) in.positions.push_back(square[corner] + vec3(0, 0, lift));
    }
  }
  Mesh mesh = make_animated_mesh(in);
  mesh.name = "square";
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.parts.size(), 2u);
  subdivide(mesh);
  EXPECT_EQ(mesh.positions.size(), 9u) << "the diagonal is split once";
  ASSERT_EQ(mesh.triangles.size(), 8u);
  subdivide(mesh);
  EXPECT_EQ(mesh.positions.size(), 25u);
  EXPECT_EQ(mesh.triangles.size(), 32u);
  EXPECT_EQ(validate(mesh), "");
  std::map<uint32_t, int> of_part;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3 t = mesh.triangles[i];
    const vec3* p = mesh.key_positions.data() + 25;
    EXPECT_FLOAT_EQ(cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).z, 4.0f / 16) << "turned as before";
    EXPECT_FLOAT_EQ(p[t.x].z, 5.0f);
    ++of_part[mesh.triangle_part[i]];
  }
  EXPECT_EQ(of_part[0], 16);
}

}  // namespace
}  // namespace sinew::aff
