// Motions by a mesh's data, counts and objects.
#include "sinew/scene/scene.h"

#include <gtest/gtest.h>

#include "scene/small_scenes.h"

namespace sinew {
namespace {

using test::scene_of;

TEST(MotionOf, FollowsTheMeshData) {
  EXPECT_TRUE(std::holds_alternative<RigidMotion>(motion_of(test::triangle_mesh(), false)));
  EXPECT_TRUE(std::holds_alternative<RigidMotion>(motion_of(test::triangle_mesh(), true)));
  EXPECT_TRUE(std::holds_alternative<KeyframeMotion>(motion_of(test::cached_mesh(), false)));

  Mesh skinned = test::skinned_mesh();
  EXPECT_TRUE(std::holds_alternative<RigidMotion>(motion_of(skinned, false)));
  const Motion skin = motion_of(skinned, true);
  ASSERT_TRUE(std::holds_alternative<SkinMotion>(skin));
  EXPECT_EQ(std::get<SkinMotion>(skin).joint_count, 2u);

  Mesh both = test::morphed_mesh();
  EXPECT_EQ(std::get<MorphMotion>(motion_of(both, true)).skin.influences, 0u);
  both.influences = 2;
  both.joints = skinned.joints;
  both.weights = skinned.weights;
  EXPECT_EQ(std::get<MorphMotion>(motion_of(both, true)).skin.influences, 2u);
  EXPECT_EQ(std::get<MorphMotion>(motion_of(both, false)).skin.influences, 0u);

  both.vertex_program = [](double, std::span<vec3>) {};
  EXPECT_TRUE(std::holds_alternative<FreeMotion>(motion_of(both, true)));
}

TEST(MotionOf, IsValidForEveryMesh) {
  for (const Mesh& mesh : {test::triangle_mesh(), test::skinned_mesh(), test::morphed_mesh(),
                           test::cached_mesh(), Mesh{}}) {
    EXPECT_EQ(validate(motion_of(mesh, true)), "");
    EXPECT_EQ(vertex_count(motion_of(mesh, true)), mesh.positions.size());
  }
}

TEST(Scene, ListsNodesWithMeshesAndTheirSkins) {
  Scene scene = test::skinned_scene();
  scene.meshes.push_back(test::triangle_mesh());
  scene.nodes.push_back(test::node(-1));
  scene.nodes[3].mesh = 1;
  scene.nodes[3].skin = 0;  // without joints in the mesh there is nothing to skin
  list_objects(scene);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[0].skin, 0);
  EXPECT_EQ(scene.objects[1].node, 3u);
  EXPECT_EQ(scene.objects[1].mesh, 1u);
  EXPECT_EQ(scene.objects[1].skin, -1);
}

TEST(Scene, CountsEachInstance) {
  Scene scene = scene_of({test::triangle_mesh(), test::morphed_mesh()});
  scene.nodes.push_back(test::node(-1));
  scene.nodes.back().mesh = 0;
  scene.skins = {{"a", {0, 1}, {}}, {"b", {0}, {}}};
  list_objects(scene);
  const SceneCounts counts = count(scene);
  EXPECT_EQ(counts.triangles, 3u);
  EXPECT_EQ(counts.vertices, 9u);
  EXPECT_EQ(counts.joints, 3u);
  EXPECT_EQ(counts.morphs, 2u);
}

}  // namespace
}  // namespace sinew
