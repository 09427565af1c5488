// Looks of voxels against the G-buffer's, and what becomes of scenes.
#include "sinew/render/voxelize_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/io/load.h"
#include "sinew/math/random.h"
#include "sinew/render/gbuffer.h"
#include "sinew/render/voxelize_frames.h"
#include "sinew/render/voxels/voxel_looks.h"

namespace sinew {
namespace {

Scene study(const std::string& name) {
  Result<Scene> scene = load("study:" + name);
  EXPECT_TRUE(scene) << scene.error().message();
  return std::move(*scene);
}

// Random triangles with all attributes, and a material with textures that are smooth, so that mip
// levels do not matter.
struct LookScene {
  Scene scene;
  explicit LookScene(uint32_t seed, bool tangents, bool mapped) {
    Random random(seed);
    Image8 color{64, 64, {}}, normal{64, 64, {}};
    for (uint32_t i = 0; i < 64 * 64; ++i) {
      const float x = static_cast<float>(i % 64) / 64.0f, y = static_cast<float>(i / 64) / 64.0f;
      const auto code = [](float v) { return static_cast<uint8_t>(v * 255.0f); };
      color.pixels.insert(color.pixels.end(),
                          {code(0.2f + 0.6f * x), code(0.9f - 0.5f * y), code(0.5f), 255});
      normal.pixels.insert(normal.pixels.end(),
                           {code(0.4f + 0.3f * y), code(0.6f - 0.3f * x), code(0.9f), 255});
    }
    scene.images = {color, normal};
    Material material;
    material.base_color = vec4(0.9f, 0.8f, 1.0f, 1.0f);
    material.metallic = 0.0f;
    material.base_color_texture.image = 0;
    material.base_color_texture.wrap_s = material.base_color_texture.wrap_t = Wrap::clamp;
    if (mapped) material.normal_texture.image = 1;
    material.normal_texture.wrap_s = material.normal_texture.wrap_t = Wrap::mirror;
    material.normal_texture.scale = vec2(0.7f, 1.2f);
    material.normal_texture.rotation = 0.4f;
    material.normal_scale = 0.8f;
    scene.materials = {material};
    Mesh mesh;
    mesh.parts = {{0, false}, {0, true}};
    for (uint32_t i = 0; i < 40; ++i) {
      for (uint32_t k = 0; k < 3; ++k) {
        mesh.positions.push_back(random.uniform3(-1.0f, 1.0f));
        const float u = random.uniform(), v = random.uniform();
        mesh.texcoords[0].push_back(vec2(u, v));
        mesh.colors.push_back(vec4(random.uniform3(0.3f, 1.0f), 1.0f));
      }
      const vec3* p = &mesh.positions[3 * i];
      const vec3 face = normalize(cross(p[1] - p[0], p[2] - p[0]));
      const float side = i % 5 == 0 ? -1.0f : 1.0f;  // some files have them inside out
      for (uint32_t k = 0; k < 3; ++k) {
        const vec3 n = normalize(side * face + 0.3f * random.direction());
        mesh.normals.push_back(n);
        const vec3 t = normalize(cross(n, vec3(0.3f, 0.5f, 0.8f)));
        if (tangents) mesh.tangents.push_back(vec4(t, i % 2 == 0 ? 1.0f : -1.0f));
      }
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      mesh.triangle_part.push_back(i % 7 == 0 ? 1 : 0);
    }
    scene.meshes = {mesh};
    Node node;
    node.mesh = 0;
    scene.nodes = {node};
    list_objects(scene);
    EXPECT_EQ(validate(scene), "");
  }
};

TEST(VoxelLooks, AreTheGBuffers) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const LookScene made(seed, seed % 2 == 0, seed % 3 != 0);
    const Scene& scene = made.scene;
    const Mesh& mesh = scene.meshes[0];
    TextureTable table;
    table.build(scene);
    LookTextures textures(scene);
    textures.prepare(mesh, 0.01f);
    const MeshLooks looks(scene, mesh, textures);
    const Motion motion = motion_of(mesh, false);
    const Pose pose;
    ObjectAttributes attributes;
    attributes.mesh = &mesh;
    attributes.positions = mesh.positions;
    attributes.normals = mesh.normals;
    attributes.tangents = mesh.tangents;
    attributes.has_tangents = !mesh.tangents.empty();
    attributes.source = NormalSource::stored;
    attributes.motion = &motion;
    attributes.pose = &pose;

    Random random(seed);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      constexpr size_t kPoints = 37;  // not a multiple of any number of lanes
      std::vector<float> u(kPoints), v(kPoints);
      std::vector<uint16_t> normals(kPoints), colors(kPoints);
      std::vector<uint8_t> present(kPoints, 1);
      for (size_t i = 0; i < kPoints; ++i) {
        u[i] = random.uniform();
        v[i] = random.uniform(0.0f, 1.0f - u[i]);
      }
      looks({t, 0.01f, u, v, normals, colors, present});
      const vec3* p = &mesh.positions[3 * t];
      const vec3 face = normalize(cross(p[1] - p[0], p[2] - p[0]));
      for (size_t i = 0; i < kPoints; ++i) {
        Hit hit;
        hit.t = 1.0f;
        hit.object = 0;
        hit.primitive = t;
        hit.u = u[i];
        hit.v = v[i];
        Ray ray;
        const vec3 at = p[0] + u[i] * (p[1] - p[0]) + v[i] * (p[2] - p[0]);
        ray.origin = at + face;
        ray.direction = -face;
        Surface surface;
        resolve_surface(scene, table, attributes, ray, {}, hit, surface);
        ASSERT_LT(length(unpack_normal(normals[i]) - surface.normal), 0.025f) << t << " " << i;
        const vec3 color = glm::sqrt(unpack_color(colors[i]));
        const vec3 off = abs(color - glm::sqrt(min(surface.albedo, vec3(1.0f))));
        ASSERT_LT(std::max({off.x, off.y, off.z}), 0.02f) << t << " " << i;
        ASSERT_EQ(present[i], 1);
      }
    }
  }
}

// Mean colour of what covers a voxel, though its texels are far smaller.
TEST(VoxelLooks, FineTexturesAreAveraged) {
  LookScene made(1, false, false);
  Image8& image = made.scene.images[0];
  for (uint32_t y = 0; y < 64; ++y) {
    for (uint32_t x = 0; x < 64; ++x) {
      std::fill_n(image.at(x, y), 3, static_cast<uint8_t>((x + y) % 2 == 0 ? 255 : 0));
    }
  }
  Mesh& mesh = made.scene.meshes[0];
  mesh.colors.clear();
  made.scene.materials[0].base_color = vec4(1.0f);
  LookTextures textures(made.scene);
  textures.prepare(mesh, 0.5f);
  const MeshLooks looks(made.scene, mesh, textures);
  const std::vector<float> u = {0.2f, 0.4f}, v = {0.3f, 0.1f};
  std::vector<uint16_t> normals(2), colors(2);
  std::vector<uint8_t> present(2, 1);
  looks({3, 0.5f, u, v, normals, colors, present});
  for (const uint16_t color : colors) EXPECT_NEAR(unpack_color(color).y, 0.5f, 0.05f);
}

TEST(VoxelLooks, MaskedTexelsAreLeftOut) {
  LookScene made(2, false, false);
  Image8& image = made.scene.images[0];
  for (uint32_t y = 0; y < 64; ++y) {
    for (uint32_t x = 0; x < 64; ++x) image.at(x, y)[3] = x < 32 ? 0 : 255;
  }
  made.scene.materials[0].alpha_mode = AlphaMode::mask;
  VoxelizeSceneOptions options;
  options.resolution = 60;
  const auto masked = voxelize_object(made.scene, 0, options);
  made.scene.materials[0].alpha_mode = AlphaMode::opaque;
  const auto whole = voxelize_object(made.scene, 0, options);
  ASSERT_TRUE(masked && whole);
  EXPECT_GT(masked->surface.voxels, 1000u);
  EXPECT_LT(masked->surface.voxels, whole->surface.voxels * 9 / 10);
}

TEST(VoxelizeScene, MakesOctreesThatTheSkeletonMoves) {
  const Scene scene = study("creature,triangles=12000");
  VoxelizeSceneOptions options;
  options.resolution = 200;
  const Result<VoxelizedScene> made = voxelize_scene(scene, options);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ(validate(made->scene), "");
  EXPECT_TRUE(made->scene.meshes.empty());
  EXPECT_TRUE(made->scene.images.empty());
  EXPECT_EQ(made->scene.octrees.size(), scene.meshes.size());
  EXPECT_EQ(made->scene.voxels.size(), scene.objects.size());
  EXPECT_EQ(made->scene.clips.size(), scene.clips.size());
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneVoxels& voxels = made->scene.voxels[i];
    EXPECT_EQ(voxels.node, scene.objects[i].node);
    EXPECT_EQ(voxels.skin, scene.objects[i].skin);
    const Svo& octree = made->scene.octrees[voxels.octree];
    EXPECT_EQ(octree.joints > 0, voxels.skin >= 0);
    EXPECT_EQ(validate(octree), "");
    EXPECT_NEAR(octree.grid.voxel / made->voxel, 1.0, 1e-3);
  }
}

TEST(VoxelizeScene, OthersStayMeshesOrGo) {
  const Scene scene = study("creature,triangles=12000");
  VoxelizeSceneOptions options;
  options.resolution = 60;
  options.chosen.assign(scene.objects.size(), 0);
  options.chosen[1] = 1;
  const auto mixed = voxelize_scene(scene, options);
  ASSERT_TRUE(mixed) << mixed.error().message();
  EXPECT_EQ(validate(mixed->scene), "");
  EXPECT_EQ(mixed->scene.octrees.size(), 1u);
  EXPECT_EQ(mixed->scene.meshes.size(), scene.meshes.size() - 1);
  EXPECT_EQ(mixed->scene.objects.size(), scene.objects.size() - 1);
  EXPECT_EQ(mixed->scene.images.size(), scene.images.size());
  options.keep_meshes = false;
  const auto alone = voxelize_scene(scene, options);
  ASSERT_TRUE(alone) << alone.error().message();
  EXPECT_EQ(validate(alone->scene), "");
  EXPECT_EQ(alone->scene.objects.size(), 0u);
  EXPECT_EQ(alone->scene.voxels.size(), 1u);
  options.chosen.assign(scene.objects.size(), 0);
  const auto none = voxelize_scene(scene, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::usage);
}

TEST(VoxelizeScene, InstancesShareAnOctreeThatSuitsTheLargest) {
  const LookScene made(3, false, false);
  Scene scene = made.scene;
  Node large = scene.nodes[0];
  large.scale = vec3(4.0f);
  scene.nodes.push_back(large);
  list_objects(scene);
  VoxelizeSceneOptions options;
  options.voxel = 0.125;
  const auto voxels = voxelize_scene(scene, options);
  ASSERT_TRUE(voxels) << voxels.error().message();
  ASSERT_EQ(voxels->scene.octrees.size(), 1u);
  EXPECT_EQ(voxels->scene.voxels.size(), 2u);
  EXPECT_NEAR(voxels->scene.octrees[0].grid.voxel, 0.125 / 4.0, 1e-6);
}

TEST(VoxelizeScene, VertexProgramsStandStill) {
  LookScene moving(4, false, false);
  Scene& scene = moving.scene;
  scene.meshes[0].vertex_program = [](double, std::span<vec3>) {};
  VoxelizeSceneOptions options;
  options.resolution = 50;
  const auto made = voxelize_scene(scene, options);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ(validate(made->scene), "");
  ASSERT_EQ(made->scene.warnings.size(), scene.warnings.size() + 1);
  EXPECT_NE(made->scene.warnings.back().find("stand still"), std::string::npos);
}

TEST(VoxelizeScene, ResolutionsOutOfRangeAndMemory) {
  const Scene scene = study("twist,triangles=2000");
  VoxelizeSceneOptions options;
  for (const uint32_t resolution : {0u, 4097u}) {
    options.resolution = resolution;
    const auto made = voxelize_scene(scene, options);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::usage);
  }
  options.resolution = 1;
  EXPECT_TRUE(voxelize_scene(scene, options));
  options.resolution = 500;
  options.memory_limit = 1 << 20;
  const auto made = voxelize_scene(scene, options);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().kind, ErrorKind::runtime);
}

TEST(VoxelizeFrames, HaveOneGridAndFollowTheClip) {
  const Scene scene = study("creature,triangles=12000");
  VoxelizeSceneOptions options;
  options.resolution = 60;
  options.chosen.assign(scene.objects.size(), 0);
  options.chosen[0] = 1;
  const double times[] = {0.0, 0.5, 1.0};
  const auto frames = voxelize_frames(scene, 0, times, options);
  ASSERT_TRUE(frames) << frames.error().message();
  ASSERT_EQ(frames->size(), 1u);
  ASSERT_EQ((*frames)[0].frames.size(), 3u);
  EXPECT_LE((*frames)[0].grid.resolution.z, 61u);
  std::vector<VoxelMorton> before;
  for (const std::vector<PlainVoxel>& frame : (*frames)[0].frames) {
    EXPECT_GT(frame.size(), 500u);
    std::vector<VoxelMorton> places;
    for (const PlainVoxel& voxel : frame) {
      EXPECT_TRUE(places.empty() || places.back() < voxel.voxel);
      places.push_back(voxel.voxel);
    }
    EXPECT_NE(places, before);
    before = places;
  }
}

}  // namespace
}  // namespace sinew
