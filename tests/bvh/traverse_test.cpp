// Counting what rays cost.
#include "sinew/bvh/traverse.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace sinew
