// Real glTF files, against the counts that their README states.
#include "sinew/io/gltf/gltf.h"
#include "test_data.h"

namespace sinew {
namespace {

Scene load_valid(const std::string& path) {
  Result<Scene> scene = load_gltf(path);
  if (!scene) {
    ADD_FAILURE() << scene.error().message();
    return {};
  }
  EXPECT_EQ(validate(*scene), "");
  return std::move(*scene);
}

TEST(GltfFiles, PigMan) {
  SINEW_DATA_OR_SKIP(path, "skinned/pigman/pigman.glb");
  const Scene scene = load_valid(path);
  const SceneCounts counts = count(scene);
  EXPECT_EQ(counts.triangles, 37136u);
  EXPECT_EQ(counts.vertices, 27754u);
  EXPECT_EQ(counts.joints, 103u);
  EXPECT_EQ(scene.clips.size(), 4u);
  EXPECT_TRUE(scene.images.empty());
}

TEST(GltfFiles, LittlestTokyo) {
  SINEW_DATA_OR_SKIP(path, "skinned/littlest-tokyo/LittlestTokyo.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(count(scene).triangles, 141802u);
  EXPECT_EQ(count(scene).joints, 32u);
  EXPECT_EQ(scene.nodes.size(), 214u);
  ASSERT_EQ(scene.clips.size(), 1u);
  EXPECT_EQ(scene.clips[0].channels.size(), 96u);
  EXPECT_EQ(scene.clips[0].end, 10.0);
  EXPECT_EQ(scene.images.size(), 4u);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfFiles, RobotExpressive) {
  SINEW_DATA_OR_SKIP(path, "skinned/robot-expressive/RobotExpressive.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(count(scene).triangles, 3237u);
  EXPECT_EQ(count(scene).joints, 43u);  // both hands have the same skin
  EXPECT_EQ(count(scene).morphs, 3u);
  EXPECT_EQ(scene.clips.size(), 14u);
}

TEST(GltfFiles, EmojiHeart) {
  SINEW_DATA_OR_SKIP(path, "skinned/emoji-heart/emoji_heart.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(count(scene).triangles, 19008u);
  EXPECT_EQ(count(scene).joints, 19u);
  EXPECT_EQ(scene.clips.size(), 3u);
  EXPECT_GE(scene.materials.at(0).base_color_texture.image, 0);
  EXPECT_GE(scene.materials.at(0).metallic_roughness_texture.image, 0);
}

TEST(GltfFiles, RecursiveSkeletons) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/RecursiveSkeletons/glTF-Binary/RecursiveSkeletons.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(scene.skins.size(), 84u);
  EXPECT_EQ(scene.nodes.size(), 924u);
  EXPECT_EQ(scene.objects.size(), 84u);
  EXPECT_EQ(scene.meshes.size(), 1u);  // shared
}

TEST(GltfFiles, MetalRoughSpheres) {
  SINEW_DATA_OR_SKIP(
      path, "khronos-gltf/MetalRoughSpheresNoTextures/glTF-Binary/MetalRoughSpheresNoTextures.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(count(scene).triangles, 1040409u);
}

TEST(GltfFiles, DreamApartment) {
  SINEW_DATA_OR_SKIP(path, "static/dream-apartment/dream-apartment.glb");
  EXPECT_EQ(count(load_valid(path)).triangles, 177934u);
}

TEST(GltfFiles, SimpleInstancing) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/SimpleInstancing/glTF-Binary/SimpleInstancing.glb");
  const Scene scene = load_valid(path);
  EXPECT_EQ(scene.objects.size(), 125u);
  EXPECT_EQ(count(scene).triangles, 125u * 12u);
}

TEST(GltfFiles, SparseAccessorMovesThreeVertices) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf");
  const Mesh mesh = load_valid(path).meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 14u);
  EXPECT_EQ(mesh.positions[7], vec3(0, 1, 0));
  EXPECT_EQ(mesh.positions[8], vec3(1, 2, 0));  // the three replaced ones
  EXPECT_EQ(mesh.positions[10], vec3(3, 3, 0));
  EXPECT_EQ(mesh.positions[12], vec3(5, 4, 0));
  EXPECT_EQ(mesh.positions[13], vec3(6, 1, 0));
}

TEST(GltfFiles, InterpolationTestHasAllThreeKinds) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/InterpolationTest/glTF-Binary/InterpolationTest.glb");
  const Scene scene = load_valid(path);
  ASSERT_EQ(scene.clips.size(), 9u);
  EXPECT_EQ(scene.clips[0].channels.at(0).interpolation, Interpolation::step);
  EXPECT_EQ(scene.clips[1].channels.at(0).interpolation, Interpolation::linear);
  EXPECT_EQ(scene.clips[2].channels.at(0).interpolation, Interpolation::cubic_spline);
}

TEST(GltfFiles, AllSampleAssetsLoad) {
  SINEW_DATA_OR_SKIP(folder, "khronos-gltf");
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".gltf" && extension != ".glb") continue;
    SCOPED_TRACE(entry.path().string());
    EXPECT_FALSE(load_valid(entry.path().string()).objects.empty());
    ++files;
  }
  EXPECT_EQ(files, 20);
}

}  // namespace
}  // namespace sinew
