// Octrees whose details come and go, in a World.
#include <gtest/gtest.h>

#include "svo/paged_svo.h"
#include "world/voxel_worlds.h"

namespace sinew {
namespace {

TEST(WorldPaging, RaysMeetWhatIsThereAndTheSameOnceAllIs) {
  const Svo whole = test::moving_octree(140, 4000, 7);
  const test::SvoOnDisk file(whole);
  Svo paged = *file.open(uint64_t{1} << 30);
  const test::OwnPose pose = test::moving_pose(3);
  World all, some;
  for (auto [world, svo] :
       {std::pair{&all, &whole}, std::pair{&some, const_cast<const Svo*>(&paged)}}) {
    ASSERT_TRUE(world->set_pose(*world->add_object(*world->add_octree({svo})), pose.pose()));
    world->commit();
  }
  const std::vector<Ray> rays = test::rays_about(all.box(), 2000, 9);
  std::vector<Hit> expected(rays.size()), cells(rays.size()), hits(rays.size());
  all.closest_hits(rays, expected);
  QueryOptions wide;
  wide.footprint = {1e3f, 0.0f};
  all.closest_hits(rays, cells, wide);
  some.closest_hits(rays, hits);
  EXPECT_TRUE(test::same_hits(hits, cells)) << "nothing is there yet but cells";

  std::vector<uint32_t> half;
  for (uint32_t b = 0; b < paged.block_count(); b += 2) half.push_back(b);
  test::ask(paged, half);
  some.refresh_octrees();
  some.closest_hits(rays, hits);
  size_t levels[4] = {};
  for (const Hit& hit : hits) {
    if (!hit) continue;
    const uint32_t level = level_of(hit.primitive & 1023);
    const uint32_t block = block_of(paged, hit.primitive >> 10);
    EXPECT_EQ(level, paged.paging->resident()[block] != 0 ? 0u : 3u);
    some.sample_voxel(hit);
    ++levels[level];
  }
  EXPECT_GT(levels[0], 100u);
  EXPECT_GT(levels[3], 100u);

  test::ask(paged, test::all_blocks(paged));
  some.commit();
  some.closest_hits(rays, hits);
  EXPECT_TRUE(test::same_hits(hits, expected));

  // A frame that is shown again after details have come.
  Svo later = *file.open(uint64_t{1} << 30);
  World staged;
  const ObjectId object = *staged.add_object(*staged.add_octree({&later}));
  ASSERT_TRUE(staged.set_pose(object, pose.pose()));
  staged.stage();
  test::ask(later, test::all_blocks(later));
  staged.flip();
  staged.closest_hits(rays, hits);
  EXPECT_TRUE(test::same_hits(hits, expected));
}

}  // namespace
}  // namespace sinew
