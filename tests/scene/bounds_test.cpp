// The box of an animation contains every sampled frame, and no more.
#include <gtest/gtest.h>

#include "scene/small_scenes.h"
#include "sinew/math/random.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

using test::channel;
using test::scene_of;

TEST(AnimationBounds, CoverTheWholeClip) {
  Scene scene = scene_of({test::triangle_mesh()});
  scene.clips = {
      {"rise", 1, 3, {channel(0, ChannelPath::translation, 3, {1, 3}, {0, 0, 0, 0, 0, 8})}}};
  const Box box = animation_bounds(scene, 0, 5);
  EXPECT_EQ(box.min, vec3(0, 0, 0));
  EXPECT_EQ(box.max, vec3(1, 1, 8));
  EXPECT_EQ(animation_bounds(scene, 0, 1).max, vec3(1, 1, 0));  // the first time only
  EXPECT_EQ(animation_bounds(scene, kRestPose, 5).max, vec3(1, 1, 0));
}

TEST(AnimationBounds, LeaveOutWhatIsHiddenOrAbsent) {
  Scene scene = scene_of({test::triangle_mesh(), test::triangle_mesh(), test::triangle_mesh()});
  scene.nodes[1].translation = vec3(100);
  scene.nodes[1].visible = false;
  scene.nodes[2].translation = vec3(100);
  scene.nodes[2].scale = vec3(0);
  EXPECT_EQ(animation_bounds(scene, kRestPose, 1).max, vec3(1, 1, 0));
  EXPECT_TRUE(animation_bounds(Scene{}, kRestPose, 1).empty());
}

// Bodies larger than one chunk of vertices, placed and skinned.
TEST(AnimationBounds, EqualTheBoxOfAllWorldPositions) {
  constexpr uint32_t kSeed = 5;
  Random random(kSeed);
  Scene scene = test::skinned_scene();
  scene.meshes.push_back(test::triangle_mesh());
  scene.nodes.push_back(test::node(2, {3, 4, 5}));
  scene.nodes.back().mesh = 1;
  list_objects(scene);
  for (Mesh& mesh : scene.meshes) {
    for (int i = 0; i < 5000; ++i) mesh.positions.push_back(random.uniform3(-1, 1));
  }
  scene.meshes[0].joints.resize(2 * 5003, 1);
  scene.meshes[0].weights.resize(2 * 5003, 0.5f);
  scene.clips = {{"turn",
                  0,
                  1,
                  {channel(2, ChannelPath::rotation, 4, {0, 1}, {0, 0, 0, 1, 0.6f, 0, 0.8f, 0}),
                   channel(1, ChannelPath::translation, 3, {0, 1}, {0, 0, 0, 5, 0, 0})}}};
  ASSERT_EQ(validate(scene), "");

  Box expected;
  ScenePose pose;
  for (int i = 0; i < 7; ++i) {
    sample(scene, 0, i / 6.0, pose);
    for (uint32_t object = 0; object < 2; ++object) {
      std::vector<vec3> points(scene.meshes[object].positions.size());
      world_positions(scene, pose, object, points);
      for (const vec3 p : points) expected.extend(p);
    }
  }
  const Box box = animation_bounds(scene, 0, 7);
  EXPECT_LE(length(box.min - expected.min), 1e-6f) << "seed " << kSeed;
  EXPECT_LE(length(box.max - expected.max), 1e-6f) << "seed " << kSeed;
}

}  // namespace
}  // namespace sinew
