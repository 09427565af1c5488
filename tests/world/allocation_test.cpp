// Frames that are like the ones before need no new memory.
#include "allocations.h"

#ifndef SINEW_SANITIZED
#include <gtest/gtest.h>

#include "sinew/math/random.h"
#include "sinew/scene/study.h"
#include "sinew/world/world.h"
#include "world/voxel_worlds.h"

namespace sinew {
namespace {

struct Queries {
  std::vector<Ray> rays = std::vector<Ray>(500);
  std::vector<Hit> hits = std::vector<Hit>(500), all;
  std::vector<uint8_t> any = std::vector<uint8_t>(500);
  std::vector<TriangleId> inside;

  explicit Queries(const Box& box) {
    Random random(9);
    for (Ray& ray : rays) {
      ray.origin = box.center() + length(box.extent()) * random.direction();
      ray.direction = box.center() + random.uniform3(-0.3f, 0.3f) * box.extent() - ray.origin;
    }
  }
  void ask(const World& world) {
    world.closest_hits(rays, hits);
    world.any_hits(rays, any);
    world.all_hits(rays[0], all);
    world.nearest_point(rays[0].origin);
    world.triangles_in_box({rays[0].origin, world.box().center()}, inside);
  }
};

TEST(Allocation, FramesLikeTheOnesBeforeNeedNone) {
  for (const char* name : {"creature,triangles=8000", "bodies,subdivisions=3,motion=free"}) {
    const Scene scene = *make_study_scene(name);
    for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
      for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
        World world = *prepare(scene, {.update = mode, .top_tree = top});
        Queries queries(world.box());
        int counts[3];  // the first shows that they are counted
        for (int& count : counts) {
          count = 0;
          for (const double seconds : {0.1, 0.4, 0.7}) {
            test::start_counting();
            const bool posed = world.set_time(seconds).has_value();
            queries.ask(world);
            const bool staged = world.stage_time(seconds + 0.1).has_value();
            world.flip();
            queries.ask(world);
            count += test::stop_counting();
            ASSERT_TRUE(posed && staged);
          }
        }
        EXPECT_GT(counts[0], 0) << name << ", " << name_of(mode);
        EXPECT_EQ(counts[2], 0) << name << ", " << name_of(mode);
      }
    }
  }
}

// Objects that take turns in sharing poses.
TEST(Allocation, FramesOfVoxelObjectsNeedNone) {
  const Svo svo = test::moving_octree(70, 1500, 6);
  World world;
  const BodyId body = *world.add_octree({&svo});
  std::vector<test::OwnPose> poses;
  for (uint32_t i = 0; i < 12; ++i) poses.push_back(test::moving_pose(i));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(world.add_object(body));
  const auto pose = [&](uint32_t frame) {
    bool fit = true;
    for (uint32_t i = 0; i < 4; ++i) {
      test::OwnPose& own = poses[(frame + i * (frame % 3)) % poses.size()];
      own.placement[3].x = 3.0f * static_cast<float>(i);
      fit &= world.set_pose(i, own.pose()).has_value();
    }
    return fit;
  };
  ASSERT_TRUE(pose(0));
  world.commit();
  Queries queries(world.box());
  int counts[3];
  for (int& count : counts) {
    count = 0;
    for (uint32_t frame = 0; frame < 12; ++frame) {
      test::start_counting();
      bool fit = pose(frame);
      world.commit();
      queries.ask(world);
      fit &= pose(frame + 1);
      world.stage();
      world.flip();
      queries.ask(world);
      count += test::stop_counting();
      ASSERT_TRUE(fit);
    }
  }
  EXPECT_GT(counts[0], 0);
  EXPECT_EQ(counts[2], 0);
}

}  // namespace
}  // namespace sinew
#endif
