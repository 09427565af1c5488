// Meshes of small glTF files made here, against numbers worked out by hand.
#include "gltf_builder.h"

namespace sinew {
namespace {

using nlohmann::json;

TEST(GltfMesh, TriangleWithNothingButPositions) {
  GltfBuilder b;
  b.add_triangle();
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.objects.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<uvec3>{{0, 1, 2}}));
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.parts[0].flat);
  EXPECT_EQ(scene.materials.size(), 1u);  // the default material
  EXPECT_EQ(scene.materials[0].metallic, 1.0f);
  EXPECT_FALSE(scene.materials[0].double_sided);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfMesh, ListsStripsAndFans) {
  const auto triangles = [](int mode, const std::vector<uint16_t>& indices) {
    GltfBuilder b;
    const int positions = b.accessor<float>(std::vector<float>(15, 0.5f), "VEC3");
    b.add_mesh_node({{"attributes", {{"POSITION", positions}}},
                     {"indices", b.accessor(indices, "SCALAR")},
                     {"mode", mode}});
    return load_or_fail(b).meshes.at(0).triangles;
  };
  EXPECT_EQ(triangles(4, {0, 1, 2, 2, 1, 3}), (std::vector<uvec3>{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(triangles(5, {0, 1, 2, 3, 4}), (std::vector<uvec3>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(triangles(6, {0, 1, 2, 3, 4}), (std::vector<uvec3>{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
}

TEST(GltfMesh, PointsAndLinesAreLeftOutAloud) {
  GltfBuilder b;
  b.add_triangle();
  b.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const Scene scene = load_or_fail(b);
  EXPECT_EQ(scene.meshes[0].parts.size(), 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_contains(scene.warnings[0], "mesh 0 primitive 1: points and lines are not supported");
  expect_contains(load_error(b, {.strict = true}), "points and lines are not supported");
  b.json["meshes"][0]["primitives"][0]["mode"] = 0;
  EXPECT_TRUE(load_or_fail(b).meshes.empty());
}

TEST(GltfMesh, PrimitivesWithTheSameAccessorsShareVertices) {
  GltfBuilder b;
  const int positions = b.accessor<float>(std::vector<float>(12, 0.5f), "VEC3");
  const int first = b.accessor<uint8_t>({0, 1, 2}, "SCALAR");
  const int second = b.accessor<uint8_t>({1, 3, 2}, "SCALAR");
  b.add("materials", {{"name", "red"}});
  b.add_mesh_node({{"attributes", {{"POSITION", positions}}}, {"indices", first}});
  b.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", positions}}}, {"indices", second}, {"material", 0}});
  b.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", b.triangle_positions()}}}});
  const Mesh mesh = load_or_fail(b).meshes.at(0);
  EXPECT_EQ(mesh.positions.size(), 4u + 3u);
  EXPECT_EQ(mesh.triangles, (std::vector<uvec3>{{0, 1, 2}, {1, 3, 2}, {4, 5, 6}}));
  EXPECT_EQ(mesh.triangle_part, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(mesh.parts[0].material, 1u);  // the default material follows the file's
  EXPECT_EQ(mesh.parts[1].material, 0u);
}

TEST(GltfMesh, AttributesThatSomePrimitivesLackAreFilled) {
  GltfBuilder b;
  b.add_mesh_node({{"attributes",
                    {{"POSITION", b.triangle_positions()},
                     {"NORMAL", b.accessor<float>({0, 0, 2, 0, 0, 2, 0, 0, 0}, "VEC3")},
                     {"TANGENT", b.accessor<float>(std::vector<float>(12, 1.0f), "VEC4")},
                     {"TEXCOORD_0", b.accessor<uint8_t>({0, 0, 255, 0, 0, 51}, "VEC2", true)},
                     {"COLOR_0", b.accessor<float>(std::vector<float>(9, 0.5f), "VEC3")}}}});
  b.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", b.triangle_positions()}}}});
  const Scene scene = load_or_fail(b);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_FALSE(mesh.parts[0].flat);
  EXPECT_TRUE(mesh.parts[1].flat);
  // Too long: made unit length. Zero, or absent: from the triangle, which faces +Z.
  EXPECT_EQ(mesh.normals, std::vector<vec3>(6, vec3(0, 0, 1)));
  EXPECT_TRUE(mesh.tangents.empty());  // not everywhere
  EXPECT_EQ(mesh.texcoords[0][2], vec2(0.0f, 0.2f));
  EXPECT_EQ(mesh.texcoords[0][4], vec2(0.0f));
  EXPECT_EQ(mesh.colors[0], vec4(0.5f, 0.5f, 0.5f, 1.0f));
  EXPECT_EQ(mesh.colors[3], vec4(1.0f));
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_contains(scene.warnings[0], "mesh 0: 1 normals have no length");
}

TEST(GltfMesh, TangentsAreMadeUnitLength) {
  GltfBuilder b;
  b.add_mesh_node(
      {{"attributes",
        {{"POSITION", b.triangle_positions()},
         {"NORMAL", b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")},
         {"TANGENT", b.accessor<float>({2, 0, 0, -1, 0, 1, 0, 1, 0, 0, 0, 1}, "VEC4")}}}});
  const Mesh mesh = load_or_fail(b).meshes.at(0);
  EXPECT_EQ(mesh.tangents[0], vec4(1, 0, 0, -1));
  EXPECT_EQ(mesh.tangents[1], vec4(0, 1, 0, 1));
  EXPECT_FLOAT_EQ(length(vec3(mesh.tangents[2])), 1.0f);
  EXPECT_EQ(mesh.tangents[2].z, 0.0f);  // across the normal
}

TEST(GltfMesh, WeightSetsBecomeTheInfluencesThatAreUsed) {
  GltfBuilder b;
  const int mesh_node = b.add_mesh_node(
      {{"attributes",
        {{"POSITION", b.triangle_positions()},
         {"JOINTS_0", b.accessor<uint8_t>({9, 1, 9, 9, 0, 9, 9, 9, 0, 0, 0, 0}, "VEC4")},
         {"WEIGHTS_0", b.accessor<float>({0, .25f, 0, 0, .5f, 0, 0, 0, 0, 0, 0, 0}, "VEC4")},
         {"JOINTS_1", b.accessor<uint16_t>({2, 0, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9}, "VEC4")},
         {"WEIGHTS_1",
          b.accessor<uint8_t>({128, 64, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", true)}}}});
  const int joint = b.add("nodes", {{"name", "hip"}});
  b.json["scenes"][0]["nodes"] = {mesh_node, joint};
  b.json["nodes"][mesh_node]["skin"] = b.add("skins", {{"joints", {joint, joint, joint}}});
  const Scene scene = load_or_fail(b);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.influences, 3u);  // of eight columns
  EXPECT_EQ(mesh.joints, (std::vector<uint16_t>{1, 2, 0, 0, 0, 0, 0, 0, 0}));
  const double sum = 0.25 + 192.0 / 255.0;
  EXPECT_FLOAT_EQ(mesh.weights[0], static_cast<float>(0.25 / sum));
  EXPECT_FLOAT_EQ(mesh.weights[1], static_cast<float>(128.0 / 255.0 / sum));
  EXPECT_FLOAT_EQ(mesh.weights[2], static_cast<float>(64.0 / 255.0 / sum));
  EXPECT_EQ(std::vector<float>(mesh.weights.begin() + 3, mesh.weights.end()),
            (std::vector<float>{1, 0, 0, 1, 0, 0}));
  ASSERT_EQ(scene.warnings.size(), 2u);
  expect_contains(scene.warnings[0], "skin weights of 1 vertices were normalised");
  expect_contains(scene.warnings[1], "1 vertices without skin weights were bound to joint 0");
}

TEST(GltfMesh, MorphTargets) {
  GltfBuilder b;
  const json target = {{"POSITION", b.accessor<float>({0, 0, 1, 0, 0, 2, 0, 0, 3}, "VEC3")},
                       {"NORMAL", b.accessor<float>({1, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3")}};
  b.add_mesh_node({{"attributes",
                    {{"POSITION", b.triangle_positions()},
                     {"NORMAL", b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}},
                   {"targets", {json::object(), target}}});
  b.json["meshes"][0]["weights"] = {0.0, 0.25};
  b.json["meshes"][0]["extras"] = {{"targetNames", {"smile"}}};
  b.json["nodes"][0]["weights"] = {1.0, 0.5};
  const Scene scene = load_or_fail(b);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.morph_targets, 2u);
  EXPECT_EQ(mesh.morph_positions,
            (std::vector<vec3>{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {0, 0, 3}}));
  EXPECT_EQ(mesh.morph_normals[3], vec3(1, 0, 0));
  EXPECT_EQ(mesh.morph_weights, (std::vector<float>{0.0f, 0.25f}));
  EXPECT_EQ(mesh.morph_names, (std::vector<std::string>{"smile", "target 1"}));
  EXPECT_EQ(scene.nodes[0].weights, (std::vector<float>{1.0f, 0.5f}));

  b.json["nodes"][0]["weights"] = {1.0};
  expect_contains(load_error(b), "node 0: has 1 weights for 2 morph targets");
}

TEST(GltfMesh, EveryPrimitiveNeedsTheSameNumberOfTargets) {
  GltfBuilder b;
  b.add_triangle();
  const int positions = b.triangle_positions();
  b.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", positions}}}, {"targets", {{{"POSITION", positions}}}}});
  expect_contains(load_error(b), "another number of morph targets");
}

TEST(GltfMesh, WrongIndicesAndCountsAreErrors) {
  GltfBuilder b;
  const int positions = b.triangle_positions();
  const int indices = b.accessor<uint8_t>({0, 1, 3}, "SCALAR");
  b.add_mesh_node({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  expect_contains(load_error(b), "accessor 1: its element 2 is vertex 3");
  b.json["meshes"][0]["primitives"][0] = {
      {"attributes", {{"POSITION", positions}, {"NORMAL", b.accessor<float>({0, 0, 1}, "VEC3")}}}};
  expect_contains(load_error(b), "accessor 2: has 1 elements as NORMAL of mesh 0 primitive 0");
  b.json["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 99}}}};
  expect_contains(load_error(b), "\"POSITION\" is 99, but the file has only 3");
  b.json["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 0}}}, {"material", 0}};
  expect_contains(load_error(b), "\"material\" is 0, but the file has only 0");
}

}  // namespace
}  // namespace sinew
