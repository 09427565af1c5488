// Nodes, skins, instances, cameras and lights of small glTF files made here.
#include <limits>

#include "gltf_builder.h"

namespace sinew {
namespace {

using nlohmann::json;

TEST(GltfNode, ParentsComeFirstAndOtherScenesAreLeftOut) {
  GltfBuilder b;
  b.add("nodes", {{"name", "leaf"}});
  b.add("nodes", {{"name", "elsewhere"}, {"children", {0}}});
  b.add("nodes", {{"name", "root"}, {"children", {3, 0}}});
  b.add("nodes", {{"name", "middle"}});
  b.json["scenes"] = {{{"nodes", {1}}}, {{"nodes", {2}}, {"name", "shown"}}};
  b.json["scene"] = 1;
  const Scene scene = load_or_fail(b);
  EXPECT_EQ(scene.name, "shown");
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[0].name, "root");
  EXPECT_EQ(scene.nodes[1].name, "middle");
  EXPECT_EQ(scene.nodes[2].name, "leaf");
  EXPECT_EQ(scene.nodes[0].parent, -1);
  EXPECT_EQ(scene.nodes[2].parent, 0);
  b.json.erase("scene");  // the first scene then
  EXPECT_EQ(load_or_fail(b).nodes.at(0).name, "elsewhere");
}

TEST(GltfNode, WithoutScenesAllRootsShow) {
  GltfBuilder b;
  b.add("nodes", {{"children", {1}}});
  b.add("nodes", json::object());
  b.json.erase("scene");
  b.json.erase("scenes");
  EXPECT_EQ(load_or_fail(b).nodes.size(), 2u);
  b.json["nodes"][1]["children"] = {0};
  expect_contains(load_error(b), "all its nodes form cycles");
}

TEST(GltfNode, CyclesAndSecondParentsAreErrors) {
  GltfBuilder b;
  b.add("nodes", {{"children", {1}}});
  b.add("nodes", {{"children", {0}}});
  expect_contains(load_error(b), "node 0: has two parents, or is its own ancestor");
  b.json["nodes"] = {{{"children", {0}}}};
  expect_contains(load_error(b), "node 0: has two parents");
  b.json["nodes"] = {{{"children", {1, 2}}}, {{"children", {2}}}, json::object()};
  expect_contains(load_error(b), "node 2: has two parents");
  b.json["nodes"] = {{{"children", {7}}}};
  expect_contains(load_error(b), "\"children\" holds 7, but the file has only 1");
}

TEST(GltfNode, Transforms) {
  GltfBuilder b;
  b.add("nodes", {{"translation", {1, 2, 3}},
                  {"rotation", {0, 0, 2, 0}},  // not unit length
                  {"scale", {4, 5, 6}}});
  const Node node = load_or_fail(b).nodes.at(0);
  EXPECT_FALSE(node.has_matrix);
  EXPECT_EQ(node.translation, vec3(1, 2, 3));
  EXPECT_EQ(node.rotation, quat(0, 0, 0, 1));  // w, x, y, z: half a turn about Z
  EXPECT_EQ(node.scale, vec3(4, 5, 6));

  b.json["nodes"] = {{{"matrix", {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 10, 0, 11, 12, 13, 1}}}};
  const Node with_matrix = load_or_fail(b).nodes.at(0);
  EXPECT_TRUE(with_matrix.has_matrix);
  EXPECT_EQ(with_matrix.matrix, Affine(1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13));
  b.json["nodes"][0]["matrix"][3] = 0.5;
  expect_contains(load_error(b), "node 0: \"matrix\" is not affine");
  b.json["nodes"][0]["matrix"] = {1, 2, 3};
  expect_contains(load_error(b), "\"matrix\" is not an array of 16 numbers");
  b.json["nodes"] = {{{"translation", {1e39, 0, 0}}}};
  expect_contains(load_error(b), "within the range of float");
  b.json["nodes"] = {{{"rotation", {0, 0, 0, 0}}}};
  expect_contains(load_or_fail(b).warnings.at(0), "a rotation has no length");
}

// A triangle bound to joint 0, and two joint nodes.
GltfBuilder skinned_triangle() {
  GltfBuilder b;
  std::vector<float> weights(12, 0.0f);
  weights[0] = weights[4] = weights[8] = 1.0f;
  b.add_mesh_node(
      {{"attributes",
        {{"POSITION", b.triangle_positions()},
         {"JOINTS_0", b.accessor(std::vector<uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4")},
         {"WEIGHTS_0", b.accessor(weights, "VEC4")}}}});
  b.add("nodes", {{"name", "hip"}, {"children", {2}}});
  b.add("nodes", {{"name", "knee"}});
  b.json["scenes"][0]["nodes"] = {0, 1};
  b.json["nodes"][0]["skin"] = b.add("skins", {{"joints", {2, 1}}});
  return b;
}

TEST(GltfSkin, MissingInverseBindMatricesAreIdentity) {
  const Scene scene = load_or_fail(skinned_triangle());
  ASSERT_EQ(scene.skins.size(), 1u);
  EXPECT_EQ(scene.skins[0].joints, (std::vector<uint32_t>{2, 1}));
  EXPECT_EQ(scene.skins[0].inverse_bind, std::vector<Affine>(2, identity_affine()));
  EXPECT_EQ(scene.objects.at(0).skin, 0);
}

TEST(GltfSkin, InverseBindMatrices) {
  GltfBuilder b = skinned_triangle();
  std::vector<float> matrices = {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1,
                                 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  b.json["skins"][0]["inverseBindMatrices"] = b.accessor(matrices, "MAT4");
  EXPECT_EQ(load_or_fail(b).skins.at(0).inverse_bind[0],
            Affine(1, 0, 0, 0, 2, 0, 0, 0, 3, 4, 5, 6));
  matrices[31] = 2.0f;
  b.json["skins"][0]["inverseBindMatrices"] = b.accessor(matrices, "MAT4");
  expect_contains(load_error(b), "accessor 4: its matrix 1 is not affine");
  matrices[21] = std::numeric_limits<float>::infinity();  // behind what a vec4 each would hold
  b.json["skins"][0]["inverseBindMatrices"] = b.accessor(matrices, "MAT4");
  expect_contains(load_error(b), "accessor 5: its element 1 is not finite");
  matrices.resize(16);
  b.json["skins"][0]["inverseBindMatrices"] = b.accessor(matrices, "MAT4");
  expect_contains(load_error(b), "skin 0: has 1 inverse bind matrices for 2 joints");
}

TEST(GltfSkin, EqualSkinsBecomeOne) {
  GltfBuilder b = skinned_triangle();
  b.json["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  b.json["scenes"][0]["nodes"].push_back(3);
  b.add("skins", {{"joints", {2, 1}}, {"name", "again"}});
  EXPECT_EQ(load_or_fail(b).skins.size(), 1u);
  b.json["skins"][1]["joints"] = {1, 2};
  EXPECT_EQ(load_or_fail(b).skins.size(), 2u);
}

TEST(GltfSkin, BadSkinsAreErrors) {
  GltfBuilder b = skinned_triangle();
  b.json["skins"][0]["joints"] = {1};
  expect_contains(load_error(b), "node 0: its mesh uses joint 1, but its skin has only 1");
  b.json["skins"][0]["joints"] = json::array();
  expect_contains(load_error(b), "skin 0: has no joints");
  b.json["skins"][0]["joints"] = {2, 3};
  expect_contains(load_error(b), "\"joints\" holds 3, but the file has only 3");
  b.json["skins"][0]["joints"] = {1, 2};
  b.json["scenes"][0]["nodes"] = {0};
  expect_contains(load_error(b), "skin 0: its joint, node 1, is not part of the scene");
}

TEST(GltfSkin, AMeshWithoutJointsStaysRigid) {
  GltfBuilder b;
  b.add_triangle();
  b.json["nodes"][0]["skin"] = b.add("skins", {{"joints", {0}}});
  const Scene scene = load_or_fail(b);
  EXPECT_EQ(scene.objects.at(0).skin, -1);
  expect_contains(scene.warnings.at(0), "its mesh has no joints");
}

TEST(GltfInstancing, EachInstanceIsAChildNode) {
  GltfBuilder b;
  b.add_triangle();
  b.json["nodes"][0]["name"] = "grass";
  b.json["nodes"][0]["children"] = {b.add("nodes", {{"name", "child"}})};
  b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", b.accessor<float>({1, 0, 0, 2, 0, 0}, "VEC3")},
      {"ROTATION", b.accessor<int8_t>({0, 0, 0, 127, 127, 0, 0, 0}, "VEC4", true)}};
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.nodes.size(), 4u);
  EXPECT_EQ(scene.nodes[0].mesh, -1);
  EXPECT_EQ(scene.nodes[2].parent, 0);
  EXPECT_EQ(scene.nodes[2].translation, vec3(2, 0, 0));
  EXPECT_EQ(scene.nodes[2].rotation, quat(0, 1, 0, 0));
  EXPECT_EQ(scene.nodes[3].name, "child");
  EXPECT_EQ(scene.objects.size(), 2u);
  b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      b.accessor<float>({1, 1, 1}, "VEC3");
  expect_contains(load_error(b), "different numbers of translations");
}

TEST(GltfInstancing, NamesOfInstancesCountAgainstTheMemoryLimit) {
  GltfBuilder b;
  b.add_triangle();
  b.json["nodes"][0]["name"] = std::string(30'000, 'n');
  const int zeros =
      b.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 5000}});
  b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", zeros}};
  expect_contains(load_error(b, {.memory_limit = 64 << 20}), "needs more memory than the limit");
  b.json["nodes"][0]["name"] = "n";
  EXPECT_TRUE(b.load({.memory_limit = 64 << 20}));
}

TEST(GltfView, CamerasAndLights) {
  GltfBuilder b;
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  b.add("cameras", {{"type", "orthographic"},
                    {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}});
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"},
       {"name", "lamp"},
       {"color", {1, 0.5, 0}},
       {"intensity", 20},
       {"range", 5},
       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}},
      {{"type", "point"}},
      {{"type", "directional"}}};
  b.json["extensionsUsed"] = {"KHR_lights_punctual"};
  b.add("nodes", {{"camera", 1}, {"extensions", {{"KHR_lights_punctual", {{"light", 2}}}}}});
  const Scene scene = load_or_fail(b);
  EXPECT_FALSE(scene.cameras.at(0).orthographic);
  EXPECT_EQ(scene.cameras[0].yfov, 0.7f);
  EXPECT_TRUE(scene.cameras.at(1).orthographic);
  EXPECT_EQ(scene.cameras[1].ymag, 3.0f);
  EXPECT_EQ(scene.lights.at(0).type, LightType::spot);
  EXPECT_EQ(scene.lights[0].color, vec3(1, 0.5f, 0));
  EXPECT_EQ(scene.lights[0].intensity, 20.0f);
  EXPECT_EQ(scene.lights[0].range, 5.0f);
  EXPECT_EQ(scene.lights[0].inner_cone, 0.1f);
  EXPECT_EQ(scene.lights[0].outer_cone, 0.2f);
  EXPECT_EQ(scene.lights.at(1).type, LightType::point);
  EXPECT_EQ(scene.nodes[0].camera, 1);
  EXPECT_EQ(scene.nodes[0].light, 2);
  EXPECT_TRUE(scene.warnings.empty());

  b.json["extensions"]["KHR_lights_punctual"]["lights"][1]["type"] = "area";
  expect_contains(load_error(b), "light 1: has the unknown type \"area\"");
  b.json["cameras"][0]["perspective"]["yfov"] = 4;
  expect_contains(load_error(b), "camera 0: \"yfov\" must be");
}

TEST(GltfNode, HiddenNodes) {
  GltfBuilder b;
  b.add("nodes", {{"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  EXPECT_FALSE(load_or_fail(b).nodes.at(0).visible);
}

}  // namespace
}  // namespace sinew
