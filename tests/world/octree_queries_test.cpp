// What is known of the voxels that rays have met, and what other queries make of voxel objects.
#include <gtest/gtest.h>

#include "sinew/world/voxel_bodies.h"
#include "world/mixed_world.h"

namespace sinew {
namespace {

using test::BruteOctree;
using test::Mixed;

// The rasteriser and rays use each other's blocks.
TEST(WorldOctrees, WhoDrawsAndWhoTracesShareBlocks) {
  Mixed m(11), twin(11);
  const std::vector<Ray> rays = test::rays_about(m.world.box(), 600, 11);
  std::vector<Hit> hits(rays.size()), expected(rays.size());
  twin.world.closest_hits(rays, expected);
  VoxelBodies bodies;
  bodies.take(m.world);
  ASSERT_EQ(bodies.instances().size(), 5u);
  EXPECT_EQ(bodies.instances()[0].posed, bodies.instances()[1].posed);
  EXPECT_EQ(bodies.instances()[2].posed, bodies.instances()[3].posed);
  EXPECT_NE(bodies.instances()[2].posed, bodies.instances()[4].posed);
  bodies.list_boxes();
  uint32_t units = 0;
  for (size_t i = 0; i < 5; ++i) {
    const VoxelInstance& instance = bodies.instances()[i];
    EXPECT_EQ(bodies.objects()[i], i + 2);
    EXPECT_EQ(instance.first_unit, units);
    units += unit_count(instance.posed->svo());
    EXPECT_EQ(instance.placement, m.places[i + 2]);
    if (i % 2 == 0) instance.posed->make_block(0);
  }
  EXPECT_FALSE(bodies.box().empty());
  m.world.closest_hits(rays, hits);
  EXPECT_TRUE(test::same_hits(hits, expected));
  // What rays made is there for who draws.
  size_t made = 0;
  for (const Hit& hit : hits) {
    if (!hit || hit.object < 2) continue;
    const VoxelInstance instance = *m.world.voxel_instance(hit.object);
    made += instance.posed->is_made(block_of(instance.posed->svo(), hit.primitive >> 10));
  }
  EXPECT_GT(made, 50u);
  EXPECT_EQ(made, static_cast<size_t>(std::ranges::count_if(
                      hits, [](const Hit& h) { return h && h.object >= 2; })));
}

TEST(WorldOctrees, AHitIsLookedUpAsAKeyOfThePictureIs) {
  const Mixed m(12);
  const std::vector<Ray> rays = test::rays_about(m.world.box(), 400, 12);
  std::vector<Hit> hits(rays.size());
  m.world.closest_hits(rays, hits);
  VoxelBodies bodies;
  bodies.take(m.world);
  size_t compared = 0;
  for (const Hit& hit : hits) {
    if (!hit || !m.world.has_voxels(hit.object)) continue;
    const VoxelSample a = m.world.sample_voxel(hit);
    const auto at = std::ranges::find(bodies.objects(), hit.object) - bodies.objects().begin();
    const uint32_t unit =
        bodies.instances()[static_cast<size_t>(at)].first_unit + (hit.primitive >> 10);
    const VoxelSample b =
        sample_voxel(bodies.instances(), make_key(1.0f, unit, hit.primitive & 1023));
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.code, b.code);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.color, b.color);
    EXPECT_EQ(a.material, b.material);
    EXPECT_EQ(a.size, b.size);
    ++compared;
  }
  EXPECT_GT(compared, 50u);
}

TEST(WorldOctrees, TriangleQueriesPassVoxelsBy) {
  const Mixed m(13);
  Random random(13);
  for (int i = 0; i < 40; ++i) {
    const vec3 from =
        m.world.box().center() + random.uniform3(-0.5f, 0.5f) * m.world.box().extent();
    const auto with = m.world.nearest_point(from), without = m.triangles_alone.nearest_point(from);
    ASSERT_TRUE(with && without);
    EXPECT_EQ(with->distance, without->distance);
    EXPECT_EQ(with->primitive, without->primitive);
    std::vector<TriangleId> a, b;
    const Box box{from - vec3(1.0f), from + vec3(1.0f)};
    m.world.triangles_in_box(box, a);
    m.triangles_alone.triangles_in_box(box, b);
    EXPECT_EQ(a, b);
  }
}

TEST(WorldOctrees, BoxesHoldTheVoxels) {
  for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
    const Mixed m(14, top);
    const BruteOctree last(m.moving, m.poses[2].pose());
    EXPECT_LT(m.world.boxes(30).size(), 200u) << "nothing is made yet";
    std::vector<Ray> rays = test::rays_about(m.world.box(), 4000, 14);
    std::vector<Hit> hits(rays.size());
    m.world.closest_hits(rays, hits);
    EXPECT_GT(m.world.boxes(30).size(), 200u);
    for (const uint32_t level : {0u, 1u, 2u, 3u, 5u, 30u}) {
      const std::vector<TreeBox> boxes = m.world.boxes(level);
      const auto holds = [&](test::dvec3 p) {
        return std::ranges::any_of(boxes, [&](const TreeBox& b) {
          return (b.object == kNoObject || b.object == m.movings[2]) && b.box.contains(vec3(p));
        });
      };
      for (size_t i = 0; i < last.boxes.size(); i += 7) {
        const test::dvec3 middle = 0.5 * (last.boxes[i].min + last.boxes[i].max);
        EXPECT_TRUE(holds(middle)) << "level " << level;
      }
    }
  }
}

TEST(WorldOctrees, WideRaysMeetCoarserLevels) {
  const Mixed m(15);
  const std::vector<Ray> rays = test::rays_about(m.world.box(), 500, 15);
  uint32_t levels[4] = {};
  for (const float width : {0.0f, 0.2f, 0.4f, 100.0f}) {
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> any(rays.size());
    QueryOptions options;
    options.footprint = {width, 0.0f};
    m.world.closest_hits(rays, hits, options);
    m.world.any_hits(rays, any, options);
    for (size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(any[i] != 0, bool{hits[i]});
      if (!hits[i] || hits[i].object < 2) continue;
      const uint32_t level = level_of(hits[i].primitive & 1023);
      ++levels[level];
      EXPECT_TRUE(width > 0.0f || level == 0) << level;
      EXPECT_TRUE(width < 100.0f || level == 3) << level;
    }
  }
  for (const uint32_t count : levels) EXPECT_GT(count, 20u);
}

}  // namespace
}  // namespace sinew
