#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/scene/study.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

constexpr uint32_t kDeep = 200;

bool same(const Box& a, const Box& b) {
  return a.min == b.min && a.max == b.max;
}

// Every vertex of every object lies in one of its boxes, or in one of the top tree's.
void expect_covered(const Scene& scene, const World& world, const std::vector<TreeBox>& boxes) {
  for (uint32_t object = 0; object < scene.objects.size(); ++object) {
    const Affine placement = world.placement(object);
    size_t outside = 0;
    std::vector<vec3> positions(scene.meshes[scene.objects[object].mesh].positions.size());
    world.positions(object, positions);
    for (const vec3 p : positions) {
      outside += std::none_of(boxes.begin(), boxes.end(), [&](const TreeBox& b) {
        return b.object == object
                   ? b.box.contains(p)
                   : b.object == kNoObject && b.box.contains(transform_point(placement, p));
      });
    }
    EXPECT_EQ(outside, 0u) << "object " << object;
  }
}

TEST(Boxes, EveryLevelHoldsEverythingAndIsTighter) {
  for (const char* name : {"bodies,subdivisions=2", "twist,triangles=1000"}) {
    SCOPED_TRACE(name);
    const Scene scene = *make_study_scene(name);
    World world = *prepare(scene, {.update = UpdateMode::full});
    ASSERT_TRUE(world.set_time(0.9));
    size_t last = 0;
    for (const uint32_t level : {0u, 1u, 2u, 3u, 5u, kDeep}) {
      SCOPED_TRACE(level);
      const std::vector<TreeBox> boxes = world.boxes(level);
      EXPECT_GE(boxes.size(), last);
      last = boxes.size();
      expect_covered(scene, world, boxes);
    }
    EXPECT_GT(last, 30u);
    EXPECT_EQ(world.boxes(kDeep - 1).size(), last) << "the leaves";
  }
}

TEST(Boxes, LevelZeroIsTheWhole) {
  const Scene scene = *make_study_scene("bodies,subdivisions=2");
  const World world = *prepare(scene, {.update = UpdateMode::full});
  const std::vector<TreeBox> boxes = world.boxes(0);
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_EQ(boxes[0].object, kNoObject);
  EXPECT_TRUE(same(boxes[0].box, world.box()));
}

TEST(Boxes, ALoneObjectsRootIsLevelZero) {
  const std::vector<vec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<uvec3> triangles = {{0, 1, 2}};
  World world;
  const BodyId body = *world.add_body({triangles, RigidMotion{positions}, Pose(), {}});
  const ObjectId object = *world.add_object(body);
  world.commit();
  for (const uint32_t level : {0u, 1u, kDeep}) {
    ASSERT_EQ(world.boxes(level).size(), 1u);
    EXPECT_EQ(world.boxes(level)[0].object, object);
    EXPECT_TRUE(same(world.boxes(level)[0].box, {vec3(0), vec3(1, 1, 0)}));
  }
  world.set_visible(object, false);
  world.commit();
  EXPECT_TRUE(world.boxes(0).empty());
}

}  // namespace
}  // namespace sinew
