// .svo files: octrees and the scene around them come back, or nothing does.
#include "sinew/io/svo/svo.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "io/hostile.h"
#include "scene/small_scenes.h"
#include "sinew/io/load.h"
#include "sinew/io/save.h"
#include "sinew/scene/sample.h"
#include "sinew/svo/file/stream.h"
#include "svo/test_octrees.h"

namespace sinew {
namespace {

using test::channel;
using test::node;

Image8 small_image() {
  Image8 image;
  image.width = image.height = 2;
  image.pixels.assign(16, 200);
  return image;
}

// A body of voxels with joints and morph targets, a pillar twice, a triangle; nodes depth first.
Scene voxel_scene() {
  Scene scene;
  scene.name = "voxels";
  scene.octrees = {test::moving_octree(40, 800, 3), test::plain_octree(20, 200, 3, 5)};
  scene.materials.resize(4);
  scene.materials[1].name = "steel";
  scene.materials[1].metallic = 0.75f;
  scene.materials[2].emissive = vec3(2.0f, 1.0f, 0.5f);
  scene.materials[0].base_color_texture.image = 0;
  scene.materials[3].base_color_texture.image = 1;
  scene.images = {small_image(), small_image()};
  scene.meshes = {test::triangle_mesh()};
  scene.meshes[0].parts[0].material = 3;
  scene.meshes[0].texcoords[0] = {{0, 0}, {1, 0}, {0, 1}};

  scene.nodes = {node(-1, {1, 2, 3}),
                 node(0),
                 node(1, {0, 1, 0}),
                 node(2, {0, 0.5f, 0}),
                 node(2),
                 node(1),
                 node(0, {5, 0, 0}),
                 node(6, {0, 3, 0}),
                 node(-1),
                 node(-1)};
  const char* const names[] = {"root", "hip",    "spine",   "head", "arm",
                               "leg",  "pillar", "capital", "body", "triangle"};
  for (size_t i = 0; i < scene.nodes.size(); ++i) scene.nodes[i].name = names[i];
  scene.nodes[0].rotation = normalize(quat(0.9f, 0.1f, 0.3f, 0.2f));
  scene.nodes[6].octree = scene.nodes[7].octree = 1;
  scene.nodes[6].visible = false;
  scene.nodes[8].octree = 0;
  scene.nodes[8].skin = 0;
  scene.nodes[8].weights = {0.5f, -0.25f};
  scene.nodes[9].mesh = 0;
  scene.nodes[0].camera = 0;
  scene.nodes[4].light = 0;
  scene.skins = {{"bones", {1, 2, 3, 4, 5}, std::vector<Affine>(5, identity_affine())}};
  for (size_t j = 0; j < 5; ++j)
    scene.skins[0].inverse_bind[j][3] = vec3(0.1f * float(j), -1, 0.3f);
  scene.cameras.resize(1);
  scene.lights.resize(1);
  scene.lights[0].type = LightType::point;
  scene.lights[0].falloff = false;
  scene.lights[0].intensity = 3.0f;
  scene.environment.ambient = vec3(0.125f);
  scene.default_fps = 25.0;
  scene.clips = {
      {"walk",
       0,
       2,
       {channel(2, ChannelPath::rotation, 4, {0, 1, 2}, {0, 0, 0, 1, 0.6f, 0, 0.8f, 0, 0, 0, 0, 1}),
        channel(8, ChannelPath::weights, 2, {0, 2}, {0, 1, 1, 0}),
        channel(7, ChannelPath::translation, 3, {0.5f, 1}, {0, 3, 0, 0, 4, 0})}},
      {"still", 0, 1, {channel(8, ChannelPath::weights, 2, {0, 1}, {0, 0, 0.5f, 0.5f})}}};
  scene.clips[0].channels.push_back(channel(6, ChannelPath::visibility, 1, {0, 1}, {0, 1}));
  scene.clips[0].channels.back().interpolation = Interpolation::step;
  list_objects(scene);
  return scene;
}

SavedSvo saved(const Scene& scene, const std::string& path) {
  const Result<SavedSvo> result = save_svo(scene, path, {.effort = 3});
  EXPECT_TRUE(result) << result.error().message();
  return result.value_or(SavedSvo{});
}

void expect_same_poses(const Scene& before, const Scene& after, int clip, double time) {
  ScenePose a, b;
  sample(before, clip, time, a);
  sample(after, clip, time, b);
  ASSERT_EQ(a.voxels.size(), b.voxels.size());
  for (size_t i = 0; i < a.voxels.size(); ++i) {
    const Pose &x = a.voxels[i], &y = b.voxels[i];
    EXPECT_EQ(x.present, y.present);
    ASSERT_EQ(x.joints.size(), y.joints.size());
    ASSERT_EQ(x.weights.size(), y.weights.size());
    for (size_t k = 0; k < x.weights.size(); ++k) EXPECT_EQ(x.weights[k], y.weights[k]);
    for (int c = 0; c < 4; ++c) {
      EXPECT_LT(length(x.placement[c] - y.placement[c]), 1e-6f);
      for (size_t j = 0; j < x.joints.size(); ++j) {
        EXPECT_LT(length(x.joints[j][c] - y.joints[j][c]), 1e-5f);
      }
    }
  }
}

TEST(Svo, ComesBackWithItsScene) {
  const TemporaryFolder folder;
  const Scene scene = voxel_scene();
  ASSERT_EQ(validate(scene), "");
  const SavedSvo report = saved(scene, folder.path("a.svo"));
  EXPECT_EQ(report.bytes, std::filesystem::file_size(folder.path("a.svo")));
  EXPECT_EQ(report.voxels, scene.octrees[0].voxel_count() + scene.octrees[1].voxel_count());
  EXPECT_TRUE(report.warnings.empty()) << report.warnings[0];
  uint64_t sum = 0;
  for (const SvoPart& part : report.parts) sum += part.bytes;
  EXPECT_EQ(sum, report.bytes);

  const Result<Scene> loaded = load(folder.path("a.svo"));
  ASSERT_TRUE(loaded) << loaded.error().message();
  const Scene& again = *loaded;
  EXPECT_TRUE(again.warnings.empty()) << again.warnings[0];
  ASSERT_EQ(again.octrees.size(), 2u);
  EXPECT_TRUE(is_same(again.octrees[0], scene.octrees[0]));
  EXPECT_TRUE(is_same(again.octrees[1], scene.octrees[1]));
  ASSERT_EQ(again.nodes.size(), scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].name, scene.nodes[i].name);
    EXPECT_EQ(again.nodes[i].octree, scene.nodes[i].octree);
    EXPECT_EQ(again.nodes[i].skin, scene.nodes[i].skin);
  }
  ASSERT_EQ(again.materials.size(), 4u);
  EXPECT_EQ(again.materials[1].metallic, 0.75f);
  EXPECT_EQ(again.materials[2].emissive, scene.materials[2].emissive);
  EXPECT_EQ(again.skins[0].joints, scene.skins[0].joints);
  EXPECT_EQ(again.cameras.size(), 1u);
  EXPECT_FALSE(again.lights.at(0).falloff);
  EXPECT_EQ(again.environment.ambient, scene.environment.ambient);
  EXPECT_EQ(again.default_fps, 25.0);
  ASSERT_EQ(again.clips.size(), 2u);
  EXPECT_EQ(again.clips[0].name, "walk");
  for (const int clip : {kRestPose, 0, 1}) {
    for (const double time : {0.0, 0.3, 0.75, 1.0, 1.9})
      expect_same_poses(scene, again, clip, time);
  }
}

// Only triangle objects have textures.
TEST(Svo, LeavesOutWhatVoxelsDoNotNeed) {
  const TemporaryFolder folder;
  Scene scene = voxel_scene();
  saved(scene, folder.path("a.svo"));
  const Scene with_triangle = *load(folder.path("a.svo"));
  EXPECT_EQ(with_triangle.images.size(), 1u);
  EXPECT_EQ(with_triangle.materials[0].base_color_texture.image, -1);
  EXPECT_EQ(with_triangle.materials[3].base_color_texture.image, 0);
  EXPECT_EQ(with_triangle.objects.size(), 1u);

  scene.nodes[9].mesh = -1;
  list_objects(scene);
  saved(scene, folder.path("b.svo"));
  const Scene voxels = *load(folder.path("b.svo"));
  EXPECT_TRUE(voxels.images.empty());
  EXPECT_TRUE(voxels.meshes.empty());
  EXPECT_EQ(voxels.materials.size(), 4u);
}

TEST(Svo, WarnsOfVertexCaches) {
  const TemporaryFolder folder;
  Scene scene = voxel_scene();
  scene.meshes[0] = test::cached_mesh();
  scene.meshes[0].name = "cloth";
  scene.clips[0].channels.push_back(channel(9, ChannelPath::cache_key, 1, {0, 1}, {0, 2}));
  ASSERT_EQ(validate(scene), "");
  const SavedSvo report = saved(scene, folder.path("a.svo"));
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("cloth"), std::string::npos);
  const Scene again = *load(folder.path("a.svo"));
  EXPECT_TRUE(again.objects.empty());
  EXPECT_EQ(again.voxels.size(), 3u);
}

TEST(Svo, ScenesWithoutVoxelsAndOtherNamesAreRefused) {
  const TemporaryFolder folder;
  const Result<SavedSvo> none = save_svo(test::skinned_scene(), folder.path("a.svo"));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::bad_input);
  const Result<SavedSvo> name = save_svo(voxel_scene(), folder.path("a.glb"));
  ASSERT_FALSE(name);
  EXPECT_EQ(name.error().kind, ErrorKind::usage);
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Svo, GltfLeavesOctreesOut) {
  const TemporaryFolder folder;
  const Result<SaveReport> report = save_gltf(voxel_scene(), folder.path("a.glb"));
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_TRUE(std::ranges::any_of(report->warnings, [](const std::string& warning) {
    return warning.starts_with("octree 'moving' and 1 more: left out");
  }));
  const Result<Scene> again = load(folder.path("a.glb"));
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->voxels.empty());
  EXPECT_EQ(again->objects.size(), 1u);
}

TEST(Svo, EveryTruncationAndEveryFlippedBitIsRefused) {
  const TemporaryFolder folder;
  Scene scene;
  scene.octrees = {test::plain_octree(3, 4, 1, 1)};
  scene.materials.resize(1);
  scene.nodes.resize(1);
  scene.nodes[0].octree = 0;
  list_objects(scene);
  saved(scene, folder.path("a.svo"));
  std::string bytes = slurp(folder.path("a.svo"));
  const auto parse = [](const std::string& text) {
    return parse_svo({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, "a.svo", {});
  };
  ASSERT_TRUE(parse(bytes));
  const auto expect_refused = [&](const std::string& text) {
    const Result<Scene> result = parse(text);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(result.error().file, "a.svo");
    EXPECT_FALSE(result.error().problem.empty());
  };
  for_every_truncation(bytes, expect_refused);
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    SCOPED_TRACE("bit " + std::to_string(bit));
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    expect_refused(bytes);
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
  }
}

TEST(Svo, RespectsTheMemoryLimit) {
  const TemporaryFolder folder;
  saved(voxel_scene(), folder.path("a.svo"));
  const Result<Scene> result = load(folder.path("a.svo"), {.memory_limit = 20'000});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
  EXPECT_NE(result.error().message().find("allowed"), std::string::npos)
      << result.error().message();
}

// With --voxel-memory: the same scene, whose octrees come when they are asked for.
TEST(Svo, ComesByBlocks) {
  const TemporaryFolder folder;
  const Scene scene = voxel_scene();
  saved(scene, folder.path("a.svo"));
  const Result<Scene> whole = load(folder.path("a.svo"));
  ASSERT_TRUE(whole);
  Result<Scene> paged = load(folder.path("a.svo"), {.voxel_memory = uint64_t{1} << 28});
  ASSERT_TRUE(paged) << paged.error().message();
  EXPECT_EQ(validate(*paged), "");
  ASSERT_EQ(paged->octrees.size(), 2u);
  EXPECT_EQ(paged->nodes.size(), whole->nodes.size());
  for (size_t i = 0; i < 2; ++i) {
    const Svo& svo = paged->octrees[i];
    ASSERT_TRUE(svo.paging);
    for (uint32_t b = 0; b < svo.block_count(); ++b) svo.paging->request(b, 1.0f);
    svo.paging->settle();
    EXPECT_TRUE(is_same(svo, whole->octrees[i]));
  }
}

TEST(Svo, TooLittleVoxelMemoryIsRefused) {
  const TemporaryFolder folder;
  saved(voxel_scene(), folder.path("a.svo"));
  const Result<Scene> result = load(folder.path("a.svo"), {.voxel_memory = 1000});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
  EXPECT_NE(result.error().message().find("at least"), std::string::npos);
  // The remedy's number works.
  const std::string& text = result.error().remedy;
  const size_t at = text.find("--voxel-memory ");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_TRUE(load(folder.path("a.svo"), {.voxel_memory = std::stoull(text.substr(at + 15))}));
}

TEST(Svo, EveryTruncationIsRefusedByBlocksToo) {
  const TemporaryFolder folder;
  Scene scene;
  scene.octrees = {test::plain_octree(3, 4, 1, 1)};
  scene.materials.resize(1);
  scene.nodes.resize(1);
  scene.nodes[0].octree = 0;
  list_objects(scene);
  saved(scene, folder.path("a.svo"));
  const std::string bytes = slurp(folder.path("a.svo"));
  for_every_truncation(bytes, [&](const std::string& text) {
    const std::string path = folder.write("cut.svo", text);
    const Result<Scene> result = load(path, {.voxel_memory = uint64_t{1} << 28});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(result.error().file, path);
  });
}

TEST(Svo, OldVersionsAreNamed) {
  const TemporaryFolder folder;
  saved(voxel_scene(), folder.path("a.svo"));
  std::string bytes = slurp(folder.path("a.svo"));
  bytes[8] = 1;
  for (const uint64_t memory : {uint64_t{0}, uint64_t{1} << 28}) {
    const Result<Scene> result = load(folder.write("old.svo", bytes), {.voxel_memory = memory});
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().problem.find("version 1"), std::string::npos);
  }
}

}  // namespace
}  // namespace sinew
