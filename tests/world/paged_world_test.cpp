// Octrees whose details come and go, in a World.
#include <gtest/gtest.h>

#include <bit>

#include "sinew/base/parallel.h"
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

  std::vector<uint32_t> half;  // of what the rays asked for
  for (uint32_t b = 0; b < paged.block_count(); b += 2) half.push_back(b);
  for (uint32_t b = 1; b < paged.block_count(); b += 2) paged.paging->wishes()[b].store(0);
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

// A paged octree in a world, in a pose, and rays about it.
struct PagedWorld {
  Svo whole = test::moving_octree(140, 4000, 7);
  test::SvoOnDisk file{whole};
  Svo paged = *file.open(uint64_t{1} << 30);
  test::OwnPose pose = test::moving_pose(3);
  World all, some;

  PagedWorld() {
    for (auto [world, svo] : {std::pair{&all, &whole}, std::pair{&some, &paged}}) {
      EXPECT_TRUE(world->set_pose(*world->add_object(*world->add_octree({svo})), pose.pose()));
      world->commit();
    }
  }
  // What was asked for comes.
  bool settle() {
    const bool changed = paged.paging->settle();
    some.refresh_octrees();
    return changed;
  }
  float wish(uint32_t block) const {
    return std::bit_cast<float>(paged.paging->wishes()[block].load());
  }
};

TEST(WorldPaging, PicksAreFineOnceTheyHaveAsked) {
  PagedWorld w;
  uint32_t picked = 0;
  for (const Ray& ray : test::rays_about(w.all.box(), 300, 9)) {
    const auto fine = w.all.pick(ray);
    if (!fine) continue;
    ASSERT_TRUE(w.some.pick(ray).has_value());
    for (int i = 0; i < 8 && w.settle(); ++i) w.some.pick(ray);
    const auto pick = w.some.pick(ray);
    ASSERT_TRUE(pick && pick->voxel);
    EXPECT_EQ(pick->hit.primitive, fine->hit.primitive);
    EXPECT_EQ(pick->hit.t, fine->hit.t);
    EXPECT_EQ(level_of(pick->hit.primitive & 1023), 0u);
    ++picked;
  }
  EXPECT_GT(picked, 50u);
}

// Every kind of query asks, one by one and in groups.
TEST(WorldPaging, EveryQuerySettlesToTheWhole) {
  for (const RayFootprint footprint : {RayFootprint{}, RayFootprint{0.01f, 0.001f}}) {
    for (const size_t each : {size_t{1}, size_t{2000}}) {
      for (const bool any : {false, true}) {
        PagedWorld w;
        const std::vector<Ray> rays = test::rays_about(w.all.box(), 2000, 9);
        const auto query = [&](const World& world) {
          std::vector<Hit> hits(rays.size());
          std::vector<uint8_t> blocked(rays.size());
          QueryOptions options;
          options.footprint = footprint;
          for (size_t i = 0; i < rays.size(); i += each) {
            if (any) world.any_hits({&rays[i], each}, {&blocked[i], each}, options);
            if (!any) world.closest_hits({&rays[i], each}, {&hits[i], each}, options);
          }
          return std::pair{hits, blocked};
        };
        const auto [hits, blocked] = query(w.all);
        query(w.some);
        for (int i = 0; i < 16 && w.settle(); ++i) query(w.some);
        const auto [paged_hits, paged_blocked] = query(w.some);
        EXPECT_TRUE(test::same_hits(paged_hits, hits));
        EXPECT_EQ(paged_blocked, blocked);
        EXPECT_GT(w.paged.paging->stats().loaded, 0u);
      }
    }
  }
}

// Rays as wide as cells want none; narrow ones by how many widths a voxel has, whether it is there
// or not.
TEST(WorldPaging, RaysAskByTheirWidth) {
  PagedWorld w;
  const std::vector<Ray> rays = test::rays_about(w.all.box(), 500, 9);
  std::vector<Hit> hits(rays.size());
  QueryOptions options;
  const auto wishes_at = [&](float width) {
    options.footprint = {width, 0.0f};
    w.some.closest_hits(rays, hits, options);
    std::vector<float> wishes;
    for (uint32_t b = 0; b < w.paged.block_count(); ++b) {
      wishes.push_back(w.wish(b));
      w.paged.paging->wishes()[b].store(0);
    }
    return wishes;
  };
  for (const float wish : wishes_at(1e3f)) EXPECT_EQ(wish, 0.0f);
  test::ask(w.paged, {0, 1});
  w.some.refresh_octrees();
  const float width = 1e-4f;
  const std::vector<float> wide = wishes_at(2.0f * width), narrow = wishes_at(width);
  uint32_t asked = 0;
  for (uint32_t b = 0; b < wide.size(); ++b) {
    EXPECT_EQ(narrow[b], 2.0f * wide[b]);
    asked += narrow[b] > 0.0f;
  }
  EXPECT_GT(asked, 4u);
  EXPECT_GT(narrow[0] + narrow[1], 0.0f) << "what is there is seen, too";
}

TEST(WorldPagingThreads, RaysOfManyAskAtOnce) {
  PagedWorld w;
  const std::vector<Ray> rays = test::rays_about(w.all.box(), 4000, 9);
  std::vector<Hit> expected(rays.size()), hits(rays.size());
  w.all.closest_hits(rays, expected);
  const auto trace = [&] {
    parallel_for(rays.size(), 50, [&](size_t begin, size_t end) {
      w.some.closest_hits({&rays[begin], end - begin}, {&hits[begin], end - begin});
    });
  };
  for (int frame = 0; frame < 20; ++frame) {  // blocks come meanwhile
    trace();
    w.paged.paging->begin_frame();
    w.some.refresh_octrees();
  }
  trace();
  for (int i = 0; i < 16 && w.settle(); ++i) trace();
  EXPECT_TRUE(test::same_hits(hits, expected));
}

}  // namespace
}  // namespace sinew
