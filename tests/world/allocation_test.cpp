// Frames that are like the ones before need no new memory.
#include "allocations.h"

#ifndef SINEW_SANITIZED
#include <gtest/gtest.h>

#include "sinew/math/random.h"
#include "sinew/scene/study.h"
#include "sinew/world/world.h"

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

}  // namespace
}  // namespace sinew
#endif
