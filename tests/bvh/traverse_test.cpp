// Rays in groups and alone, on every instruction set; bad rays; counting what rays cost.
#include "sinew/bvh/trace/traverse.h"

#include <gtest/gtest.h>

// clang-format off
#include "sinew/base/simd.h"
#include <hwy/targets.h>
// clang-format on

#include <algorithm>
#include <cstring>

#include "shapes.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

World world_of(const test::Shape& shape, int copies) {
  World world;
  const BodyId body = *world.add_body({shape.triangles, RigidMotion{shape.positions}, Pose(), {}});
  for (int i = 0; i < copies; ++i) {
    Pose pose;
    pose.placement[3] = vec3(0.3f * static_cast<float>(i), 0.0f, 0.0f);
    EXPECT_TRUE(world.set_pose(*world.add_object(body), pose));
  }
  world.commit();
  return world;
}

TEST(CountClosestHits, HitsAreThoseOfClosestHits) {
  const test::Shape shape = test::random_triangles(3000, 5);
  for (const int copies : {1, 7}) {
    const World world = world_of(shape, copies);
    Random random(17);
    std::vector<Ray> rays(4000);
    for (Ray& ray : rays) ray = {random.uniform3(-1.0f, 2.0f), 0.0f, random.direction()};
    std::vector<Hit> hits(rays.size()), counted(rays.size());
    std::vector<TraversalCounts> counts(rays.size());
    world.closest_hits(rays, hits);
    world.count_closest_hits(rays, counted, counts);
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i].t, counted[i].t) << "ray " << i;
      ASSERT_EQ(hits[i].object, counted[i].object) << "ray " << i;
      ASSERT_EQ(hits[i].primitive, counted[i].primitive) << "ray " << i;
      // Every way to a hit leads through a node and a packet at least.
      EXPECT_GE(counts[i].nodes, 1u) << "ray " << i;
      EXPECT_GE(counts[i].packets, hits[i] ? 1u : 0u) << "ray " << i;
    }
  }
}

TEST(CountClosestHits, CountsByHand) {
  const auto count = [](const World& world, const Ray& ray) {
    Hit hit;
    TraversalCounts counts{77, 77};
    world.count_closest_hits({&ray, 1}, {&hit, 1}, {&counts, 1});
    return std::pair(counts.nodes, counts.packets);
  };
  using Counts = std::pair<uint32_t, uint32_t>;
  const Ray down{vec3(0.2f, 0.2f, 5.0f)}, aside{vec3(50.0f, 50.0f, 5.0f)};
  const test::Shape triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  // A single leaf without a node above it.
  EXPECT_EQ(count(world_of(triangle, 1), down), Counts(0, 1));
  EXPECT_EQ(count(world_of(triangle, 1), aside), Counts(0, 1));
  // Two instances below one node of the top tree; a ray that meets no box stops there.
  EXPECT_EQ(count(world_of(triangle, 2), Ray{vec3(0.1f, 0.2f, 5.0f)}), Counts(1, 1));
  EXPECT_EQ(count(world_of(triangle, 2), Ray{vec3(0.4f, 0.2f, 5.0f)}), Counts(1, 2));
  EXPECT_EQ(count(world_of(triangle, 2), aside), Counts(1, 0));
  EXPECT_EQ(count(World(), down), Counts(0, 0));
}

// Rays of all sorts, neighbours alike or not.
std::vector<Ray> mixed_rays(uint32_t seed, size_t count) {
  Random random(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const vec3 eye = random.uniform3(-2.0f, 3.0f);
    const vec3 target = random.uniform3(0.0f, 1.0f);
    const uint32_t kind = random.next() % 4;
    for (int i = 0; i < 50; ++i) {
      Ray ray{eye, 0.0f, target + random.uniform3(-0.1f, 0.1f) - eye};
      if (kind == 1) ray.direction = random.direction();  // from a common origin
      if (kind == 2) ray = {random.uniform3(0.0f, 1.0f), 0.0f, random.direction(), 0.3f};
      if (kind == 3) {  // along an axis, the other components being zeros of either sign
        const int axis = static_cast<int>(random.next() % 3);
        const bool negative = random.next() % 2 == 0;
        ray.origin = random.uniform3(0.0f, 1.0f);
        ray.direction = vec3(negative ? -0.0f : 0.0f);
        ray.direction[axis] = random.next() % 2 == 0 ? 2.0f : -2.0f;
        ray.origin[axis] -= ray.direction[axis];
      }
      rays.push_back(ray);
    }
  }
  return rays;
}

void expect_same_hits(std::span<const Hit> a, std::span<const Hit> b, const std::string& where) {
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(0, std::memcmp(&a[i], &b[i], sizeof(Hit)))
        << where << ", ray " << i << ": t " << a[i].t << " and " << b[i].t << ", primitive "
        << a[i].primitive << " and " << b[i].primitive;
  }
}

// On each instruction set that the machine has, rays in groups and rays alone find the same bits.
void expect_groups_find_the_same(const World& world, std::span<const Ray> rays,
                                 QueryOptions options, const std::string& where) {
  std::vector<Hit> first;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::vector<Hit> grouped(rays.size()), alone(rays.size());
    std::vector<uint8_t> any_grouped(rays.size()), any_alone(rays.size());
    options.grouping = Grouping::automatic;
    world.closest_hits(rays, grouped, options);
    world.any_hits(rays, any_grouped, options);
    options.grouping = Grouping::none;
    world.closest_hits(rays, alone, options);
    world.any_hits(rays, any_alone, options);
    const std::string here = where + " on " + kernel_target();
    expect_same_hits(alone, grouped, here);
    EXPECT_EQ(any_alone, any_grouped) << here;
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(any_alone[i] != 0, static_cast<bool>(alone[i])) << here << ", ray " << i;
    }
    if (first.empty()) first = alone;
    expect_same_hits(first, alone, here);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  const auto hits = std::count_if(first.begin(), first.end(), [](const Hit& h) { return bool(h); });
  EXPECT_GT(hits, static_cast<ptrdiff_t>(rays.size() / 20)) << where;
}

TEST(Grouping, FindsTheBitsOfRaysAlone) {
  for (const uint32_t seed : {3u, 4u}) {
    const std::vector<Ray> rays = mixed_rays(seed, 2500);
    const std::string where = "seed " + std::to_string(seed);
    expect_groups_find_the_same(world_of(test::random_triangles(3000, seed), 1), rays, {}, where);
    expect_groups_find_the_same(world_of(test::sphere(4), 5), rays, {}, where + ", copies");
  }
}

// Of another class than `like`, or untraceable, but for the last.
std::vector<Ray> odd_rays(const Ray& like) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Ray> odd(10, like);
  odd[0].direction.x = 0.1f;
  odd[1].direction = vec3(-3.0f, -0.2f, -1.0f);
  odd[2].direction.y = 0.0f;
  odd[3].direction.z = nan;
  odd[4].origin.y = -INFINITY;
  odd[5].t_min = nan;
  odd[6].t_max = -1.0f;
  odd[7].direction = vec3(-1e-40f, -0.0f, -1e-40f);
  odd[8].t_max = nan;
  odd[9].direction.x = -0.0f;
  return odd;
}

TEST(Grouping, NoticesTheOddRayOfARun) {
  constexpr size_t kRun = 64;
  const uint32_t seed = 31;
  Random random(seed);
  const Ray like{vec3(0.5f, 0.6f, 9.0f), 0.0f, vec3(-0.1f, -0.2f, -9.0f)};
  std::vector<Ray> rays;
  for (const Ray& odd : odd_rays(like)) {
    for (size_t i = 0; i < kRun * kRun; ++i) {
      rays.push_back(i % kRun == i / kRun ? odd : like);
      rays.back().origin += random.uniform3(0.0f, 1.0f);
    }
  }
  const World world = world_of(test::random_triangles(3000, seed), 1);
  expect_groups_find_the_same(world, rays, {}, "seed " + std::to_string(seed));
}

TEST(Grouping, ObeysMasksFacingAndFilters) {
  const test::Shape shape = test::random_triangles(500, 9, 0.2f);
  World world;
  const BodyId body = *world.add_body({shape.triangles, RigidMotion{shape.positions}, Pose(), {}});
  Random random(11);
  for (uint32_t i = 0; i < 12; ++i) {
    ObjectDesc desc;
    desc.mask = i % 3 == 0 ? 1u : 3u;
    desc.single_sided = i % 2 == 0;
    desc.filtered = i % 4 == 1;
    Pose pose;  // turned, stretched, some of them mirrored
    for (int k = 0; k < 3; ++k) pose.placement[k] = random.direction();
    pose.placement[3] = random.uniform3(-1.0f, 1.0f);
    ASSERT_TRUE(world.set_pose(*world.add_object(body, desc), pose));
  }
  world.commit();
  const auto accept = [](const void*, uint32_t ray, const Hit& hit) {
    return (hit.primitive + ray) % 3 != 0;
  };
  const std::vector<Ray> rays = mixed_rays(12, 2000);
  for (const Facing facing : {Facing::any, Facing::front, Facing::back}) {
    for (const uint32_t mask : {1u, 2u}) {
      expect_groups_find_the_same(world, rays, {.mask = mask, .facing = facing, .filter = {accept}},
                                  "mask " + std::to_string(mask));
    }
  }
}

TEST(Precision, FastFindsTheSameButForEdges) {
  for (const bool single_sided : {false, true}) {
    const test::Shape shape = test::random_triangles(3000, 21);
    World world;
    const BodyId body =
        *world.add_body({shape.triangles, RigidMotion{shape.positions}, Pose(), {}});
    ObjectDesc desc;
    desc.single_sided = single_sided;
    ASSERT_TRUE(world.set_pose(*world.add_object(body, desc), Pose()));
    world.commit();
    const std::vector<Ray> rays = mixed_rays(22, 4000);
    for (const Facing facing : {Facing::front, Facing::back}) {
      QueryOptions options{.facing = facing, .grouping = Grouping::none};
      std::vector<Hit> exact(rays.size()), fast(rays.size());
      std::vector<uint8_t> any(rays.size());
      world.closest_hits(rays, exact, options);
      options.precision = Precision::fast;
      world.closest_hits(rays, fast, options);
      world.any_hits(rays, any, options);
      size_t hits = 0, differ = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        hits += static_cast<bool>(exact[i]);
        EXPECT_EQ(any[i] != 0, static_cast<bool>(fast[i])) << "ray " << i;
        if (exact[i].object != fast[i].object || exact[i].primitive != fast[i].primitive) {
          ++differ;
        } else if (exact[i]) {
          EXPECT_NEAR(exact[i].t, fast[i].t, 1e-3f) << "ray " << i;
          EXPECT_NEAR(exact[i].u, fast[i].u, 1e-2f) << "ray " << i;
          EXPECT_NEAR(exact[i].v, fast[i].v, 1e-2f) << "ray " << i;
        }
      }
      EXPECT_GT(hits, rays.size() / 10);
      EXPECT_LE(differ, rays.size() / 500);
    }
  }
}

TEST(BadRays, MeetNothing) {
  const World world = world_of(test::sphere(3), 2);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = INFINITY;
  const Ray good{vec3(0.1f, 0.2f, 5.0f)};
  std::vector<Ray> bad(13, good);
  bad[0].direction = vec3(0.0f);
  bad[1].direction = vec3(0.0f, -0.0f, 1e-40f);
  bad[2].direction.x = nan;
  bad[3].direction = vec3(nan);
  bad[4].direction.z = -infinity;
  bad[5].origin.y = nan;
  bad[6].origin = vec3(nan);
  bad[7].origin.x = infinity;
  bad[8].t_min = nan;
  bad[9].t_max = nan;
  bad[10].t_min = 7.0f, bad[10].t_max = 2.0f;
  bad[11].t_min = infinity;
  bad[12].t_max = -infinity;
  // Among good rays, which they must not disturb, and often enough to make groups.
  std::vector<Ray> rays;
  for (int i = 0; i < 20; ++i) {
    for (const Ray& ray : bad) rays.insert(rays.end(), {ray, good});
  }
  for (const Grouping grouping : {Grouping::automatic, Grouping::none}) {
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> any(rays.size());
    world.closest_hits(rays, hits, {.grouping = grouping});
    world.any_hits(rays, any, {.grouping = grouping});
    for (size_t i = 0; i < rays.size(); ++i) {
      const bool is_good = i % 2 == 1;
      EXPECT_EQ(static_cast<bool>(hits[i]), is_good) << "bad ray " << i / 2 % bad.size();
      EXPECT_EQ(any[i] != 0, is_good) << "bad ray " << i / 2 % bad.size();
      EXPECT_EQ(hits[i].t == infinity, !is_good) << "bad ray " << i / 2 % bad.size();
    }
  }
}

}  // namespace
}  // namespace sinew
