// Prepared worlds of voxelised scenes: times, picks, update modes, crowds.
#include <gtest/gtest.h>

#include "sinew/render/voxelize_scene.h"
#include "sinew/scene/study.h"
#include "world/voxel_worlds.h"

namespace sinew {
namespace {

Scene voxelised(const char* spec, uint32_t resolution, std::vector<uint8_t> chosen = {}) {
  const Scene scene = *make_study_scene(spec);
  VoxelizeSceneOptions options;
  options.resolution = resolution;
  options.chosen = std::move(chosen);
  return std::move(voxelize_scene(scene, options)->scene);
}

// 1 for each skinned object.
std::vector<uint8_t> skinned(const Scene& scene) {
  std::vector<uint8_t> out;
  for (const SceneObject& object : scene.objects) out.push_back(object.skin >= 0);
  return out;
}

Box voxel_box(const World& world) {
  Box box;
  for (const ObjectId id : world.voxel_objects()) {
    const VoxelInstance instance = *world.voxel_instance(id);
    box.extend(transform_box(instance.placement, instance.posed->bounds(0)));
  }
  return box;
}

std::vector<Hit> hits_of(const World& world, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  world.closest_hits(rays, hits);
  return hits;
}

TEST(WorldVoxelScene, ObjectsOfTrianglesComeFirst) {
  const Scene source = *make_study_scene("creature,triangles=8000");
  const Scene scene = voxelised("creature,triangles=8000", 96, skinned(source));
  ASSERT_GT(scene.voxels.size(), 0u);
  ASSERT_GT(scene.objects.size(), 0u);
  World world = *prepare(scene);
  const auto voxels = static_cast<ObjectId>(scene.objects.size());
  for (ObjectId i = 0; i < voxels; ++i) EXPECT_FALSE(world.has_voxels(i));
  EXPECT_TRUE(world.has_voxels(voxels));
  ASSERT_TRUE(world.set_time(0.3));
  EXPECT_EQ(world.placement(voxels), world.pose().voxels[0].placement);
  EXPECT_EQ(world.validate(), "");
  size_t of_voxels = 0, of_triangles = 0;
  for (const Hit& hit : hits_of(world, test::rays_about(voxel_box(world), 2000, 3))) {
    if (!hit) continue;
    ASSERT_LT(hit.object, voxels + scene.voxels.size());
    ++(hit.object >= voxels ? of_voxels : of_triangles);
  }
  EXPECT_GT(of_voxels, 100u);
  EXPECT_GT(of_triangles, 100u);
}

// The voxel that a pick names lies where it was met, and the joints are those of the triangles
// there.
TEST(WorldVoxelScene, APickNamesTheVoxelAndItsJoints) {
  const Scene source = *make_study_scene("creature,triangles=20000");
  const Scene scene = voxelised("creature,triangles=20000", 128, skinned(source));
  World world = *prepare(scene), triangles = *prepare(source);
  ASSERT_TRUE(world.set_time(0.4) && triangles.set_time(0.4));
  const auto voxels = static_cast<ObjectId>(scene.objects.size());
  size_t picks = 0, compared = 0, same_joint = 0;
  for (const Ray& ray : test::rays_about(voxel_box(world), 1500, 37)) {
    const auto pick = world.pick(ray);
    if (!pick) continue;
    EXPECT_EQ(bool{pick->voxel}, pick->hit.object >= voxels);
    if (!pick->voxel) continue;
    ++picks;
    const Svo& svo = scene.octrees[scene.voxels[pick->hit.object - scene.objects.size()].octree];
    const PickedVoxel& voxel = *pick->voxel;
    EXPECT_EQ(voxel.level, 0u);
    EXPECT_EQ(voxel.rest.side, 1u);
    EXPECT_LT(length(voxel.rest.middle - svo.grid.center(voxel.rest.place)), 1e-4f);
    const VoxelSample sample = world.sample_voxel(pick->hit);
    EXPECT_EQ(sample.unit, voxel.cell);
    EXPECT_EQ(sample.material, voxel.material);
    // A stretched voxel is longer than one at rest.
    EXPECT_LT(length(sample.position - pick->point), 12.0f * sample.size);
    EXPECT_EQ(pick->joints.empty(), svo.joints == 0);
    float sum = 0.0f, last = 2.0f;
    for (const JointWeight& j : pick->joints) {
      EXPECT_LT(j.joint, svo.joints);
      EXPECT_LE(j.weight, last);
      last = j.weight;
      sum += j.weight;
    }
    if (pick->joints.empty()) continue;
    EXPECT_NEAR(sum, 1.0f, 1e-4f);
    const auto twin = triangles.pick(ray);
    if (!twin || twin->joints.empty() || length(twin->point - pick->point) > 4.0f * sample.size) {
      continue;
    }
    ++compared;
    same_joint += std::ranges::any_of(
        twin->joints, [&](const JointWeight& j) { return j.joint == pick->joints.front().joint; });
  }
  EXPECT_GT(picks, 100u);
  EXPECT_GT(compared, 60u);
  EXPECT_GT(same_joint, compared * 9 / 10);
}

TEST(WorldVoxelScene, SameHitsInEveryUpdateModeAndTopTree) {
  const Scene source = *make_study_scene("bodies,subdivisions=3,motion=free");
  std::vector<uint8_t> chosen(source.objects.size(), 0);
  for (size_t i = 0; i < chosen.size(); i += 2) chosen[i] = 1;
  for (const Scene& scene :
       {voxelised("bodies,subdivisions=3", 64, chosen), voxelised("creature,triangles=8000", 96)}) {
    std::vector<Ray> rays;
    std::vector<Hit> expected;
    for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
      for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
        World world = *prepare(scene, {.update = mode, .top_tree = top});
        ASSERT_TRUE(world.set_time(0.2));
        if (rays.empty()) rays = test::rays_about(world.box(), 1500, 5);
        hits_of(world, rays);
        ASSERT_TRUE(world.set_time(0.6));
        const std::vector<Hit> hits = hits_of(world, rays);
        if (expected.empty()) expected = hits;
        EXPECT_TRUE(test::same_hits(hits, expected)) << name_of(mode);
      }
    }
    EXPECT_TRUE(std::ranges::any_of(
        expected, [&](const Hit& h) { return h && h.object >= scene.objects.size(); }));
  }
}

// A crowd of one octree, each in its own pose: every one is hit where it would be alone.
TEST(WorldVoxelScene, ACrowdIsHitAsEachAlone) {
  const Scene scene = voxelised("creature,triangles=8000", 64);
  const Svo& svo = scene.octrees[0];
  constexpr uint32_t kCount = 9;
  World crowd;
  const BodyId body = *crowd.add_octree({&svo});
  std::vector<ScenePose> poses(kCount);
  std::vector<Affine> places;
  for (uint32_t i = 0; i < kCount; ++i) {
    sample(scene, 0, 0.11 * i, poses[i]);
    Pose pose = poses[i].voxels[0];
    places.push_back(
        trs(vec3(1.5f * static_cast<float>(i % 3), 0, 1.5f * static_cast<float>(i / 3)),
            glm::angleAxis(0.3f * static_cast<float>(i), vec3(0, 1, 0)), vec3(1)));
    pose.placement = places.back();
    ASSERT_TRUE(crowd.set_pose(*crowd.add_object(body), pose));
  }
  crowd.commit();
  EXPECT_EQ(crowd.stats().octrees_posed, kCount);
  const std::vector<Ray> rays = test::rays_about(crowd.box(), 1500, 21);
  const std::vector<Hit> hits = hits_of(crowd, rays);
  std::vector<Hit> nearest(rays.size());
  for (uint32_t i = 0; i < kCount; ++i) {
    World alone;
    Pose pose = poses[i].voxels[0];
    pose.placement = places[i];
    ASSERT_TRUE(alone.set_pose(*alone.add_object(*alone.add_octree({&svo, pose})), pose));
    alone.commit();
    const std::vector<Hit> own = hits_of(alone, rays);
    for (size_t k = 0; k < rays.size(); ++k) {
      if (!own[k] || !(own[k].t < nearest[k].t)) continue;
      nearest[k] = own[k];
      nearest[k].object = i;
    }
  }
  EXPECT_TRUE(test::same_hits(hits, nearest));
  EXPECT_GT(std::ranges::count_if(hits, [](const Hit& h) { return bool{h}; }), 300);
}

}  // namespace
}  // namespace sinew
