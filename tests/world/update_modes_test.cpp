// Update modes: the same hits from all of them, first visits by many threads at once, two frames.
#include <gtest/gtest.h>

#include <cstring>
#include <latch>
#include <thread>

#include "oracle.h"
#include "shapes.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/study.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

constexpr UpdateMode kModes[] = {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy,
                                 UpdateMode::automatic};

// Rays from around the box through it.
std::vector<Ray> rays_through(const Box& box, size_t count, uint32_t seed) {
  Random random(seed);
  std::vector<Ray> rays(count);
  const float size = length(box.extent());
  for (Ray& ray : rays) {
    const vec3 from = random.direction();
    ray.origin = box.center() + size * from;
    const vec3 at = random.uniform3(-0.5f, 0.5f);
    ray.direction = box.center() + at * box.extent() - ray.origin;
  }
  return rays;
}

bool same_bits(std::span<const Hit> a, std::span<const Hit> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

class WorldUpdateModes : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Studies, WorldUpdateModes,
                         testing::Values("bodies,subdivisions=3",
                                         "bodies,subdivisions=3,motion=free",
                                         "twist,triangles=4000", "creature,triangles=8000",
                                         "soup,triangles=2000", "fracture"));

TEST_P(WorldUpdateModes, GiveTheSameHits) {
  const Result<Scene> scene = make_study_scene(GetParam());
  ASSERT_TRUE(scene);
  World world = *prepare(*scene);
  const double start = scene->clips[0].start, length = scene->clips[0].end - start;
  size_t hit_count = 0;
  for (int step = 1; step <= 3; ++step) {
    std::vector<Hit> expected;
    std::vector<Ray> rays;
    for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
      for (const UpdateMode mode : kModes) {
        world.set_update_mode(mode);
        world.set_top_tree(top);
        ASSERT_TRUE(world.set_time(start + length * 0.05));  // so that the next pose is another
        ASSERT_TRUE(world.set_time(start + length * step / 3.7));
        if (rays.empty()) rays = rays_through(world.box(), 3000, uint32_t(step));
        std::vector<Hit> hits(rays.size());
        std::vector<uint8_t> any(rays.size());
        world.any_hits(rays, any);
        world.closest_hits(rays, hits);
        if (expected.empty()) expected = hits;
        EXPECT_TRUE(same_bits(expected, hits)) << name_of(mode) << " step " << step;
        for (size_t i = 0; i < rays.size(); ++i) {
          ASSERT_EQ(any[i] != 0, static_cast<bool>(hits[i])) << name_of(mode) << " ray " << i;
        }
        EXPECT_EQ(world.validate(), "") << name_of(mode) << " step " << step;
        if (mode != UpdateMode::full) continue;
        hit_count += static_cast<size_t>(
            std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return bool(h); }));
      }
    }
  }
  EXPECT_GT(hit_count, 500u);
}

// A twisting ball whose vertices are given, or two keys of it.
struct Ball {
  test::Shape shape = test::sphere(4);
  std::vector<vec3> keys;
  World world;
  ObjectId object = 0;

  explicit Ball(bool free) {
    for (const float amount : {0.0f, 1.5f, -2.0f}) {
      const std::vector<vec3> moved = test::twisted(shape.positions, amount);
      keys.insert(keys.end(), moved.begin(), moved.end());
    }
    const auto count = static_cast<uint32_t>(shape.positions.size());
    const Motion motion = free ? Motion(FreeMotion{count}) : Motion(KeyframeMotion{count, keys});
    Pose pose;
    pose.positions = shape.positions;
    object = *world.add_object(*world.add_body({shape.triangles, motion, pose}));
  }
  Result<void> show(uint32_t key, float fraction) {
    Pose pose;
    pose.key = key;
    pose.key_fraction = fraction;
    return world.set_pose(object, pose);
  }
};

TEST(WorldUpdate, OfManyThreadsAtOneTreeletAllFindTheSame) {
  for (const int threads : {1, 2, 8}) {
    Ball ball(false);
    ball.world.set_update_mode(UpdateMode::lazy);
    for (uint32_t frame = 0; frame < 40; ++frame) {
      ASSERT_TRUE(ball.show(frame % 2, 0.01f * float(frame)));
      ball.world.commit();
      const Ray ray{.origin = vec3(0.1f, 0.2f, 5.0f)};
      std::vector<Hit> hits(static_cast<size_t>(threads));
      std::vector<std::thread> crowd;
      for (Hit& hit : hits) {
        crowd.emplace_back([&] { hit = *ball.world.closest_hit(ray); });
      }
      for (std::thread& thread : crowd) thread.join();
      for (const Hit& hit : hits) EXPECT_TRUE(same_bits({&hits[0], 1}, {&hit, 1}));
      // A crowd makes what one ray needs, no more.
      const UpdateStats stats = ball.world.stats();
      EXPECT_GE(stats.treelets_made, 1u);
      EXPECT_LT(stats.treelets_made, stats.treelets / 4);
      EXPECT_EQ(ball.world.validate(), "");
    }
  }
}

// A picture that every thread traces as a whole, so that they meet again and again.
TEST(WorldUpdate, OfManyThreadsAtAllTreeletsAllFindTheSame) {
  std::vector<Ray> rays;
  for (int i = 0; i < 64 * 64; ++i) {
    const vec3 at(0.04f * float(i % 64 - 32), 0.04f * float(i / 64 - 32), 1.0f);
    rays.push_back({.origin = vec3(0.0f, 0.0f, 5.0f), .direction = at - vec3(0.0f, 0.0f, 5.0f)});
  }
  for (const size_t threads : {2u, 8u}) {
    Ball ball(false);
    ball.world.set_update_mode(UpdateMode::lazy);
    for (uint32_t frame = 0; frame < 10; ++frame) {
      ASSERT_TRUE(ball.show(frame % 2, 0.1f * float(frame)));
      ball.world.commit();
      const Grouping grouping = frame % 4 < 2 ? Grouping::automatic : Grouping::none;
      std::vector<std::vector<Hit>> hits(threads, std::vector<Hit>(rays.size()));
      std::latch ready(static_cast<ptrdiff_t>(threads));
      std::vector<std::thread> crowd;
      for (std::vector<Hit>& mine : hits) {
        crowd.emplace_back([&] {
          ready.arrive_and_wait();
          ball.world.closest_hits(rays, mine, {.grouping = grouping});
        });
      }
      for (std::thread& thread : crowd) thread.join();
      for (const std::vector<Hit>& some : hits) EXPECT_TRUE(same_bits(hits[0], some));
      EXPECT_EQ(ball.world.validate(), "");
    }
  }
}

TEST(WorldUpdate, WhatNoRayReachesIsNotMade) {
  const Scene scene = *make_study_scene("bodies,subdivisions=4");
  World world = *prepare(scene, {.update = UpdateMode::lazy});
  ASSERT_TRUE(world.set_time(1.0));
  EXPECT_EQ(world.stats().treelets_made, 0u);
  const std::vector<Ray> rays = rays_through(world.box(), 1, 3);
  std::vector<Hit> hits(1);
  world.closest_hits(rays, hits);
  EXPECT_LT(world.stats().treelets_made, 20u);
  EXPECT_GT(world.stats().treelets, 500u);
}

TEST(WorldUpdate, AnUnchangedPoseKeepsWhatIsMade) {
  Ball ball(false);
  ball.world.set_update_mode(UpdateMode::lazy);
  ASSERT_TRUE(ball.show(0, 0.5f));
  ball.world.commit();
  const Ray ray{.origin = vec3(0.1f, 0.2f, 5.0f)};
  ASSERT_TRUE(ball.world.closest_hit(ray));
  const uint64_t made = ball.world.stats().treelets_made;
  ASSERT_TRUE(ball.show(0, 0.5f));
  ball.world.commit();
  EXPECT_EQ(ball.world.stats().unchanged, 1u);
  EXPECT_EQ(ball.world.stats().treelets_made, made);
  ASSERT_TRUE(ball.show(0, 0.6f));
  ball.world.commit();
  EXPECT_EQ(ball.world.stats().lazy, 1u);
  EXPECT_EQ(ball.world.stats().treelets_made, 0u);
}

TEST(WorldUpdate, OneFrameIsPosedWhileAnotherIsTraced) {
  for (const UpdateMode mode : kModes) {
    Ball ball(false);
    ball.world.set_update_mode(mode);
    const std::vector<Ray> rays = rays_through({vec3(-1.0f), vec3(1.0f)}, 2000, 7);
    const auto traced = [&] {
      std::vector<Hit> hits(rays.size());
      ball.world.closest_hits(rays, hits);
      return hits;
    };
    const auto at = [](uint32_t frame) { return 0.125f * float(frame); };
    std::vector<std::vector<Hit>> expected;
    for (uint32_t frame = 0; frame < 6; ++frame) {
      ASSERT_TRUE(ball.show(0, at(frame)));
      ball.world.commit();
      expected.push_back(traced());
    }
    ASSERT_TRUE(ball.show(0, at(0)));
    ball.world.commit();
    for (uint32_t frame = 0; frame + 1 < 6; ++frame) {
      ASSERT_TRUE(ball.show(0, at(frame + 1)));
      std::vector<Hit> hits;
      std::thread tracing([&] { hits = traced(); });
      ball.world.stage();
      tracing.join();
      EXPECT_TRUE(same_bits(expected[frame], hits)) << name_of(mode) << " frame " << frame;
      ball.world.flip();
    }
    EXPECT_TRUE(same_bits(expected[5], traced())) << name_of(mode);
    ball.world.flip();  // nothing is staged
    EXPECT_TRUE(same_bits(expected[5], traced())) << name_of(mode);
    // What is not posed anew follows all the same.
    ball.world.stage();
    ball.world.flip();
    EXPECT_TRUE(same_bits(expected[5], traced())) << name_of(mode);
  }
}

TEST(WorldUpdate, AnObjectThatIsNotFiniteIsSkippedAndComesBack) {
  for (const UpdateMode mode : kModes) {
    Ball ball(true);
    ball.world.set_update_mode(mode);
    std::vector<vec3> broken = ball.shape.positions;
    broken[7].y = NAN;
    const Ray ray{.origin = vec3(0.1f, 0.2f, 5.0f)};
    for (const bool good : {true, false, true}) {
      Pose pose;
      pose.positions = good ? ball.shape.positions : broken;
      ASSERT_TRUE(ball.world.set_pose(ball.object, pose));
      ball.world.commit();
      EXPECT_EQ(ball.world.any_hit(ray), good) << name_of(mode);
      EXPECT_EQ(ball.world.stats().objects_skipped, good ? 0u : 1u) << name_of(mode);
    }
  }
}

TEST(WorldUpdate, ARangeOfGivenVerticesIsAsGoodAsAll) {
  for (const UpdateMode mode : kModes) {
    Ball all(true), part(true);
    part.world.set_update_mode(mode);
    std::vector<vec3> moved = all.shape.positions;
    const auto rays = rays_through({vec3(-1.0f), vec3(1.0f)}, 500, 13);
    for (uint32_t round = 0; round < 8; ++round) {
      Pose pose;
      pose.positions = moved;
      ASSERT_TRUE(all.world.set_pose(all.object, pose));
      if (round > 0) pose.changed = {100 * round, 40};
      ASSERT_TRUE(part.world.set_pose(part.object, pose));
      all.world.commit();
      part.world.commit();
      std::vector<Hit> expected(rays.size()), hits(rays.size());
      all.world.closest_hits(rays, expected);
      part.world.closest_hits(rays, hits);
      EXPECT_TRUE(same_bits(expected, hits)) << name_of(mode) << " round " << round;
      EXPECT_EQ(part.world.validate(), "") << name_of(mode) << " round " << round;
      for (uint32_t v = 0; v < 40; ++v) moved[100 * (round + 1) + v] *= 1.1f;
    }
    Pose pose;
    pose.positions = moved;
    pose.changed = {uint32_t(moved.size()), 1};
    EXPECT_FALSE(part.world.set_pose(part.object, pose));
  }
}

TEST(WorldUpdate, TheTopTreeMayChangeWithoutANewPose) {
  Ball ball(false);
  ball.world.set_update_mode(UpdateMode::lazy);
  ASSERT_TRUE(ball.show(0, 0.5f));
  ASSERT_TRUE(ball.world.set_pose(*ball.world.add_object(0), {}));
  ball.world.commit();
  ball.world.set_top_tree(TopTree::treelets);
  ball.world.commit();
  EXPECT_TRUE(ball.world.any_hit({.origin = vec3(0.1f, 0.2f, 5.0f)}));
}

TEST(WorldUpdate, AFrameThatIsBehindTakesTheRangeThatItMissed) {
  Ball ball(true);
  std::vector<vec3> at = ball.shape.positions;
  const auto move = [&](VertexRange range) {
    for (uint32_t i = 0; i < range.count; ++i) at[range.first + i] *= 1.5f;
    Pose pose;
    pose.positions = at;
    pose.changed = range;
    ASSERT_TRUE(ball.world.set_pose(ball.object, pose));
  };
  move({10, 5});
  ball.world.stage();
  ball.world.commit();
  move({200, 5});
  ball.world.commit();
  ball.world.stage();
  ball.world.flip();
  EXPECT_EQ(ball.world.position(ball.object, 202), at[202]);
  EXPECT_EQ(ball.world.validate(), "");
}

// A skin of one joint, and of another with no weight.
TEST(WorldUpdate, WhetherAnObjectIsFiniteDoesNotDependOnTheMode) {
  const test::Shape good = test::sphere(3);
  test::Shape broken = good;
  broken.positions[7].y = NAN;
  std::vector<uint16_t> joints;
  std::vector<float> weights;
  for (size_t v = 0; v < good.positions.size(); ++v) {
    joints.insert(joints.end(), {0, 1});
    weights.insert(weights.end(), {1.0f, 0.0f});
  }
  const Affine still = identity_affine(), nowhere(vec3(NAN), vec3(0), vec3(0), vec3(0));
  for (const UpdateMode mode : kModes) {
    for (const test::Shape* shape : {&good, static_cast<const test::Shape*>(&broken)}) {
      for (const Affine& first : {still, nowhere}) {
        for (const Affine& second : {still, nowhere}) {
          const Affine pose_joints[] = {first, second};
          Pose pose, at_rest;
          pose.joints = pose_joints;
          at_rest.present = false;
          World world;
          world.set_update_mode(mode);
          const SkinMotion motion{shape->positions, 2, joints, weights, 2};
          const ObjectId object =
              *world.add_object(*world.add_body({shape->triangles, motion, at_rest}));
          ASSERT_TRUE(world.set_pose(object, pose));
          world.commit();
          const bool finite = shape == &good && first == still && second == still;
          EXPECT_EQ(world.stats().objects_skipped, finite ? 0u : 1u) << name_of(mode);
          EXPECT_EQ(world.any_hit({.origin = vec3(0.1f, 0.2f, 5.0f)}), finite) << name_of(mode);
        }
      }
    }
  }
}

TEST(WorldUpdate, VerticesOfAbsentAndRemovedObjectsAreNoTrap) {
  const Scene scene = *make_study_scene("creature,triangles=8000");
  ASSERT_GE(scene.objects[0].skin, 0);
  for (const UpdateMode mode : kModes) {
    World world = *prepare(scene, {.update = mode});
    Pose absent;
    absent.present = false;
    ASSERT_TRUE(world.set_pose(0, absent));
    const vec3 before = world.position(0, 5);
    world.commit();
    EXPECT_EQ(world.position(0, 5), before);
    world.remove_object(0);
    EXPECT_EQ(world.validate(), "");
    ASSERT_TRUE(world.set_time(0.5));
    EXPECT_EQ(world.stats().objects_present, scene.objects.size() - 1);
  }
}

// What it chooses then depends on what this machine takes for each; see choose_test.cpp.
TEST(WorldUpdate, AutomaticBeginsLazyLearnsWhatRaysReachAndSaysWhy) {
  Ball ball(false);
  uint32_t frame = 0;
  const auto trace_frames = [&](int count, size_t rays_a_frame) {
    const std::vector<Ray> rays = rays_through({vec3(-1.0f), vec3(1.0f)}, rays_a_frame, 11);
    std::vector<Hit> hits(rays.size());
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(ball.show(0, 0.001f * float(frame++)));
      ball.world.commit();
      ball.world.closest_hits(rays, hits);
    }
  };
  const auto choice = [&] { return ball.world.choice(ball.object); };
  trace_frames(1, 3);
  EXPECT_EQ(choice().mode, UpdateMode::lazy);
  EXPECT_STREQ(choice().why, "no ray has come yet");
  trace_frames(4, 3);
  EXPECT_LT(choice().reached, 0.3f);
  EXPECT_STRNE(choice().why, "no ray has come yet");
  trace_frames(40, 20000);
  EXPECT_GT(choice().reached, 0.5f);
}

#ifndef NDEBUG
TEST(WorldUpdateDeathTest, AnUpdateDuringAQueryIsNoticed) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto update_in_query = [] {
    Ball ball(false);
    ball.world.set_update_mode(UpdateMode::full);
    (void)ball.show(0, 0.5f);
    ball.world.commit();
    const auto commit = [](const void* world, uint32_t, const Hit&) {
      const_cast<World*>(static_cast<const World*>(world))->commit();
      return true;
    };
    const Ray ray{.origin = vec3(0.1f, 0.2f, 5.0f)};
    Hit hit;
    ball.world.closest_hits({&ray, 1}, {&hit, 1}, {.filter = {commit, &ball.world, true}});
  };
  EXPECT_DEATH(update_in_query(), "CHECK");
}
#endif

}  // namespace
}  // namespace sinew
