// L's hierarchy: its hits against brute force, its lazily made boxes against exact ones, and its
// model against numbers worked out by hand.
#include "sinew/bvh/larsson/larsson.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "oracle.h"
#include "shapes.h"
#include "sinew/bvh/larsson/larsson_bodies.h"

namespace sinew::larsson {
namespace {

void expect_true_hits(Hierarchy& hierarchy, std::span<const vec3> positions,
                      std::span<const uvec3> triangles, size_t rays, uint32_t seed) {
  test::Agreement agreement;
  for (const Ray& ray : test::test_rays(positions, triangles, rays, seed)) {
    const Probe probe(ray);
    Hit hit;
    hierarchy.closest_hit(probe, 0, hit);
    EXPECT_EQ(hierarchy.any_hit(probe), static_cast<bool>(hit)) << "seed " << seed;
    test::judge(ray, hit, test::brute_force(ray, positions, triangles), agreement);
  }
  EXPECT_EQ(agreement.wrong, 0u) << agreement.first_wrong << " (seed " << seed << ")";
  EXPECT_LT(agreement.doubtful_fraction(), 0.05) << "seed " << seed;
  EXPECT_GT(agreement.hits, rays / 8);
}

const std::vector<Config>& all_configs() {
  static const std::vector<Config> configs = {
      {},
      {.first_visit = FirstVisit::levels, .visit_levels = 1},
      {.first_visit = FirstVisit::levels, .visit_levels = 3},
      {.first_visit = FirstVisit::subtree},
      {.depth = 0},
      {.first_visit = FirstVisit::levels, .visit_levels = 2, .depth = 1},
      {.depth = 100},  // of a tree that is not so high: all boxes
  };
  return configs;
}

size_t outdated(const Hierarchy& hierarchy) {
  return static_cast<size_t>(std::ranges::count_if(hierarchy.nodes(), [&](const Node& node) {
    return node.last_updated != hierarchy.nodes()[0].last_updated;
  }));
}

TEST(Larsson, FindsWhatBruteForceFindsInEveryFrameAndMode) {
  const test::Shape shape = test::sphere(4);
  for (const Config& config : all_configs()) {
    Hierarchy hierarchy(shape.positions, shape.triangles, config);
    ASSERT_EQ(hierarchy.validate(), "");
    uint32_t seed = 1;
    for (const float amount : {0.0f, 0.4f, 1.5f, -3.0f}) {
      const std::vector<vec3> moved = test::twisted(shape.positions, amount);
      hierarchy.update_hybrid(moved);
      ASSERT_EQ(hierarchy.validate(), "");
      expect_true_hits(hierarchy, moved, shape.triangles, 60, ++seed);
      ASSERT_EQ(hierarchy.validate(), "") << "boxes made by visits";
    }
    const std::vector<vec3> last = test::twisted(shape.positions, 2.0f);
    hierarchy.update_bottom_up(last);
    EXPECT_EQ(outdated(hierarchy), 0u);
    expect_true_hits(hierarchy, last, shape.triangles, 60, ++seed);
    ASSERT_EQ(hierarchy.validate(), "");
  }
}

TEST(Larsson, FindsWhatBruteForceFindsAmongScatteredTriangles) {
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    for (const size_t count : {1, 2, 9, 600}) {
      const auto shape = test::random_triangles(count, seed, count < 10 ? 1.0f : 0.1f);
      Hierarchy hierarchy(shape.positions, shape.triangles);
      expect_true_hits(hierarchy, shape.positions, shape.triangles, 200, seed);
    }
  }
}

// L, figure 1: a box has the same optimal fit whether it comes from points or from child boxes.
TEST(Larsson, VisitedBoxesAreThoseOfABottomUpUpdate) {
  const test::Shape shape = test::sphere(4);
  const std::vector<vec3> moved = test::twisted(shape.positions, 1.0f);
  for (const Config& config : all_configs()) {
    Hierarchy whole(shape.positions, shape.triangles, config);
    Hierarchy lazy(shape.positions, shape.triangles, config);
    whole.update_bottom_up(moved);
    lazy.update_hybrid(moved);
    EXPECT_EQ(outdated(lazy), lazy.nodes().size() - lazy.hybrid_work().boxes);
    for (const Ray& ray : test::test_rays(moved, shape.triangles, 100, 3)) {
      lazy.any_hit(Probe(ray));
    }
    size_t current = 0;
    for (size_t i = 0; i < lazy.nodes().size(); ++i) {
      const Node &a = lazy.nodes()[i], &b = whole.nodes()[i];
      if (a.last_updated != lazy.nodes()[0].last_updated) continue;
      ++current;
      EXPECT_EQ(a.box.min, b.box.min);
      EXPECT_EQ(a.box.max, b.box.max);
    }
    EXPECT_EQ(current, lazy.hybrid_work().boxes + lazy.visit_work().boxes);
  }
}

TEST(Larsson, OneRayMakesOnlyWhatItReaches) {
  const test::Shape shape = test::sphere(5);
  const Probe missing(Ray{.origin = vec3(0, 0, 9), .direction = vec3(0, 1, 0)});
  const Probe hitting(Ray{.origin = vec3(0.1f, 0.2f, 9), .direction = vec3(0, 0, -1)});
  std::vector<uint64_t> boxes;
  for (const FirstVisit policy : {FirstVisit::node, FirstVisit::levels, FirstVisit::subtree}) {
    Hierarchy hierarchy(shape.positions, shape.triangles, {.first_visit = policy});
    hierarchy.update_hybrid(shape.positions);
    EXPECT_FALSE(hierarchy.any_hit(missing));
    EXPECT_EQ(hierarchy.visit_work().boxes, 0u);
    EXPECT_TRUE(hierarchy.any_hit(hitting));
    boxes.push_back(hierarchy.visit_work().boxes);
    EXPECT_EQ(hierarchy.visit_work().boxes + hierarchy.hybrid_work().boxes + outdated(hierarchy),
              hierarchy.nodes().size());
    EXPECT_TRUE(hierarchy.any_hit(hitting));
    EXPECT_EQ(hierarchy.visit_work().boxes, boxes.back()) << "nothing is made twice";
  }
  EXPECT_LT(boxes[0], boxes[1]);
  EXPECT_LT(boxes[1], boxes[2]);
  EXPECT_GT(boxes[0], 0u);
}

// The work of both updates on a mesh small enough to count: two squares far apart, two triangles
// each, four vertices each.
TEST(Larsson, UpdateWorkByHand) {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
  for (const float x : {0.0f, 10.0f}) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), {{x, x, 0}, {x + 1, x, 0}, {x + 1, x + 1, 0}, {x, x + 1, 0}});
    triangles.push_back({first, first + 1, first + 2});
    triangles.push_back({first, first + 2, first + 3});
  }
  const Hierarchy hierarchy(positions, triangles);
  EXPECT_EQ(hierarchy.nodes().size(), 7u);  // the whole, two squares, four triangles
  EXPECT_EQ(hierarchy.height(), 2u);
  EXPECT_EQ(hierarchy.depth(), 1u);
  EXPECT_EQ(hierarchy.bottom_up_work().vertices, 12u);
  EXPECT_EQ(hierarchy.bottom_up_work().boxes, 7u);
  EXPECT_EQ(hierarchy.hybrid_work().vertices, 8u);
  EXPECT_EQ(hierarchy.hybrid_work().boxes, 3u);
}

TEST(Larsson, ModelByHand) {
  // n = 16, k = 4: 16 + 4 + 1 nodes, of which 4 + 1 are updated.
  EXPECT_DOUBLE_EQ(total_nodes(16, 4), 21.0);
  EXPECT_DOUBLE_EQ(upper_nodes(16, 4), 5.0);
  EXPECT_DOUBLE_EQ(updated_share(16, 4), 5.0 / 21.0);
  EXPECT_DOUBLE_EQ(predicted_speedup(16, 4), (48.0 + 21.0) / (8.0 + 5.0));
  EXPECT_DOUBLE_EQ(speedup_limit(2), 10.0);
  EXPECT_DOUBLE_EQ(speedup_limit(4), 8.0 + 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(speedup_limit(8), 8.0 + 2.0 / 7.0);
}

// L's equations 6 and 8 to 10, with the heights from which they hold.
TEST(Larsson, PredictionsLieInTheIntervalsOfThePaper) {
  const struct {
    double k;
    int least_height;
  } cases[] = {{2, 8}, {4, 5}, {8, 4}};
  for (const auto& [k, least_height] : cases) {
    for (int h = least_height; h <= 24; ++h) {
      const double n = std::pow(k, h), s = predicted_speedup(n, k);
      EXPECT_GT(s, 8.0) << k << " " << h;
      EXPECT_LT(s, speedup_limit(k)) << k << " " << h;
      EXPECT_LT(updated_share(n, k), 1.0 / std::sqrt(n) * (1.0 + 1e-12)) << k << " " << h;
    }
    EXPECT_LT(predicted_speedup(std::pow(k, least_height - 2), k), 8.0) << k;
  }
}

TEST(Larsson, DegenerateInputs) {
  Hierarchy nothing({}, {});
  nothing.update_hybrid({});
  EXPECT_EQ(nothing.validate(), "");
  EXPECT_FALSE(nothing.any_hit(Probe(Ray())));
  EXPECT_TRUE(nothing.box().empty());

  // A hundred triangles on one spot: no plane parts them. The least one is hit.
  const std::vector<vec3> corner = {vec3(0), vec3(4, 0, 0), vec3(0, 4, 0)};
  const std::vector<uvec3> pile(100, uvec3(0, 1, 2));
  Hierarchy piled(corner, pile);
  EXPECT_EQ(piled.validate(), "");
  EXPECT_LE(piled.height(), 4u);
  piled.update_hybrid(corner);
  Hit hit;
  piled.closest_hit(Probe(Ray{.origin = vec3(1, 1, 1)}), 5, hit);
  EXPECT_EQ(hit.primitive, 0u);
  EXPECT_EQ(hit.object, 5u);

  // Huge triangles whose centres differ little: the box's middle does not part them, medians do.
  test::Shape huge = test::random_triangles(200, 7, 1e-3f);
  for (size_t i = 0; i < huge.triangles.size(); i += 2) {
    const uvec3 t = huge.triangles[i];
    huge.positions[t.x] += vec3(1e6f);
    huge.positions[t.y] -= vec3(1e6f);
  }
  EXPECT_EQ(Hierarchy(huge.positions, huge.triangles).validate(), "");

  // Points and vertices that are not finite are in nobody's way.
  test::Shape broken = test::sphere(3);
  broken.positions[5] = vec3(NAN);
  broken.triangles[7] = uvec3(broken.triangles[7].x);
  Hierarchy with_holes(broken.positions, broken.triangles);
  EXPECT_EQ(with_holes.validate(), "");
  EXPECT_TRUE(with_holes.any_hit(Probe(Ray{.origin = vec3(0.1f, 0.2f, 3)})));
}

TEST(LarssonBodies, FindTheNearestOfManyMovingBodies) {
  const test::Shape ball = test::sphere(2);
  constexpr size_t kBodies = 6;
  std::vector<std::vector<vec3>> moved(kBodies, ball.positions);
  Bodies bodies;
  for (size_t b = 0; b < kBodies; ++b) {
    EXPECT_EQ(bodies.add(KeyHierarchies(Hierarchy(ball.positions, ball.triangles))), b);
  }
  Random random(21);
  for (int frame = 0; frame < 4; ++frame) {
    std::vector<vec3> all;
    std::vector<uvec3> all_triangles;
    for (uint32_t b = 0; b < kBodies; ++b) {
      const vec3 center = random.uniform3(-4.0f, 4.0f);
      moved[b] = test::twisted(ball.positions, 0.3f * float(frame));
      for (vec3& p : moved[b]) p += center;
      bodies.body(b).active().update_hybrid(moved[b]);
      for (const uvec3 t : ball.triangles) {
        all_triangles.push_back(t + static_cast<uint32_t>(all.size()));
      }
      all.insert(all.end(), moved[b].begin(), moved[b].end());
    }
    bodies.sort();
    test::Agreement agreement;
    for (const Ray& ray : test::test_rays(all, all_triangles, 150, 33)) {
      Hit hit = bodies.closest_hit(ray);
      EXPECT_EQ(bodies.any_hit(ray), static_cast<bool>(hit));
      if (hit) hit.primitive += hit.object * static_cast<uint32_t>(ball.triangles.size());
      test::judge(ray, hit, test::brute_force(ray, all, all_triangles), agreement);
    }
    EXPECT_EQ(agreement.wrong, 0u) << agreement.first_wrong;
    EXPECT_GT(agreement.hits, 20u);
  }
}

TEST(LarssonBodies, TheNearestKeyIsInUse) {
  const std::vector<float> times = {0, 1, 2, 3, 4};
  EXPECT_EQ(KeyHierarchies::nearest(times, -1.0f), 0u);
  EXPECT_EQ(KeyHierarchies::nearest(times, 0.4f), 0u);
  EXPECT_EQ(KeyHierarchies::nearest(times, 0.5f), 1u);
  EXPECT_EQ(KeyHierarchies::nearest(times, 3.0f), 3u);
  EXPECT_EQ(KeyHierarchies::nearest(times, 9.0f), 4u);

  const test::Shape shape = test::sphere(2);
  const std::vector<vec3> other = test::twisted(shape.positions, 2.0f);
  std::vector<Hierarchy> keys;
  keys.emplace_back(shape.positions, shape.triangles);
  keys.emplace_back(other, shape.triangles);
  KeyHierarchies body({0.0f, 1.0f}, std::move(keys));
  for (const float time : {0.2f, 0.9f, 0.1f}) {
    const std::vector<vec3> now = test::twisted(shape.positions, 2.0f * time);
    body.select(time);
    body.active().update_hybrid(now);
    expect_true_hits(body.active(), now, shape.triangles, 60, 9);
  }
}

}  // namespace
}  // namespace sinew::larsson
