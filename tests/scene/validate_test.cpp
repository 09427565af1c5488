// validate() accepts sound scenes and names each broken invariant.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "scene/small_scenes.h"
#include "sinew/scene/scene.h"

namespace sinew {
namespace {

using test::channel;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A mesh that has everything but keys.
Mesh rich_mesh() {
  Mesh mesh = test::morphed_mesh();
  const Mesh skinned = test::skinned_mesh();
  mesh.influences = 2;
  mesh.joints = skinned.joints;
  mesh.weights = skinned.weights;
  mesh.normals.assign(3, vec3(0, 0, 1));
  mesh.morph_normals.assign(6, vec3(0));
  mesh.tangents.assign(3, vec4(1, 0, 0, -1));
  mesh.texcoords[0].assign(3, vec2(0.5f));
  mesh.colors.assign(3, vec4(1));
  return mesh;
}

TEST(ValidateMesh, AcceptsSoundMeshes) {
  for (const Mesh& mesh : {test::triangle_mesh(), test::skinned_mesh(), test::morphed_mesh(),
                           test::cached_mesh(), rich_mesh(), Mesh{}}) {
    EXPECT_EQ(validate(mesh), "") << mesh.name;
  }
}

TEST(ValidateMesh, CornersIndexAttributesOfAnySize) {
  Mesh mesh = test::triangle_mesh();
  mesh.normals.assign(5, vec3(0, 0, 1));
  EXPECT_NE(validate(mesh), "");
  mesh.corners = {{4, 0, 2}};
  EXPECT_EQ(validate(mesh), "");
  mesh.texcoords[0].assign(4, vec2(0));
  EXPECT_EQ(validate(mesh), "corners: entry 0 is 4 where 4 exist");
}

TEST(ValidateMesh, FindsEachFault) {
  using Break = std::function<void(Mesh&)>;
  const std::vector<Break> breaks = {
      [](Mesh& m) { m.positions[1].y = kNan; },
      [](Mesh& m) { m.triangles[0].z = 3; },
      [](Mesh& m) { m.triangle_part.push_back(0); },
      [](Mesh& m) { m.triangle_part[0] = 1; },
      [](Mesh& m) { m.corners.resize(2); },
      [](Mesh& m) {
        m.corners = {{0, 1, 3}};
      },
      [](Mesh& m) { m.normals.pop_back(); },
      [](Mesh& m) { m.normals[2] = vec3(0, 0, 2); },
      [](Mesh& m) { m.normals[2] = vec3(kNan); },
      [](Mesh& m) { m.tangents[0].w = 0.5f; },
      [](Mesh& m) { m.tangents[0].x = kNan; },
      [](Mesh& m) { m.texcoords[1].resize(2); },
      [](Mesh& m) { m.texcoords[0][1].x = kNan; },
      [](Mesh& m) { m.colors[1].w = kNan; },
      [](Mesh& m) { m.joints.pop_back(); },
      [](Mesh& m) { m.weights.pop_back(); },
      [](Mesh& m) { m.influences = 1; },
      [](Mesh& m) { m.weights[3] = kNan; },
      [](Mesh& m) { m.weights[3] = 0.6f; },
      [](Mesh& m) { m.weights[2] = -0.5f, m.weights[3] = 1.5f; },
      [](Mesh& m) { m.morph_targets = 3; },
      [](Mesh& m) { m.morph_positions[0].x = kNan; },
      [](Mesh& m) { m.morph_normals.pop_back(); },
      [](Mesh& m) { m.morph_normals[0].x = kNan; },
      [](Mesh& m) { m.morph_weights.clear(); },
      [](Mesh& m) { m.morph_weights[0] = kNan; },
      [](Mesh& m) { m.morph_names.pop_back(); },
      [](Mesh& m) { m.keys = 1; },
      [](Mesh& m) { m.keys = 1, m.key_positions.assign(3, vec3(kNan)); },
  };
  for (size_t i = 0; i < breaks.size(); ++i) {
    Mesh mesh = rich_mesh();
    breaks[i](mesh);
    EXPECT_NE(validate(mesh), "") << "fault " << i;
  }
  Mesh empty;
  empty.morph_targets = 1;
  empty.morph_weights = {0};
  EXPECT_NE(validate(empty), "");
  empty = {};
  empty.keys = 4;
  EXPECT_NE(validate(empty), "");
}

// Nodes: 0 skinned mesh, 1 and 2 joints, 3 a cached mesh, 4 a morphed one, 5 camera and light.
Scene rich_scene() {
  Scene scene = test::skinned_scene();
  scene.meshes.push_back(test::cached_mesh());
  scene.meshes.push_back(test::morphed_mesh());
  scene.nodes.resize(6);
  scene.nodes[3].mesh = 1;
  scene.nodes[4].mesh = 2;
  scene.nodes[4].weights = {0, 1};
  scene.nodes[5].camera = 0;
  scene.nodes[5].light = 0;
  scene.cameras.resize(1);
  scene.lights.resize(1);
  scene.images = {{1, 1, {1, 2, 3, 4}}};
  scene.materials[0].base_color_texture.image = 0;
  list_objects(scene);
  scene.clips = {{"all",
                  0,
                  1,
                  {channel(1, ChannelPath::rotation, 4, {0, 1}, {0, 0, 0, 1, 1, 0, 0, 0}),
                   channel(3, ChannelPath::cache_key, 1, {0, 1}, {0, 2}),
                   channel(4, ChannelPath::weights, 2, {0}, {1, 1}),
                   channel(0, ChannelPath::visibility, 1, {0}, {1})}}};
  return scene;
}

TEST(ValidateScene, AcceptsSoundScenes) {
  EXPECT_EQ(validate(Scene{}), "");
  EXPECT_EQ(validate(rich_scene()), "");
}

TEST(ValidateScene, NamesTheElement) {
  Scene scene = rich_scene();
  scene.meshes[1].triangles[0].x = 9;
  EXPECT_EQ(validate(scene), "mesh 1 'triangle': triangles: entry 0 is 9 where 3 exist");
  scene = rich_scene();
  scene.clips[0].channels[1].values.pop_back();
  EXPECT_EQ(validate(scene), "clip 0 'all': channel 1: values: 1 where 2 belong");
}

TEST(ValidateScene, FindsEachFault) {
  using Break = std::function<void(Scene&)>;
  const std::vector<Break> breaks = {
      [](Scene& s) { s.meshes[0].parts[0].material = 1; },
      [](Scene& s) { s.materials.clear(); },
      [](Scene& s) { s.images[0].pixels.pop_back(); },
      [](Scene& s) { s.images[0] = {}; },
      [](Scene& s) { s.materials[0].normal_texture.image = 1; },
      [](Scene& s) { s.materials[0].normal_texture.image = -2; },
      [](Scene& s) { s.materials[0].normal_texture.texcoord = 2; },
      [](Scene& s) { s.materials[0].normal_texture.scale.y = kNan; },
      [](Scene& s) { s.materials[0].emissive.z = kNan; },
      [](Scene& s) { s.nodes[1].parent = 1; },
      [](Scene& s) { s.nodes[1].parent = 2; },
      [](Scene& s) { s.nodes[1].parent = -2; },
      [](Scene& s) { s.nodes[1].mesh = 3; },
      [](Scene& s) { s.nodes[1].skin = 1; },
      [](Scene& s) { s.nodes[1].camera = 1; },
      [](Scene& s) { s.nodes[1].light = 1; },
      [](Scene& s) { s.nodes[1].translation.x = kNan; },
      [](Scene& s) { s.nodes[1].rotation.x = kNan; },
      [](Scene& s) { s.nodes[1].rotation = quat(0, 0, 0, 0); },
      [](Scene& s) { s.nodes[1].scale.x = kNan; },
      [](Scene& s) { s.nodes[1].matrix[2].x = kNan; },
      [](Scene& s) { s.nodes[4].weights = {1}; },
      [](Scene& s) {
        s.nodes[4].weights = {1, kNan};
      },
      [](Scene& s) { s.nodes[1].weights = {1}; },
      [](Scene& s) { s.skins[0].joints[0] = 6; },
      [](Scene& s) { s.skins[0].inverse_bind.pop_back(); },
      [](Scene& s) { s.skins[0].inverse_bind[0][3].x = kNan; },
      [](Scene& s) { s.skins[0].joints.pop_back(), s.skins[0].inverse_bind.pop_back(); },
      [](Scene& s) { s.cameras[0].yfov = 0; },
      [](Scene& s) { s.cameras[0].yfov = 4; },
      [](Scene& s) { s.cameras[0].ymag = kNan; },
      [](Scene& s) { s.cameras[0].znear = -1; },
      [](Scene& s) { s.lights[0].intensity = kNan; },
      [](Scene& s) { s.objects.pop_back(); },
      [](Scene& s) { s.objects[1].node = 7; },
      [](Scene& s) { std::swap(s.objects[0], s.objects[1]); },
      [](Scene& s) { s.objects[1].mesh = 2; },
      [](Scene& s) { s.objects[1].skin = 0; },
      [](Scene& s) { s.clips[0].end = -1; },
      [](Scene& s) { s.clips[0].start = kNan; },
      [](Scene& s) { s.clips[0].channels[0].node = 6; },
      [](Scene& s) { s.clips[0].channels[0].width = 3; },
      [](Scene& s) {
        s.clips[0].channels[0].times = {1, 1};
      },
      [](Scene& s) {
        s.clips[0].channels[0].times = {1, 0};
      },
      [](Scene& s) {
        s.clips[0].channels[0].times = {0, kNan};
      },
      [](Scene& s) { s.clips[0].channels[2].times.clear(), s.clips[0].channels[2].values.clear(); },
      [](Scene& s) { s.clips[0].channels[0].values.pop_back(); },
      [](Scene& s) { s.clips[0].channels[0].values[2] = kNan; },
      [](Scene& s) { s.clips[0].channels[0].interpolation = Interpolation::cubic_spline; },
      [](Scene& s) { s.clips[0].channels[1].node = 4; },
      [](Scene& s) { s.clips[0].channels[2].node = 3; },
      [](Scene& s) { s.environment.zenith.x = kNan; },
  };
  for (size_t i = 0; i < breaks.size(); ++i) {
    Scene scene = rich_scene();
    breaks[i](scene);
    EXPECT_NE(validate(scene), "") << "fault " << i;
  }
}

}  // namespace
}  // namespace sinew
