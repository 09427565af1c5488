// Voxel objects in a scene: what is valid, and where they are.
#include <gtest/gtest.h>

#include <functional>

#include "scene/small_scenes.h"
#include "sinew/scene/sample.h"
#include "sinew/svo/posed.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

using test::channel;
using test::node;

// Node 0 shows a plain octree, node 1 one with five joints (nodes 2 to 6), node 7 a triangle.
Scene voxel_scene() {
  Scene scene;
  scene.materials.resize(3);
  scene.octrees = {test::plain_octree(30, 300, 3, 5), test::moving_octree(20, 200, 3)};
  scene.meshes = {test::triangle_mesh()};
  for (int i = 0; i < 8; ++i) scene.nodes.push_back(node(i >= 3 && i < 7 ? 2 : -1));
  scene.nodes[0].octree = 0;
  scene.nodes[1].octree = 1;
  scene.nodes[1].skin = 0;
  scene.nodes[1].weights = {0.5f, 1.0f};
  scene.nodes[7].mesh = 0;
  scene.skins = {{"bones", {2, 3, 4, 5, 6}, std::vector<Affine>(5, identity_affine())}};
  scene.clips = {{"move",
                  0,
                  1,
                  {channel(0, ChannelPath::rotation, 4, {0, 1}, {0, 0, 0, 1, 0.6f, 0, 0.8f, 0}),
                   channel(3, ChannelPath::translation, 3, {0, 1}, {0, 0, 0, 5, 0, 0}),
                   channel(1, ChannelPath::weights, 2, {0, 1}, {0, 0, 0.25f, -0.125f})}}};
  list_objects(scene);
  return scene;
}

TEST(SceneVoxels, SoundScenesAreValid) {
  EXPECT_EQ(validate(voxel_scene()), "");
  EXPECT_EQ(count(voxel_scene()).voxels,
            voxel_scene().octrees[0].voxel_count() + voxel_scene().octrees[1].voxel_count());
}

TEST(SceneVoxels, EachFaultIsFound) {
  using Break = std::function<void(Scene&)>;
  const std::vector<Break> breaks = {
      [](Scene& s) { s.materials.resize(1); },
      [](Scene& s) { s.octrees[1].cells[0].voxels ^= 1; },
      [](Scene& s) { s.nodes[0].octree = 2; },
      [](Scene& s) { s.nodes[7].octree = 0, list_objects(s); },
      [](Scene& s) { s.voxels.pop_back(); },
      [](Scene& s) { s.voxels[0].octree = 1; },
      [](Scene& s) { s.voxels[0].node = 99; },
      [](Scene& s) { std::swap(s.voxels[0], s.voxels[1]); },
      [](Scene& s) { s.voxels[1].skin = -1; },
      [](Scene& s) { s.voxels[0].skin = 0; },
      [](Scene& s) { s.nodes[1].skin = -1, list_objects(s); },
      [](Scene& s) { s.skins[0].joints.pop_back(), s.skins[0].inverse_bind.pop_back(); },
      [](Scene& s) { s.nodes[1].weights = {0.5f}; },
      [](Scene& s) { s.clips[0].channels[2].node = 0; },
  };
  for (size_t i = 0; i < breaks.size(); ++i) {
    Scene scene = voxel_scene();
    breaks[i](scene);
    EXPECT_NE(validate(scene), "") << "fault " << i;
  }
}

// The box of all corners of all voxels, each moved alone.
Box brute_force_box(const Scene& scene, const ScenePose& pose) {
  Box box;
  for (size_t i = 0; i < scene.voxels.size(); ++i) {
    const Svo& svo = scene.octrees[scene.voxels[i].octree];
    const SvoMotion motion = make_svo_motion(svo);
    PosedSvo posed;
    posed.set_pose(motion, pose.voxels[i]);
    for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
    for (const test::ReadVoxel& voxel : test::read_voxels(svo)) {
      const vec3 low = vec3(place_of(voxel.code).min);
      for (int k = 0; k < 8; ++k) {
        const vec3 local = (low + vec3(k & 1, k >> 1 & 1, k >> 2)) / float(kCellSide);
        const vec3 p = map_point(svo.cells[voxel.cell], posed.block(voxel.block), local);
        box.extend(transform_point(pose.voxels[i].placement, p));
      }
    }
  }
  return box;
}

// Extents of cells are at least as large, and little larger: cells bend.
TEST(SceneVoxels, BoundsAreThoseOfTheVoxels) {
  Scene scene = voxel_scene();
  scene.nodes[7].mesh = -1;
  list_objects(scene);
  ScenePose pose;
  Box expected;
  for (const double time : {0.0, 0.5, 1.0}) {
    sample(scene, 0, time, pose);
    expected.extend(brute_force_box(scene, pose));
  }
  const Box box = animation_bounds(scene, 0, 3);
  const float slack = 0.05f * length(expected.extent());
  for (int k = 0; k < 3; ++k) {
    EXPECT_LE(box.min[k], expected.min[k] + 1e-4f);
    EXPECT_GE(box.max[k], expected.max[k] - 1e-4f);
    EXPECT_GE(box.min[k], expected.min[k] - slack);
    EXPECT_LE(box.max[k], expected.max[k] + slack);
  }
}

TEST(SceneVoxels, BoundsLeaveOutWhatIsHidden) {
  Scene scene = voxel_scene();
  scene.nodes[0].visible = scene.nodes[1].visible = false;
  const Box box = animation_bounds(scene, kRestPose, 1);
  EXPECT_EQ(box.min, vec3(0.0f));
  EXPECT_EQ(box.max, vec3(1.0f, 1.0f, 0.0f));
}

}  // namespace
}  // namespace sinew
