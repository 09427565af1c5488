// Voxel objects in a World, beside triangles.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "sinew/base/parallel.h"
#include "world/mixed_world.h"

namespace sinew {
namespace {

using test::BruteObject;
using test::BruteOctree;
using test::Mixed;
using test::OwnPose;
using test::placed;

TEST(WorldOctrees, MixedScenesAgreeWithBruteForce) {
  for (const uint32_t seed : {1u, 2u}) {
    const Mixed m(seed);
    EXPECT_EQ(m.world.validate(), "");
    const BruteOctree still(m.rigid, Pose()), first(m.moving, m.poses[0].pose()),
        last(m.moving, m.poses[2].pose());
    const std::vector<BruteObject> objects = {{&still, m.places[2], m.rigids[0]},
                                              {&still, m.places[3], m.rigids[1]},
                                              {&first, m.places[4], m.movings[0]},
                                              {&first, m.places[5], m.movings[1]},
                                              {&last, m.places[6], m.movings[2]}};
    const std::vector<Ray> rays = test::rays_about(m.world.box(), 700, seed);
    std::vector<Hit> hits(rays.size()), triangles(rays.size());
    std::vector<uint8_t> any(rays.size());
    m.world.closest_hits(rays, hits);
    m.world.any_hits(rays, any);
    m.triangles_alone.closest_hits(rays, triangles);
    size_t voxels = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " ray " << i);
      double nearest = triangles[i].t;
      for (const BruteObject& object : objects) {
        nearest = std::min(nearest, test::brute_entry(rays[i], object));
      }
      EXPECT_EQ(any[i] != 0, bool{hits[i]});
      if (!hits[i]) {
        EXPECT_FALSE(std::isfinite(nearest));
        continue;
      }
      EXPECT_LE(hits[i].t, nearest + 1e-5 * (1.0 + std::abs(nearest)));
      if (hits[i].object < 2) {
        EXPECT_TRUE(test::same_hits({&hits[i], 1}, {&triangles[i], 1}));
        continue;
      }
      ++voxels;
      const auto object = std::ranges::find(objects, hits[i].object, &BruteObject::id);
      ASSERT_NE(object, objects.end());
      EXPECT_TRUE(test::is_entry(rays[i], *object, hits[i]));
      EXPECT_LT(hits[i].t, triangles[i].t);
    }
    EXPECT_GT(voxels, 100u);
  }
}

TEST(WorldOctrees, AllHitsBeginWithTheClosestAndSingleRaysAgree) {
  const Mixed m(3);
  const std::vector<Ray> rays = test::rays_about(m.world.box(), 900, 3);
  std::vector<Hit> hits(rays.size()), alone(rays.size()), counted(rays.size()), all;
  std::vector<TraversalCounts> counts(rays.size());
  m.world.closest_hits(rays, hits);
  m.world.closest_hits(rays, alone, {.grouping = Grouping::none});
  m.world.count_closest_hits(rays, counted, counts);
  EXPECT_TRUE(test::same_hits(hits, alone));
  EXPECT_TRUE(test::same_hits(hits, counted));
  const BruteOctree still(m.rigid, Pose());
  size_t through = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    SCOPED_TRACE(i);
    const auto single = m.world.closest_hit(rays[i]);
    ASSERT_EQ(single.has_value(), bool{hits[i]});
    EXPECT_EQ(m.world.any_hit(rays[i]), bool{hits[i]});
    m.world.all_hits(rays[i], all);
    ASSERT_EQ(all.empty(), !hits[i]);
    if (!hits[i]) continue;
    EXPECT_TRUE(test::same_hits({&*single, 1}, {&hits[i], 1}));
    EXPECT_TRUE(test::same_hits({all.data(), 1}, {&hits[i], 1}));
    // Of rigid octrees: at least every voxel that brute force surely finds.
    for (size_t k = 0; k < 2; ++k) {
      size_t sure = 0;
      const auto [origin, direction] = test::in_object(rays[i], m.places[2 + k]);
      for (const test::DoubleBox& box : still.boxes) {
        const auto [first, last] = test::crossing(origin, direction, box);
        sure += first <= last && last >= 0.0;
      }
      const auto found = static_cast<size_t>(std::ranges::count(all, m.rigids[k], &Hit::object));
      EXPECT_GE(found, sure);
      through += found;
    }
  }
  EXPECT_GT(through, 20u);
}

TEST(WorldOctrees, HiddenMaskedAndRemovedVoxelsAreNotSeen) {
  const Svo svo = test::plain_octree(30, 800, 1, 2);
  World world;
  const BodyId body = *world.add_octree({&svo});
  const ObjectId front = *world.add_object(body, {.mask = 1}),
                 back = *world.add_object(body, {.mask = 2});
  ASSERT_TRUE(world.set_pose(front, placed(trs(vec3(0, 0, 6), glm::identity<quat>(), vec3(1)))));
  world.commit();
  const Box box = world.box();
  const std::vector<Ray> rays = [&] {
    std::vector<Ray> out;
    Random random(4);
    for (int i = 0; i < 50; ++i) {
      const float x = random.uniform(0.3f, 0.7f), y = random.uniform(0.3f, 0.7f);
      out.push_back({.origin = vec3(box.min.x + x * box.extent().x, box.min.y + y * box.extent().y,
                                    box.max.z + 1)});
    }
    return out;
  }();
  // How many rays hit, and the one object that they hit.
  const auto seen = [&](uint32_t mask) {
    std::vector<Hit> hits(rays.size());
    world.closest_hits(rays, hits, {.mask = mask});
    uint32_t object = kNoObject;
    for (const Hit& hit : hits) {
      if (hit) object = object == kNoObject || object == hit.object ? hit.object : 99;
    }
    return object;
  };
  EXPECT_EQ(seen(1), front);
  EXPECT_EQ(seen(2), back);
  EXPECT_EQ(seen(4), kNoObject);
  EXPECT_EQ(world.voxel_objects().size(), 2u);
  world.set_visible(front, false);
  world.commit();
  EXPECT_EQ(seen(3), back);
  EXPECT_FALSE(world.voxel_instance(front));
  EXPECT_TRUE(world.voxel_instance(back));
  world.set_visible(front, true);
  world.remove_object(back);
  EXPECT_EQ(seen(2), back);  // until the next commit
  world.commit();
  EXPECT_EQ(seen(2), kNoObject);
  EXPECT_EQ(seen(3), front);
  Pose absent;
  absent.present = false;
  ASSERT_TRUE(world.set_pose(front, absent));
  world.commit();
  EXPECT_EQ(seen(3), kNoObject);
  EXPECT_TRUE(world.box().empty());
  ASSERT_TRUE(world.set_pose(front, Pose()));
  world.commit();
  EXPECT_EQ(seen(1), front);
  EXPECT_EQ(world.validate(), "");
}

TEST(WorldOctrees, PosesThatAreNotFiniteLeaveTheObjectOut) {
  const Svo svo = test::moving_octree(40, 500, 3);
  World world;
  const ObjectId object = *world.add_object(*world.add_octree({&svo}));
  world.commit();
  EXPECT_EQ(world.stats().objects_present, 0u) << "it waits for its pose";
  OwnPose good = test::moving_pose(1), bad = good;
  bad.joints[3][1].y = NAN;
  ASSERT_TRUE(world.set_pose(object, bad.pose()));
  world.commit();
  EXPECT_EQ(world.stats().objects_skipped, 1u);
  EXPECT_EQ(world.stats().objects_present, 0u);
  world.stage();
  world.flip();  // the frame that never had the pose
  EXPECT_EQ(world.stats().objects_present, 0u);
  ASSERT_TRUE(world.set_pose(object, good.pose()));
  world.commit();
  EXPECT_EQ(world.stats().objects_present, 1u);
  good.placement = trs(vec3(0), glm::identity<quat>(), vec3(0));
  ASSERT_TRUE(world.set_pose(object, good.pose()));
  world.commit();
  EXPECT_EQ(world.stats().objects_present, 0u);
  EXPECT_EQ(world.validate(), "");
}

TEST(WorldOctrees, BadOctreesAndPosesAreErrors) {
  const Svo svo = test::moving_octree(40, 500, 3);
  World world;
  EXPECT_EQ(world.add_octree({}).error().kind, ErrorKind::usage);
  EXPECT_EQ(world.add_octree({&svo, Pose()}).error().kind, ErrorKind::usage);
  const OwnPose own = test::moving_pose(1);
  const BodyId body = *world.add_octree({&svo});
  const ObjectId object = *world.add_object(body);
  Pose few = own.pose();
  few.joints = few.joints.first(4);
  EXPECT_EQ(world.set_pose(object, few).error().kind, ErrorKind::usage);
  Pose many = own.pose();
  many.weights = {};
  EXPECT_EQ(world.set_pose(object, many).error().kind, ErrorKind::usage);
  EXPECT_TRUE(world.set_pose(object, own.pose()));
  EXPECT_TRUE(world.has_voxels(object));
  EXPECT_EQ(world.known_positions(object).size(), 0u);
}

TEST(WorldOctrees, ObjectsInTheSamePoseShareIt) {
  const Svo svo = test::moving_octree(40, 500, 3);
  World world;
  const BodyId body = *world.add_octree({&svo, test::moving_pose(1).pose()});
  constexpr uint32_t kCount = 12;
  for (uint32_t i = 0; i < kCount; ++i) ASSERT_TRUE(world.add_object(body));
  // Object i takes pose of_object(i); returns how many octrees were posed.
  const auto posed = [&](const auto& of_object) {
    std::vector<OwnPose> poses(kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
      poses[i] = test::moving_pose(of_object(i));
      poses[i].placement[3].x = 9.0f * static_cast<float>(i);
      EXPECT_TRUE(world.set_pose(i, poses[i].pose()));
    }
    world.commit();
    EXPECT_EQ(world.validate(), "");
    EXPECT_EQ(world.stats().voxel_objects, kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
      const VoxelInstance instance = *world.voxel_instance(i);
      EXPECT_EQ(instance.posed->pose().joints[2], poses[i].joints[2]) << i;
      EXPECT_EQ(instance.placement[3].x, 9.0f * static_cast<float>(i));
    }
    return world.stats().octrees_posed;
  };
  EXPECT_EQ(posed([](uint32_t) { return 1; }), 1u);
  const PosedSvo* const shared = world.voxel_instance(0)->posed;
  for (uint32_t i = 1; i < kCount; ++i) EXPECT_EQ(world.voxel_instance(i)->posed, shared);
  EXPECT_EQ(world.stats().blocks, svo.block_count());
  EXPECT_EQ(posed([](uint32_t) { return 1; }), 0u) << "nothing new";
  EXPECT_EQ(posed([](uint32_t i) { return i; }), kCount - 1) << "one of them is known";
  EXPECT_EQ(world.stats().blocks, kCount * svo.block_count());
  EXPECT_EQ(posed([](uint32_t i) { return i + 100; }), kCount);
  EXPECT_EQ(posed([](uint32_t i) { return i % 3 + 200; }), 3u);
  EXPECT_EQ(posed([](uint32_t i) { return (i + 1) % kCount + 300; }), kCount);
  EXPECT_EQ(posed([](uint32_t i) { return (i + 2) % kCount + 300; }), 0u) << "they change places";
}

TEST(WorldOctrees, OnlyWhatRaysReachIsMade) {
  const Svo svo = test::moving_octree(140, 4000, 3);
  World world;
  const BodyId body = *world.add_octree({&svo, test::moving_pose(1).pose()});
  const float apart = 1000.0f;
  OwnPose poses[3];
  for (uint32_t i = 0; i < 3; ++i) {
    poses[i] = test::moving_pose(i);
    poses[i].placement[3].x = apart * static_cast<float>(i);
    ASSERT_TRUE(world.set_pose(*world.add_object(body), poses[i].pose()));
  }
  world.commit();
  EXPECT_EQ(world.stats().blocks_made, 0u);
  EXPECT_EQ(world.stats().cells_made, 0u);
  Random random(9);
  const Box rest{svo.grid.origin, svo.grid.origin + svo.grid.voxel * vec3(svo.grid.resolution)};
  const auto shoot = [&](int count) {
    int hits = 0;
    for (int i = 0; i < count; ++i) {
      const vec3 to =
          rest.center() + vec3(apart, 0, 0) + 0.3f * random.uniform3(-1, 1) * rest.extent();
      const vec3 from = to + 2.0f * rest.extent().x * random.direction();
      hits += world.any_hit({.origin = from, .direction = to - from, .t_max = 4.0f});
    }
    return hits;
  };
  EXPECT_GT(shoot(5), 0);
  const UpdateStats few = world.stats();
  EXPECT_GT(few.blocks_made, 0u);
  EXPECT_GT(few.cells_made, 0u);
  EXPECT_GT(shoot(3000), 1000);
  const UpdateStats many = world.stats();
  EXPECT_GT(many.cells_made, few.cells_made);
  EXPECT_LE(many.blocks_made, svo.block_count()) << "the others are never looked at";
  for (const ObjectId unseen : {0u, 2u}) {
    EXPECT_EQ(world.voxel_instance(unseen)->posed->blocks_made(), 0u);
  }
  EXPECT_EQ(world.validate(), "");
}

// Poses of two frames are in flight: what is shown is what was committed.
TEST(WorldOctrees, StagedPosesShowOnlyWhenFlipped) {
  Mixed a(5), b(5);
  const std::vector<Ray> rays = test::rays_about(a.world.box(), 500, 5);
  const auto hits_of = [&](const World& world) {
    std::vector<Hit> hits(rays.size());
    world.closest_hits(rays, hits);
    return hits;
  };
  std::vector<Hit> before = hits_of(a.world);
  for (uint32_t frame = 0; frame < 6; ++frame) {
    for (Mixed* m : {&a, &b}) {
      for (size_t i = 0; i < 3; ++i) {
        if ((frame + i) % 3 == 0) continue;  // some keep their pose
        OwnPose next = test::moving_pose(10 * frame + static_cast<uint32_t>(i > 0));
        next.placement = m->poses[i].placement;
        m->poses[i] = next;
        ASSERT_TRUE(m->world.set_pose(m->movings[i], m->poses[i].pose()));
        for (Affine& joint : m->poses[i].joints) EXPECT_NE(joint[0].x, 77.0f);
      }
      if (m == &a) {
        m->world.stage();
      } else {
        m->world.commit();
      }
      // The world does not look at the caller's poses any more.
      for (OwnPose& pose : m->poses) std::ranges::fill(pose.joints, Affine(77.0f));
    }
    EXPECT_TRUE(test::same_hits(hits_of(a.world), before)) << "frame " << frame;
    a.world.flip();
    const std::vector<Hit> after = hits_of(a.world);
    EXPECT_TRUE(test::same_hits(after, hits_of(b.world))) << "frame " << frame;
    EXPECT_FALSE(test::same_hits(after, before)) << "frame " << frame;
    before = after;
    EXPECT_EQ(a.world.validate(), "");
  }
}

TEST(WorldOctrees, SameBitsForAnyNumberOfThreadsAndTopTree) {
  std::vector<Hit> expected;
  for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
    for (const int threads : {1, 2, 8}) {
      const ThreadLimit limit(threads);
      const Mixed m(7, top);
      const std::vector<Ray> rays = test::rays_about(m.world.box(), 4000, 7);
      std::vector<Hit> hits(rays.size());
      m.world.closest_hits(rays, hits);
      if (expected.empty()) expected = hits;
      EXPECT_TRUE(test::same_hits(hits, expected)) << threads << " threads";
    }
  }
}

// Threads that come to an octree nobody has looked at, while the next pose is staged.
TEST(WorldOctrees, ManyThreadsMeetInOneOctree) {
  Mixed m(8);
  const std::vector<Ray> rays = test::rays_about(m.world.box(), 400, 8);
  std::vector<Hit> expected(rays.size());
  m.world.closest_hits(rays, expected);
  const std::vector<OwnPose> first = m.poses;
  for (uint32_t round = 0; round < 6; ++round) {
    for (size_t i = 0; i < 3; ++i) {
      m.poses[i] = first[i];
      if (round % 2 == 0) m.poses[i].joints = test::moving_pose(50 + round).joints;
      ASSERT_TRUE(m.world.set_pose(m.movings[i], m.poses[i].pose()));
    }
    std::atomic<uint32_t> wrong = 0;
    std::vector<std::thread> threads;
    for (uint32_t t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (size_t i = 0; i < rays.size(); ++i) {
          const size_t at = (i + t) % rays.size();
          Hit hit;
          m.world.closest_hits({&rays[at], 1}, {&hit, 1});
          wrong += !test::same_hits({&hit, 1}, {&expected[at], 1});
        }
      });
    }
    m.world.stage();
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong.load(), 0u) << "round " << round;
    m.world.flip();
    Mixed fresh(8);
    for (size_t i = 0; i < 3; ++i) {
      ASSERT_TRUE(fresh.world.set_pose(fresh.movings[i], m.poses[i].pose()));
    }
    fresh.world.commit();
    fresh.world.closest_hits(rays, expected);
  }
}

}  // namespace
}  // namespace sinew
