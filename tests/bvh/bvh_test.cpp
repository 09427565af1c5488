// Ray queries against brute force in double, watertightness, and updates.
#include "sinew/bvh/bvh.h"

#include <gtest/gtest.h>

#include <cstring>

#include "oracle.h"
#include "shapes.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/update/update.h"

namespace sinew {
namespace {

void expect_true_hits(const Bvh& bvh, std::span<const vec3> positions,
                      std::span<const uvec3> triangles, size_t rays, uint32_t seed) {
  const std::vector<Ray> set = test::test_rays(positions, triangles, rays, seed);
  std::vector<Hit> hits(set.size());
  std::vector<uint8_t> any(set.size());
  bvh.closest_hits(set, hits);
  bvh.any_hits(set, any);
  test::Agreement agreement;
  for (size_t i = 0; i < set.size(); ++i) {
    EXPECT_EQ(any[i] != 0, static_cast<bool>(hits[i])) << "ray " << i << " seed " << seed;
    test::judge(set[i], hits[i], test::brute_force(set[i], positions, triangles), agreement);
  }
  EXPECT_EQ(agreement.wrong, 0u) << agreement.first_wrong << " (seed " << seed << ")";
  EXPECT_LT(agreement.doubtful_fraction(), 0.02) << "seed " << seed;
  EXPECT_GT(agreement.hits, rays / 8);
}

TEST(Bvh, FindsWhatBruteForceFinds) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    for (const size_t count : {1, 5, 60, 2000}) {
      const auto shape = test::random_triangles(count, seed, count < 10 ? 1.0f : 0.1f);
      const Bvh bvh = *build(shape.positions, shape.triangles);
      expect_true_hits(bvh, shape.positions, shape.triangles, 500, seed);
    }
  }
}

TEST(Bvh, UpdateFollowsTheVertices) {
  const auto shape = test::sphere(4);
  Bvh bvh = *build(shape.positions, shape.triangles);
  for (const float amount : {0.3f, 1.5f, -4.0f, 0.0f}) {
    const auto moved = test::twisted(shape.positions, amount);
    ASSERT_TRUE(bvh.update(moved));
    expect_true_hits(bvh, moved, shape.triangles, 500, 17);
  }
}

TEST(Bvh, UpdateWithTheWrongNumberOfVerticesIsAnError) {
  const auto shape = test::sphere(1);
  Bvh bvh = *build(shape.positions, shape.triangles);
  const std::vector<vec3> fewer(shape.positions.begin(), shape.positions.end() - 1);
  ASSERT_FALSE(bvh.update(fewer));
  EXPECT_EQ(bvh.update(fewer).error().kind, ErrorKind::usage);
}

TEST(Bvh, BadInputIsAnError) {
  const std::vector<vec3> positions = {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)};
  const std::vector<uvec3> out_of_range = {{0, 1, 3}};
  EXPECT_EQ(build(positions, out_of_range).error().element, "triangle 0");
  const std::vector<vec3> infinite = {vec3(0), vec3(INFINITY, 0, 0), vec3(0, 1, 0)};
  const std::vector<uvec3> good = {{0, 1, 2}};
  EXPECT_EQ(build(infinite, good).error().element, "vertex 1");
}

TEST(Bvh, NothingIsHitByNothing) {
  const Bvh bvh = *build({}, {});
  EXPECT_FALSE(bvh.closest_hit(Ray()));
  EXPECT_TRUE(bvh.box().empty());
}

TEST(Bvh, HitByHand) {
  const std::vector<vec3> positions = {vec3(0), vec3(4, 0, 0), vec3(0, 4, 0)};
  const std::vector<uvec3> triangles = {{0, 1, 2}};
  const Bvh bvh = *build(positions, triangles);
  const auto hit = bvh.closest_hit({.origin = vec3(1, 2, 6), .direction = vec3(0, 0, -2)});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->t, 3.0f);
  EXPECT_EQ(hit->u, 0.25f);
  EXPECT_EQ(hit->v, 0.5f);
  EXPECT_EQ(hit->primitive, 0u);
  // The range is closed at both ends.
  Ray ray{.origin = vec3(1, 2, 6), .t_min = 3.0f, .direction = vec3(0, 0, -2), .t_max = 3.0f};
  EXPECT_TRUE(bvh.any_hit(ray));
  ray.t_min = 0.0f;
  ray.t_max = 2.999f;
  EXPECT_FALSE(bvh.any_hit(ray));
}

TEST(Bvh, OfEqualHitsTheLeastPrimitiveCounts) {
  std::vector<vec3> positions = {vec3(0), vec3(4, 0, 0), vec3(0, 4, 0)};
  const std::vector<uvec3> triangles(100, uvec3(0, 1, 2));
  const Bvh bvh = *build(positions, triangles);
  EXPECT_EQ(bvh.closest_hit({.origin = vec3(1, 1, 1)})->primitive, 0u);
}

TEST(Bvh, AxisParallelRaysOnBoxPlanesHit) {
  // A unit quad; rays along -z through its edges, its diagonal and its corners.
  const std::vector<vec3> positions = {vec3(0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0)};
  const std::vector<uvec3> triangles = {{0, 1, 2}, {0, 2, 3}};
  const Bvh bvh = *build(positions, triangles);
  for (int i = 0; i <= 8; ++i) {
    for (int j = 0; j <= 8; ++j) {
      EXPECT_TRUE(bvh.any_hit({.origin = vec3(float(i) / 8, float(j) / 8, 1)})) << i << " " << j;
    }
  }
}

TEST(Bvh, TrianglesThatAreNotFiniteAreNeverHitAndHideNothing) {
  auto shape = test::sphere(3);
  Bvh bvh = *build(shape.positions, shape.triangles);
  auto broken = shape.positions;
  broken[3] = vec3(NAN);
  broken[40].y = INFINITY;
  ASSERT_TRUE(bvh.update(broken));
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{.origin = vec3(0.01f), .direction = random.direction()};
    const auto hit = bvh.closest_hit(ray);
    if (!hit) continue;
    const uvec3 t = shape.triangles[hit->primitive];
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(t[k] != 3 && t[k] != 40);
  }
  std::vector<TriangleId> found;
  bvh.triangles_in_box({vec3(-2.0f), vec3(2.0f)}, found);
  EXPECT_GT(found.size(), shape.triangles.size() / 2);
  for (const TriangleId id : found) {
    const uvec3 t = shape.triangles[id.primitive];
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(t[k] != 3 && t[k] != 40);
  }
}

// Closed meshes seen from inside: no ray gets out, wherever and however large the mesh is.
TEST(Watertight, NoRayLeavesAClosedDeformedMesh) {
  const auto shape = test::sphere(5);
  Bvh bvh = *build(shape.positions, shape.triangles);
  Random random(99);
  int missed = 0;
  for (const float scale : {1.0f, 1e-8f, 1e8f}) {
    for (const float offset : {0.0f, 1e3f, 1e6f}) {
      if (offset > 0 && scale != 1.0f) continue;
      // Far from the origin coordinates are coarse: the mesh must stay larger than their step.
      auto moved = test::twisted(shape.positions, 1.3f);
      const float size = offset >= 1e6f ? 100.0f : 1.0f;
      for (vec3& p : moved) p = p * scale * size + vec3(offset, -offset, 0.5f * offset);
      ASSERT_TRUE(bvh.update(moved));
      const vec3 inside = vec3(offset, -offset, 0.5f * offset);
      for (int i = 0; i < 20000; ++i) {
        vec3 direction = random.direction();
        if (i % 4 == 0) {  // straight at vertices, where triangles meet
          direction = moved[random.next() % moved.size()] - inside;
        } else if (i % 4 == 1) {  // straight at edges
          const uvec3 t = shape.triangles[random.next() % shape.triangles.size()];
          const float u = random.uniform();
          direction = moved[t.x] * u + moved[t.y] * (1 - u) - inside;
        }
        missed += !bvh.any_hit({.origin = inside, .direction = direction});
      }
    }
  }
  EXPECT_EQ(missed, 0);
}

TEST(Update, EveryInvariantHoldsAfterEveryPose) {
  const auto shape = test::sphere(5);
  std::vector<Box> boxes(shape.triangles.size());
  triangle_boxes(shape.positions, shape.triangles, boxes);
  const Tree tree = build_binned(boxes);
  for (const uint32_t treelet : {1u, 16u, 64u, kMaxTreeletTriangles}) {
    const Bvh8Layout layout = *make_layout(tree, half_areas(refit(tree, boxes)), shape.triangles,
                                           static_cast<uint32_t>(shape.positions.size()), treelet);
    Bvh8 bvh;
    for (const float amount : {0.0f, 0.9f, -7.0f}) {
      const auto moved = test::twisted(shape.positions, amount);
      update_full(layout, moved, bvh);
      EXPECT_EQ(validate(layout, bvh, moved, shape.triangles), "") << treelet << " " << amount;
    }
    // A validator that cannot fail proves nothing: vertices that moved on must be noticed.
    EXPECT_NE(validate(layout, bvh, shape.positions, shape.triangles), "");
  }
}

TEST(Update, SameBitsForAnyThreadCount) {
  const auto shape = test::sphere(6);
  std::vector<Box> boxes(shape.triangles.size());
  triangle_boxes(shape.positions, shape.triangles, boxes);
  const Tree tree = build_binned(boxes);
  const Bvh8Layout layout = *make_layout(tree, half_areas(refit(tree, boxes)), shape.triangles,
                                         static_cast<uint32_t>(shape.positions.size()));
  Bvh8 reference;
  update_full(layout, test::twisted(shape.positions, 0.5f), reference);
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    Bvh8 bvh;
    update_full(layout, test::twisted(shape.positions, 2.0f), bvh);
    update_full(layout, test::twisted(shape.positions, 0.5f), bvh);
    EXPECT_EQ(
        0, std::memcmp(bvh.nodes.data(), reference.nodes.data(), bvh.nodes.size() * sizeof(Node8)));
    EXPECT_EQ(0, std::memcmp(bvh.packets.data(), reference.packets.data(),
                             bvh.packets.size() * sizeof(TrianglePacket)));
  }
}

std::vector<Hit> hits_of(const Bvh& bvh, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  bvh.closest_hits(rays, hits);
  return hits;
}

bool same_bits(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0;
}

TEST(Update, ARangeOfVerticesIsAsGoodAsAll) {
  const auto shape = test::sphere(5);
  for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::automatic}) {
    Bvh all = *build(shape.positions, shape.triangles);
    Bvh part = *build(shape.positions, shape.triangles);
    part.set_update_mode(mode);
    auto moved = test::twisted(shape.positions, 0.4f);
    ASSERT_TRUE(part.update(moved));
    Random random(31);
    for (int round = 0; round < 20; ++round) {
      VertexRange range;
      range.first = random.next() % uint32_t(moved.size());
      range.count = std::min(1 + random.next() % 40, uint32_t(moved.size()) - range.first);
      for (uint32_t v = range.first; v < range.first + range.count; ++v) {
        moved[v] += 0.2f * random.direction();
      }
      ASSERT_TRUE(part.update(moved, range));
      ASSERT_TRUE(all.update(moved));
      const auto rays = test::test_rays(moved, shape.triangles, 300, uint32_t(round));
      EXPECT_TRUE(same_bits(hits_of(all, rays), hits_of(part, rays)))
          << name_of(mode) << " round " << round << " seed 31";
      EXPECT_EQ(all.box().min, part.box().min);
      EXPECT_EQ(all.box().max, part.box().max);
    }
    EXPECT_EQ(part.update(moved, {uint32_t(moved.size()) - 1, 2}).error().kind, ErrorKind::usage);
    EXPECT_EQ(part.update(moved, {0xffffffffu, 0xffffffffu}).error().kind, ErrorKind::usage);
  }
}

TEST(Update, BorrowedAndStagedVerticesAreAsGoodAsCopied) {
  const auto shape = test::sphere(5);
  const auto moved = test::twisted(shape.positions, 1.0f);
  const auto rays = test::test_rays(moved, shape.triangles, 2000, 3);
  Bvh reference = *build(shape.positions, shape.triangles);
  const std::vector<Hit> before = hits_of(reference, rays);
  ASSERT_TRUE(reference.update(moved));
  const std::vector<Hit> after = hits_of(reference, rays);
  for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid}) {
    Bvh bvh = *build(shape.positions, shape.triangles);
    bvh.set_update_mode(mode);
    bvh.flip();  // nothing is staged
    EXPECT_TRUE(same_bits(before, hits_of(bvh, rays)));
    ASSERT_TRUE(bvh.stage(moved));
    EXPECT_TRUE(same_bits(before, hits_of(bvh, rays)));
    bvh.flip();
    EXPECT_TRUE(same_bits(after, hits_of(bvh, rays)));
    ASSERT_TRUE(bvh.update_borrowed(shape.positions));
    EXPECT_TRUE(same_bits(before, hits_of(bvh, rays)));
    // A range after borrowed vertices, and after copies of them.
    ASSERT_TRUE(bvh.update(moved, {0, uint32_t(moved.size())}));
    EXPECT_TRUE(same_bits(after, hits_of(bvh, rays)));
  }
}

TEST(Update, ARangeOfWhatWasNeverStagedIsAllOfIt) {
  const auto shape = test::sphere(3);
  Bvh bvh = *build(shape.positions, shape.triangles);
  bvh.flip();
  ASSERT_TRUE(bvh.update(shape.positions, {5, 1}));
  EXPECT_TRUE(bvh.any_hit({.origin = vec3(0.1f, 0.2f, 9.0f)}));
}

TEST(Update, OfARangeNoMoreTreeletsAreMadeThanThereAre) {
  const auto shape = test::sphere(4);
  Bvh bvh = *build(shape.positions, shape.triangles);
  bvh.set_update_mode(UpdateMode::hybrid);
  ASSERT_TRUE(bvh.update(shape.positions));
  const auto rays = test::test_rays(shape.positions, shape.triangles, 2000, 3);
  for (int round = 0; round < 3; ++round) {
    hits_of(bvh, rays);
    EXPECT_GT(bvh.treelets_made(), 0u);
    EXPECT_LE(bvh.treelets_made(), bvh.treelet_count());
    ASSERT_TRUE(bvh.update(shape.positions, {0, uint32_t(shape.positions.size()) / 2}));
    EXPECT_EQ(bvh.treelets_made(), 0u);
  }
}

TEST(Update, HybridMakesOnlyWhatRaysReach) {
  const auto shape = test::sphere(6);
  Bvh bvh = *build(shape.positions, shape.triangles);
  bvh.set_update_mode(UpdateMode::hybrid);
  ASSERT_TRUE(bvh.update(test::twisted(shape.positions, 1.0f)));
  EXPECT_EQ(bvh.treelets_made(), 0u);
  EXPECT_TRUE(bvh.any_hit({.origin = vec3(0.1f, 0.2f, 9.0f)}));
  EXPECT_GE(bvh.treelets_made(), 1u);
  EXPECT_LT(bvh.treelets_made(), 12u);
  EXPECT_GT(bvh.treelet_count(), 500u);
}

TEST(Update, CostRatioTellsHowMuchWorseTheTreeIs) {
  const auto shape = test::sphere(6);
  Bvh bvh = *build(shape.positions, shape.triangles);
  EXPECT_EQ(bvh.cost_ratio(), 1.0);
  for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid}) {
    bvh.set_update_mode(mode);
    std::vector<vec3> larger = shape.positions;
    for (vec3& p : larger) p *= 7.0f;
    ASSERT_TRUE(bvh.update(larger));
    EXPECT_NEAR(bvh.cost_ratio(), 1.0, 1e-5);
    ASSERT_TRUE(bvh.update(test::twisted(shape.positions, 8.0f)));
    EXPECT_GT(bvh.cost_ratio(), 1.3);
  }
}

}  // namespace
}  // namespace sinew
