// Poses by hand numbers: hierarchies, skins, morph weights, caches, visibility, absence.
#include "sinew/scene/sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "scene/small_scenes.h"

namespace sinew {
namespace {

using test::channel;
using test::node;
using test::scene_of;

constexpr float kHalf = 0.70710678f;
const quat kQuarterZ(kHalf, 0, 0, kHalf);  // w, x, y, z

std::vector<vec3> world(const Scene& scene, const ScenePose& pose, uint32_t object = 0) {
  std::vector<vec3> out(scene.meshes[scene.objects[object].mesh].positions.size());
  world_positions(scene, pose, object, out);
  return out;
}

void expect_near(vec3 a, vec3 b, float tolerance = 1e-6f) {
  EXPECT_LE(length(a - b), tolerance)
      << a.x << " " << a.y << " " << a.z << " is not " << b.x << " " << b.y << " " << b.z;
}

ScenePose sampled(const Scene& scene, int clip, double time) {
  EXPECT_EQ(validate(scene), "");
  ScenePose pose;
  sample(scene, clip, time, pose);
  return pose;
}

// The grandparent moves by (10, 0, 0) and doubles, the parent turns a quarter about z, the child
// moves by (1, 0, 0).
Scene three_generations() {
  Scene scene = scene_of({test::triangle_mesh()});
  scene.nodes = {node(-1, {10, 0, 0}), node(0), node(1, {1, 0, 0})};
  scene.nodes[0].scale = vec3(2);
  scene.nodes[1].rotation = kQuarterZ;
  scene.nodes[2].mesh = 0;
  list_objects(scene);
  return scene;
}

TEST(Sample, ComposesParentsBeforeChildren) {
  const Scene scene = three_generations();
  const ScenePose pose = sampled(scene, kRestPose, 0.0);
  expect_near(pose.nodes[2][3], {10, 2, 0});
  const std::vector<vec3> p = world(scene, pose);
  expect_near(p[0], {10, 2, 0});
  expect_near(p[1], {10, 4, 0});  // 1 along the child's x is 2 along the world's y
  expect_near(p[2], {8, 2, 0});
}

TEST(Sample, ChannelsReplaceTheNodesOwnValues) {
  Scene scene = three_generations();
  scene.clips = {{"move",
                  0,
                  2,
                  {channel(0, ChannelPath::scale, 3, {0, 2}, {2, 2, 2, 4, 4, 4}),
                   channel(1, ChannelPath::rotation, 4, {0}, {0, 0, 0, 1}),
                   channel(2, ChannelPath::translation, 3, {0, 2}, {0, 0, 0, 0, 0, 6})}}};
  const std::vector<vec3> p = world(scene, sampled(scene, 0, 1.0));
  expect_near(p[0], {10, 0, 9});
  expect_near(p[1], {13, 0, 9});
  const std::vector<vec3> at_rest = world(scene, sampled(scene, kRestPose, 1.0));
  expect_near(at_rest[0], {10, 2, 0});
}

TEST(Sample, AMatrixCountsUntilAChannelMovesTheNode) {
  Scene scene = scene_of({test::triangle_mesh()});
  scene.nodes[0].has_matrix = true;
  scene.nodes[0].matrix = trs({0, 0, 7}, glm::identity<quat>(), vec3(1));
  scene.clips = {{"move", 0, 1, {channel(0, ChannelPath::translation, 3, {0}, {1, 2, 3})}}};
  expect_near(world(scene, sampled(scene, kRestPose, 0))[0], {0, 0, 7});
  expect_near(world(scene, sampled(scene, 0, 0))[0], {1, 2, 3});
}

TEST(Sample, NodeRotationsAreNormalised) {
  Scene scene = scene_of({test::triangle_mesh()});
  scene.nodes[0].rotation = quat(2 * kHalf, 0, 0, 2 * kHalf);
  expect_near(world(scene, sampled(scene, kRestPose, 0))[1], {0, 1, 0});
}

// Joint 1 rests, joint 2 turns a quarter about z around (1, 0, 0).
TEST(Sample, SkinUsesWorldJointsAndInverseBinds) {
  Scene scene = test::skinned_scene();
  scene.nodes[0].translation = vec3(100, 100, 100);  // a skinned node's own transform is ignored
  scene.nodes[1].translation = vec3(0, 0, 5);
  scene.nodes[2].translation = vec3(1, 0, 0);
  scene.nodes[2].rotation = kQuarterZ;
  scene.skins[0].inverse_bind[1] = trs({-1, 0, 0}, glm::identity<quat>(), vec3(1));
  const ScenePose pose = sampled(scene, kRestPose, 0.0);
  EXPECT_EQ(pose.objects[0].placement, identity_affine());
  const std::vector<vec3> p = world(scene, pose);
  // (0,0,0): joint 1 to (0,0,5); joint 2 turns (-1,0,0) to (0,-1,0), then to (1,-1,5).
  expect_near(p[0], {0.5f, -0.5f, 5});
  // (1,0,0): (1,0,5) and (1,0,5). (0,1,0): (0,1,5) and, from (-1,1,0) by (-1,-1,0), (0,-1,5).
  expect_near(p[1], {1, 0, 5});
  expect_near(p[2], {0, 0, 5});
}

TEST(Sample, ASkinnedBodyUnderAParentIgnoresTheParent) {
  Scene scene = test::skinned_scene();
  scene.nodes.insert(scene.nodes.begin(), node(-1, {50, 0, 0}));
  scene.nodes[1].parent = 0;
  scene.nodes[3].parent = 2;
  scene.skins[0].joints = {2, 3};
  list_objects(scene);
  expect_near(world(scene, sampled(scene, kRestPose, 0.0))[1], {1, 0, 0});
}

TEST(Sample, MorphWeightsComeFromTheMeshThenTheNodeThenTheChannel) {
  Scene scene = scene_of({test::morphed_mesh(), test::morphed_mesh()});
  scene.clips = {{"smile", 0, 1, {channel(1, ChannelPath::weights, 2, {0, 1}, {0, 0, 1, 2})}}};
  expect_near(world(scene, sampled(scene, kRestPose, 0), 0)[0], {0, 0, 0.25f});
  scene.nodes[0].weights = {0.5f, 3.0f};
  const ScenePose pose = sampled(scene, 0, 0.5);
  expect_near(world(scene, pose, 0)[0], {3, 0, 0.5f});
  expect_near(world(scene, pose, 1)[0], {1, 0, 0.5f});
}

TEST(Sample, CacheKeysAreClampedToTheCache) {
  Scene scene = scene_of({test::cached_mesh()});
  scene.clips = {{"play", 0, 4, {channel(0, ChannelPath::cache_key, 1, {0, 4}, {-1, 3})}}};
  const double times[] = {0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 9.0};
  const float moved[] = {0.0f, 0.0f, 0.5f, 1.0f, 2.0f, 3.0f, 3.0f, 3.0f};
  for (size_t i = 0; i < std::size(times); ++i) {
    const ScenePose pose = sampled(scene, 0, times[i]);
    EXPECT_TRUE(pose_fits(motion_of(scene.meshes[0], false), pose.objects[0]));
    expect_near(world(scene, pose)[0], {moved[i], 0, 0});
  }
  expect_near(world(scene, sampled(scene, kRestPose, 0.0))[0], {0, 0, 0});
}

TEST(Sample, VertexProgramsWriteThePositions) {
  Mesh mesh = test::triangle_mesh();
  mesh.vertex_program = [](double time, std::span<vec3> out) {
    for (size_t i = 0; i < out.size(); ++i) out[i] = vec3(float(time), float(i), 0);
  };
  Scene scene = scene_of({mesh, test::triangle_mesh(), mesh});
  scene.nodes[2].translation = vec3(0, 0, 1);
  const ScenePose pose = sampled(scene, kRestPose, 4.0);
  expect_near(world(scene, pose, 0)[2], {4, 2, 0});
  expect_near(world(scene, pose, 1)[1], {1, 0, 0});
  expect_near(world(scene, pose, 2)[2], {4, 2, 1});
}

TEST(Sample, HidingANodeHidesItsSubtree) {
  Scene scene = three_generations();
  scene.clips = {{"blink", 0, 2, {channel(0, ChannelPath::visibility, 1, {0, 1}, {1, 0})}}};
  scene.clips[0].channels[0].interpolation = Interpolation::step;
  ScenePose pose = sampled(scene, 0, 0.5);
  EXPECT_TRUE(pose.objects[0].present);
  pose = sampled(scene, 0, 1.5);
  EXPECT_FALSE(pose.objects[0].present);
  EXPECT_EQ(pose.visible, (std::vector<uint8_t>{0, 0, 0}));
  EXPECT_EQ(pose.absent, 0u);  // hidden on purpose
  scene.nodes[1].visible = false;
  pose = sampled(scene, kRestPose, 0.0);
  EXPECT_EQ(pose.visible, (std::vector<uint8_t>{1, 0, 0}));
  EXPECT_FALSE(pose.objects[0].present);
}

TEST(Sample, SingularPlacementsAreAbsentAndCounted) {
  Scene scene = scene_of({test::triangle_mesh(), test::triangle_mesh(), test::triangle_mesh()});
  scene.nodes[0].scale = vec3(1, 0, 1);
  scene.nodes[2].scale = vec3(1, -1, 1);  // mirrored is not singular
  const ScenePose pose = sampled(scene, kRestPose, 0.0);
  EXPECT_FALSE(pose.objects[0].present);
  EXPECT_TRUE(pose.objects[1].present);
  EXPECT_TRUE(pose.objects[2].present);
  EXPECT_EQ(pose.absent, 1u);
}

TEST(Sample, WhatIsNotFiniteIsAbsentAndCounted) {
  Scene scene = three_generations();
  scene.nodes[0].scale = scene.nodes[1].scale = vec3(1e30f);  // their product overflows
  EXPECT_EQ(sampled(scene, kRestPose, 0.0).absent, 1u);

  scene = test::skinned_scene();
  scene.nodes[1].scale = scene.nodes[2].scale = vec3(1e30f);
  ScenePose pose = sampled(scene, kRestPose, 0.0);
  EXPECT_FALSE(pose.objects[0].present);
  EXPECT_EQ(pose.absent, 1u);
  scene.nodes[1].scale = scene.nodes[2].scale = vec3(0);  // a skin may shrink to a point
  EXPECT_TRUE(sampled(scene, kRestPose, 0.0).objects[0].present);

  scene = scene_of({test::morphed_mesh()});
  const float huge = 3e38f;
  scene.clips = {{"burst",
                  0,
                  1,
                  {{0,
                    ChannelPath::weights,
                    Interpolation::cubic_spline,
                    2,
                    {0, 100},
                    {0, 0, 0, 0, huge, huge, -huge, -huge, 0, 0, 0, 0}}}}};
  EXPECT_EQ(sampled(scene, 0, 50.0).absent, 1u);
}

// Spans keep their place and arrays their storage: nothing is allocated after the first call.
TEST(Sample, ReusesItsStorage) {
  Mesh free = test::triangle_mesh();
  free.vertex_program = [](double, std::span<vec3> out) { std::ranges::fill(out, vec3(1)); };
  Scene scene = test::skinned_scene();
  scene.meshes.push_back(test::morphed_mesh());
  scene.meshes.push_back(free);
  for (const int32_t mesh : {1, 2}) {
    scene.nodes.push_back(node(0));
    scene.nodes.back().mesh = mesh;
  }
  list_objects(scene);
  scene.clips = {{"move",
                  0,
                  1,
                  {channel(2, ChannelPath::rotation, 4, {0, 1}, {0, 0, 0, 1, 1, 0, 0, 0}),
                   channel(3, ChannelPath::weights, 2, {0, 1}, {0, 0, 1, 1})}}};
  ScenePose pose = sampled(scene, 0, 0.0);
  const auto storage = [&] {
    return std::vector<const void*>{pose.nodes.data(),
                                    pose.visible.data(),
                                    pose.objects.data(),
                                    pose.local.data(),
                                    pose.joints.data(),
                                    pose.weights.data(),
                                    pose.free.data(),
                                    pose.skin_begin.data(),
                                    pose.objects[0].joints.data(),
                                    pose.objects[1].weights.data(),
                                    pose.objects[2].positions.data()};
  };
  const std::vector<const void*> before = storage();
  for (int i = 0; i < 10; ++i) sample(scene, i % 2 == 0 ? 0 : kRestPose, 0.1 * i, pose);
  EXPECT_EQ(storage(), before);
  const ScenePose moved = std::move(pose);  // spans must survive a move
  EXPECT_EQ(moved.objects[0].joints.data(), moved.joints.data());
}

TEST(Sample, ServesAnotherSceneWithTheSameObject) {
  ScenePose pose;
  const Scene large = test::skinned_scene(), small = scene_of({test::morphed_mesh()});
  sample(large, kRestPose, 0.0, pose);
  sample(small, kRestPose, 0.0, pose);
  ASSERT_EQ(pose.objects.size(), 1u);
  EXPECT_TRUE(pose.objects[0].joints.empty());
  expect_near(world(small, pose)[0], {0, 0, 0.25f});
}

}  // namespace
}  // namespace sinew
