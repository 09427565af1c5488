#include "sinew/world/world.h"

#include <gtest/gtest.h>

#include "oracle.h"
#include "shapes.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

Pose placed(const Affine& placement) {
  Pose pose;
  pose.placement = placement;
  return pose;
}
Affine moved(vec3 by) {
  return trs(by, glm::identity<quat>(), vec3(1));
}

BodyDesc rigid_body(const test::Shape& shape) {
  return {shape.triangles, RigidMotion{shape.positions}, Pose(), {}};
}

TEST(World, InstancesOfOneBodyAreHitWhereTheyStand) {
  const auto shape = test::sphere(3);
  World world;
  const BodyId body = *world.add_body(rigid_body(shape));
  for (int i = 0; i < 20; ++i) {
    const ObjectId object = *world.add_object(body);
    ASSERT_TRUE(world.set_pose(object, placed(moved(vec3(3.0f * float(i), 0, 0)))));
  }
  world.commit();
  for (int i = 0; i < 20; ++i) {
    const auto hit = world.closest_hit({.origin = vec3(3.0f * float(i), 0.01f, 5)});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->object, uint32_t(i));
    EXPECT_NEAR(hit->t, 4.0f, 0.05f);
  }
  EXPECT_FALSE(world.closest_hit({.origin = vec3(1.5f, 0, 5)}));
  EXPECT_EQ(world.validate(), "");
}

TEST(World, ScaledAndRotatedInstancesAgreeWithBruteForce) {
  const auto shape = test::random_triangles(300, 4);
  World world;
  const BodyId body = *world.add_body(rigid_body(shape));
  std::vector<vec3> all;
  std::vector<uvec3> triangles;
  Random random(21);
  for (int i = 0; i < 8; ++i) {
    const vec3 scale = random.uniform3(0.3f, 2.0f) * (i % 2 ? 1.0f : -1.0f);
    const Affine place = trs(random.uniform3(-2, 2),
                             glm::angleAxis(random.uniform(0, 6), random.direction()), scale);
    ASSERT_TRUE(world.set_pose(*world.add_object(body), placed(place)));
    for (const uvec3 t : shape.triangles) triangles.push_back(t + uint32_t(all.size()));
    for (const vec3 p : shape.positions) all.push_back(transform_point(place, p));
  }
  world.commit();
  const auto rays = test::test_rays(all, triangles, 2000, 5);
  std::vector<Hit> hits(rays.size());
  world.closest_hits(rays, hits);
  test::Agreement agreement;
  for (size_t i = 0; i < rays.size(); ++i) {
    // Rounding of the placement exceeds the oracle's bound for one mesh: compare identities.
    const test::Verdict truth = test::brute_force(rays[i], all, triangles);
    if (!truth.certain) continue;
    ++agreement.certain;
    const bool same = hits[i] ? hits[i].object * 300 + hits[i].primitive == truth.primitive
                              : truth.primitive == kNoObject;
    agreement.wrong += !same;
  }
  EXPECT_LE(agreement.wrong, 2u);
  EXPECT_GT(agreement.certain, 1800u);
}

TEST(World, HiddenMaskedAndRemovedObjectsAreNotSeen) {
  const auto shape = test::sphere(2);
  World world;
  const BodyId body = *world.add_body(rigid_body(shape));
  const ObjectId front = *world.add_object(body, {.mask = 1});
  const ObjectId back = *world.add_object(body, {.mask = 2});
  ASSERT_TRUE(world.set_pose(front, placed(moved(vec3(0, 0, 3)))));
  world.commit();
  const Ray ray{.origin = vec3(0.01f, 0.02f, 10)};
  const auto seen = [&](uint32_t mask) {
    Hit hit;
    world.closest_hits({&ray, 1}, {&hit, 1}, {.mask = mask});
    return hit.object;
  };
  EXPECT_EQ(seen(3), front);
  EXPECT_EQ(seen(2), back);
  EXPECT_EQ(seen(4), kNoObject);
  world.set_visible(front, false);
  world.commit();
  EXPECT_EQ(seen(3), back);
  world.set_visible(front, true);
  world.remove_object(back);
  EXPECT_EQ(seen(2), back);  // until the next commit, and what rays meet can be asked about
  EXPECT_EQ(world.placement(back), identity_affine());
  world.commit();
  EXPECT_EQ(seen(3), front);
  EXPECT_EQ(seen(2), kNoObject);
}

TEST(World, ObjectsWithoutAPlaceAreAbsentAndComeBack) {
  const auto shape = test::sphere(2);
  World world;
  const ObjectId object = *world.add_object(*world.add_body(rigid_body(shape)));
  const Ray ray{.origin = vec3(0.01f, 0.02f, 10)};
  for (const float scale : {0.0f, NAN}) {
    ASSERT_TRUE(world.set_pose(object, placed(trs(vec3(0), glm::identity<quat>(), vec3(scale)))));
    world.commit();
    EXPECT_FALSE(world.any_hit(ray));
    ASSERT_TRUE(world.set_pose(object, Pose()));
    world.commit();
    EXPECT_TRUE(world.any_hit(ray));
  }
}

TEST(World, DeformingObjectsOfOneBodyHaveTheirOwnPoses) {
  const auto shape = test::sphere(4);
  World world;
  const uint32_t count = uint32_t(shape.positions.size());
  Pose rest;
  rest.positions = shape.positions;
  const BodyId body = *world.add_body({shape.triangles, FreeMotion{count}, rest, {}});
  std::vector<std::vector<vec3>> at;
  for (int i = 0; i < 3; ++i) {
    auto p = test::twisted(shape.positions, 0.4f * float(i));
    for (vec3& v : p) v.x += 4.0f * float(i);
    at.push_back(p);
    Pose pose;
    pose.positions = at.back();
    ASSERT_TRUE(world.set_pose(*world.add_object(body), pose));
  }
  world.commit();
  EXPECT_EQ(world.validate(), "");
  EXPECT_EQ(world.stats().triangles_updated, 3 * shape.triangles.size());
  for (uint32_t i = 0; i < 3; ++i) {
    const auto rays = test::test_rays(at[i], shape.triangles, 300, i);
    for (const Ray& ray : rays) {
      const auto truth = test::brute_force(ray, at[i], shape.triangles);
      Hit hit;
      world.closest_hits({&ray, 1}, {&hit, 1});
      if (truth.certain && truth.primitive != kNoObject && hit.object == i) {
        EXPECT_EQ(hit.primitive, truth.primitive);
      }
    }
  }
}

TEST(World, PosesThatDoNotFitAreErrors) {
  const auto shape = test::sphere(1);
  World world;
  Pose rest;
  rest.positions = shape.positions;
  const BodyId body =
      *world.add_body({shape.triangles, FreeMotion{uint32_t(shape.positions.size())}, rest, {}});
  const ObjectId object = *world.add_object(body);
  EXPECT_EQ(world.set_pose(object, Pose()).error().kind, ErrorKind::usage);
  EXPECT_EQ(world.add_object(77).error().kind, ErrorKind::usage);
  EXPECT_EQ(world.set_time(0.0).error().kind, ErrorKind::usage);
}

TEST(World, FilteredHitsAreAskedAboutAndSkipped) {
  const auto shape = test::sphere(2);
  World world;
  const BodyId body = *world.add_body(rigid_body(shape));
  const ObjectId front = *world.add_object(body, {.filtered = true});
  const ObjectId back = *world.add_object(body);
  ASSERT_TRUE(world.set_pose(front, placed(moved(vec3(0, 0, 3)))));
  world.commit();
  const Ray ray{.origin = vec3(0.01f, 0.02f, 10)};
  int asked = 0;
  QueryOptions options;
  options.filter.context = &asked;
  options.filter.accept = [](const void* context, uint32_t, const Hit& hit) {
    ++*static_cast<int*>(const_cast<void*>(context));
    EXPECT_EQ(hit.object, 0u);
    return false;
  };
  Hit hit;
  world.closest_hits({&ray, 1}, {&hit, 1}, options);
  EXPECT_EQ(hit.object, back);
  EXPECT_EQ(asked, 2);  // the way in and the way out of the front sphere
}

TEST(World, SingleSidedObjectsAreMetOnTheSideAskedFor) {
  const auto shape = test::sphere(3);
  World world;
  const BodyId body = *world.add_body(rigid_body(shape));
  const ObjectId single = *world.add_object(body, {.single_sided = true});
  const auto distance = [&](const Ray& ray, Facing facing) {
    Hit hit;
    world.closest_hits({&ray, 1}, {&hit, 1}, {.facing = facing});
    return hit ? hit.t : -1.0f;
  };
  // Mirrored placements keep inside and outside.
  for (const float mirror : {1.0f, -1.0f}) {
    ASSERT_TRUE(
        world.set_pose(single, placed(trs(vec3(0), glm::identity<quat>(), vec3(mirror, 1, 1)))));
    world.commit();
    for (const float side : {1.0f, -1.0f}) {
      const Ray outside{.origin = vec3(0.01f, 0.02f, 5 * side), .direction = vec3(0, 0, -side)};
      EXPECT_NEAR(distance(outside, Facing::any), 4.0f, 0.05f);
      EXPECT_NEAR(distance(outside, Facing::front), 4.0f, 0.05f);
      EXPECT_NEAR(distance(outside, Facing::back), 6.0f, 0.05f);
      const Ray inside{.origin = vec3(0.01f, 0.02f, 0), .direction = vec3(0, 0, -side)};
      EXPECT_EQ(distance(inside, Facing::front), -1.0f);
      EXPECT_NEAR(distance(inside, Facing::back), 1.0f, 0.05f);
    }
  }
}

TEST(World, ATriangleIsHitThroughATinyInstanceFarAway) {
  const auto shape = test::sphere(3);
  World world;
  const ObjectId object = *world.add_object(*world.add_body(rigid_body(shape)));
  ASSERT_TRUE(world.set_pose(
      object, placed(trs(vec3(1e4f, -1e4f, 1e4f), glm::identity<quat>(), vec3(0.5f)))));
  world.commit();
  int missed = 0;
  Random random(8);
  for (int i = 0; i < 5000; ++i) {
    missed += !world.any_hit({.origin = vec3(1e4f, -1e4f, 1e4f), .direction = random.direction()});
  }
  EXPECT_EQ(missed, 0);
}

TEST(World, ScenesMayHoldVoxelsAlone) {
  Scene scene;
  scene.materials.resize(1);
  scene.octrees = {test::plain_octree(20, 100, 1, 2)};
  scene.nodes.resize(1);
  scene.nodes[0].octree = 0;
  scene.clips = {
      {"move",
       0.0,
       1.0,
       {{0, ChannelPath::translation, Interpolation::linear, 3, {0, 1}, {0, 0, 0, 1, 0, 0}}}}};
  list_objects(scene);
  Result<World> world = prepare(scene);
  ASSERT_TRUE(world) << world.error().message();
  ASSERT_TRUE(world->set_time(0.5));
  EXPECT_EQ(world->validate(), "");
  ASSERT_EQ(world->pose().voxels.size(), 1u);
  EXPECT_EQ(world->pose().voxels[0].placement[3].x, 0.5f);
  const Box box = animation_bounds(scene, 0, 2);
  const auto hit =
      world->closest_hit({.origin = box.center() - vec3(0, 0, 99), .direction = vec3(0, 0, 1)});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->object, 0u);
  EXPECT_TRUE(world->has_voxels(0));
}

}  // namespace
}  // namespace sinew
