// Compressed glTF files against what was compressed.
#include <meshoptimizer.h>

#include <cmath>

#include "gltf_compressor.h"
#include "sinew/io/load.h"
#include "test_data.h"

namespace sinew {
namespace {

using nlohmann::json;

// Everything that is stored per vertex.
std::vector<float> vertex_values(const Mesh& mesh, uint32_t v) {
  std::vector<float> values;
  const auto append = [&](const auto& vectors) {
    if (vectors.empty()) return;
    for (int k = 0; k < vectors[v].length(); ++k) values.push_back(vectors[v][k]);
  };
  append(mesh.positions);
  append(mesh.normals);
  append(mesh.texcoords[0]);
  append(mesh.colors);
  for (uint32_t k = 0; k < mesh.influences; ++k) {
    values.push_back(mesh.joints[v * mesh.influences + k]);
    values.push_back(mesh.weights[v * mesh.influences + k]);
  }
  return values;
}

// Triangles by the values of their corners, in an order that does not depend on the file's.
std::vector<std::vector<float>> sorted_triangles(const Mesh& mesh) {
  std::vector<std::vector<float>> result;
  for (const uvec3& t : mesh.triangles) {
    std::vector<float> least;
    for (int first = 0; first < 3; ++first) {
      std::vector<float> values;
      for (int k = 0; k < 3; ++k) {
        const auto corner = vertex_values(mesh, t[(first + k) % 3]);
        values.insert(values.end(), corner.begin(), corner.end());
      }
      if (least.empty() || values < least) least = values;
    }
    result.push_back(std::move(least));
  }
  std::sort(result.begin(), result.end());
  return result;
}

void expect_equal_in_any_order(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].influences, b.meshes[i].influences);
    EXPECT_TRUE(sorted_triangles(a.meshes[i]) == sorted_triangles(b.meshes[i])) << "mesh " << i;
  }
}

// The same vertices and triangles in the same order; positions within `tolerance`.
void expect_equal(const Scene& a, const Scene& b, float tolerance = 0.0f) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    SCOPED_TRACE("mesh " + std::to_string(i));
    const Mesh &m = a.meshes[i], &n = b.meshes[i];
    EXPECT_TRUE(m.triangles == n.triangles);
    EXPECT_TRUE(m.normals == n.normals);
    EXPECT_TRUE(m.texcoords[0] == n.texcoords[0]);
    EXPECT_TRUE(m.joints == n.joints);
    EXPECT_TRUE(m.weights == n.weights);
    EXPECT_TRUE(m.morph_positions == n.morph_positions);
    ASSERT_EQ(m.positions.size(), n.positions.size());
    float worst = 0.0f;
    for (size_t v = 0; v < m.positions.size(); ++v) {
      worst = std::max(worst, distance(m.positions[v], n.positions[v]));
    }
    EXPECT_LE(worst, tolerance);
  }
  EXPECT_EQ(a.clips.size(), b.clips.size());
}

constexpr char kFox[] = "khronos-gltf/Fox/glTF-Binary/Fox.glb";
constexpr char kRobot[] = "skinned/robot-expressive/RobotExpressive.glb";

TEST(GltfDracoData, SequentialKeepsEverythingInOrder) {
  for (const char* name : {kFox, kRobot}) {
    SINEW_DATA_OR_SKIP(path, name);
    GltfBuilder asset = open_glb(path);
    const Scene plain = load_or_fail(asset);
    compress_with_draco(asset, {});
    expect_equal(plain, load_or_fail(asset));
  }
}

TEST(GltfDracoData, QuantisedPositionsStayNear) {
  SINEW_DATA_OR_SKIP(path, kFox);
  GltfBuilder asset = open_glb(path);
  const Scene plain = load_or_fail(asset);
  compress_with_draco(asset, {.position_bits = 14});
  // The grid's step is the largest side over 2^14; no component errs by more than half of it.
  vec3 low(plain.meshes[0].positions[0]), high = low;
  for (const vec3& p : plain.meshes[0].positions) {
    low = min(low, p);
    high = max(high, p);
  }
  const vec3 size = high - low;
  const float step = std::max({size.x, size.y, size.z}) / 16383.0f;
  expect_equal(plain, load_or_fail(asset), 0.51f * step * std::sqrt(3.0f));
}

TEST(GltfDracoData, EdgebreakerKeepsTheTriangles) {
  SINEW_DATA_OR_SKIP(path, kFox);
  GltfBuilder asset = open_glb(path);
  const Scene plain = load_or_fail(asset);
  compress_with_draco(asset, {.edgebreaker = true});
  const Scene scene = load_or_fail(asset);
  EXPECT_LT(scene.meshes[0].positions.size(), plain.meshes[0].positions.size()) << "duplicates";
  expect_equal_in_any_order(plain, scene);
}

TEST(GltfMeshoptData, BuffersComeBackAsTheyWere) {
  for (const char* name : {kFox, kRobot}) {
    SINEW_DATA_OR_SKIP(path, name);
    GltfBuilder asset = open_glb(path);
    const Scene plain = load_or_fail(asset);
    GltfBuilder turned = asset;
    compress_with_meshopt(asset, {});
    expect_equal(plain, load_or_fail(asset));
    compress_with_meshopt(turned, {.index_mode = "TRIANGLES"});
    expect_equal_in_any_order(plain, load_or_fail(turned));
  }
}

// A bumpy square of 6 x 6 vertices.
GltfBuilder make_patch() {
  std::vector<float> positions, normals, texcoords;
  std::vector<uint16_t> indices;
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 6; ++x) {
      const vec3 p(x, y, 0.1f * static_cast<float>((x * y) % 3));
      const vec3 n = normalize(vec3(0.1f * p.x, -0.1f * p.y, 1.0f));
      for (int k = 0; k < 3; ++k) positions.push_back(p[k]);
      for (int k = 0; k < 3; ++k) normals.push_back(n[k]);
      for (int k = 0; k < 2; ++k) texcoords.push_back(p[k] / 5.0f);
      if (x == 5 || y == 5) continue;
      for (const int i : {0, 1, 7, 0, 7, 6})
        indices.push_back(static_cast<uint16_t>(6 * y + x + i));
    }
  }
  GltfBuilder b;
  b.add_mesh_node({{"attributes",
                    {{"POSITION", b.accessor(positions, "VEC3")},
                     {"NORMAL", b.accessor(normals, "VEC3")},
                     {"TEXCOORD_0", b.accessor(texcoords, "VEC2")}}},
                   {"indices", b.accessor(indices, "SCALAR")}});
  return b;
}

// As compressed(), without anything that is not compressed.
GltfBuilder draco_patch(bool edgebreaker) {
  GltfBuilder b = make_patch();
  compress_with_draco(b, {.edgebreaker = edgebreaker, .position_bits = 11});
  const json view = b.json["bufferViews"].back();
  b.bytes = b.bytes.substr(view["byteOffset"], view["byteLength"]);
  b.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", b.bytes.size()}}};
  b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] =
      0;
  return b;
}

TEST(GltfMeshopt, FiltersAndQuantisation) {
  const std::vector<vec4> normals = {{0, 0, 1, 0}, {0.6f, 0, 0.8f, 0}, {0, -0.6f, -0.8f, 0}};
  const std::vector<vec4> positions = {{0, 0, 0, 0}, {1.5f, 0, -2, 0}, {0, 1000.25f, 3, 0}};
  std::string filtered_normals(3 * 4, '\0'), filtered_positions(3 * 12, '\0');
  meshopt_encodeFilterOct(filtered_normals.data(), 3, 4, 8, &normals[0].x);
  std::vector<float> packed;
  for (const vec4& p : positions) packed.insert(packed.end(), {p.x, p.y, p.z});
  meshopt_encodeFilterExp(filtered_positions.data(), 3, 12, 20, packed.data());

  GltfBuilder b;
  const int position_view =
      add_meshopt_view(b, filtered_positions, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
  const int normal_view = add_meshopt_view(b, filtered_normals, 3, 4, "ATTRIBUTES", "OCTAHEDRAL");
  const int position = b.add(
      "accessors",
      {{"bufferView", position_view}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}});
  const int normal = b.add("accessors", {{"bufferView", normal_view},
                                         {"componentType", 5120},
                                         {"normalized", true},
                                         {"type", "VEC3"},
                                         {"count", 3}});
  b.json["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  b.add_mesh_node({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}});
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.meshes.size(), 1u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(distance(scene.meshes[0].positions[i], vec3(positions[i])), 2e-3f);
    EXPECT_LT(distance(scene.meshes[0].normals[i], vec3(normals[i])), 0.02f);
  }
}

TEST(GltfMeshopt, QuaternionsOfAnAnimation) {
  const std::vector<quat> rotations = {quat(1, 0, 0, 0), normalize(quat(0.5f, 0.1f, -0.7f, 0.2f))};
  std::vector<float> packed;
  for (const quat& q : rotations) packed.insert(packed.end(), {q.x, q.y, q.z, q.w});
  std::string filtered(2 * 8, '\0');
  meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, packed.data());
  GltfBuilder b;
  b.add_triangle();
  const int times = b.accessor<float>({0, 1}, "SCALAR");
  const int output = b.add(
      "accessors", {{"bufferView", add_meshopt_view(b, filtered, 2, 8, "ATTRIBUTES", "QUATERNION")},
                    {"componentType", 5122},
                    {"normalized", true},
                    {"type", "VEC4"},
                    {"count", 2}});
  b.add("animations",
        {{"samplers", {{{"input", times}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}});
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.clips.size(), 1u);
  const std::vector<float>& values = scene.clips[0].channels[0].values;
  ASSERT_EQ(values.size(), 8u);
  for (size_t i = 0; i < 2; ++i) {
    const quat q(values[4 * i + 3], values[4 * i], values[4 * i + 1], values[4 * i + 2]);
    EXPECT_GT(std::abs(dot(q, rotations[i])), 0.99999f);
  }
}

TEST(GltfMeshopt, DescriptionsThatMakeNoSense) {
  GltfBuilder b = make_patch();
  compress_with_meshopt(b, {.index_mode = "TRIANGLES"});
  ASSERT_TRUE(b.load());
  const struct {
    const char* key;
    json value;
    const char* problem;
  } cases[] = {
      {"count", 4000000000u, "cannot hold 4000000000 elements"},
      {"count", 0, "0 elements of 12 bytes cannot be compressed"},
      {"count", -1, "\"count\""},
      {"byteStride", 6, "36 elements of 6 bytes cannot be compressed as ATTRIBUTES"},
      {"byteStride", 100000, "\"byteStride\""},
      {"mode", "PLAIN", "\"PLAIN\" is not known"},
      {"mode", "TRIANGLES", "36 elements of 12 bytes cannot"},
      {"filter", "OCTAHEDRAL", "OCTAHEDRAL does not fit ATTRIBUTES of 12 bytes"},
      {"filter", "SHARP", "\"SHARP\" is not known"},
      {"byteLength", 100000, "reaches past the end of buffer 0"},
      {"byteLength", 20, "damaged"},
      {"buffer", 1, "buffer 1, which has no data"},
      {"buffer", 7, "\"buffer\""},
  };
  for (const auto& c : cases) {
    GltfBuilder bad = b;
    bad.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][c.key] = c.value;
    const std::string message = load_error(bad);
    expect_contains(message, "buffer view 0");
    expect_contains(message, c.problem);
  }
}

TEST(GltfDraco, ClaimsAreCheckedBeforeMemoryIsTaken) {
  GltfBuilder b = draco_patch(false);
  ASSERT_TRUE(b.load());
  const std::string head("DRACO\x02\x02\x01", 8);  // version 2.2, a mesh
  const std::string many = "\xff\xff\xff\xff\x0f";
  const struct {
    std::string bytes;
    const char* problem;
  } cases[] = {
      // method, flags; sequential: faces, points; edgebreaker: traversal, vertices, faces
      {head + std::string("\0\0\0", 3) + many + "\x03", "cannot hold 4294967295 triangles"},
      {head + std::string("\0\0\0", 3) + "\x01" + many, "and 4294967295 vertices"},
      {head + std::string("\1\0\0\0", 4) + "\x03" + many, "cannot hold 4294967295 triangles"},
      {head + std::string("\1\0\0\0", 4) + many + "\x03", "and 4294967295 vertices"},
      {head, "damaged"},
      {std::string("DRACO\x02\x02\x00\0\0\0", 11), "no mesh"},
      {std::string("DRACO\x02\x01\x01\0\0\0", 11) + "\x01\x03", "older than version 2.2"},
      {"none", "damaged"},
  };
  for (const auto& c : cases) {
    b.bytes = c.bytes;
    b.json["bufferViews"][0]["byteLength"] = b.bytes.size();
    const std::string message = load_error(b);
    expect_contains(message, "mesh 0 primitive 0");
    expect_contains(message, c.problem);
  }
  // 900,000 triangles may cost a file nothing, but memory they do.
  b.bytes = head + std::string("\0\0\0", 3) + "\xa0\xf7\x36\x03";
  b.json["bufferViews"][0]["byteLength"] = b.bytes.size();
  expect_contains(load_error(b, {.memory_limit = uint64_t{64} << 20}), "needs more memory");
}

TEST(GltfDraco, AttributesMustBeWhatTheirAccessorsSay) {
  const GltfBuilder b = draco_patch(true);
  GltfBuilder bad = b;
  json& ids = bad.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                      ["attributes"];
  ids["POSITION"] = 77;
  expect_contains(load_error(bad), "no attribute 77 (POSITION)");
  ids["POSITION"] = ids["TEXCOORD_0"];
  expect_contains(load_error(bad), "do not hold POSITION as its accessor says");
  ids["POSITION"] = -1;
  expect_contains(load_error(bad), "\"POSITION\"");
}

// Loads the asset with the bytes of its buffer made bad.
template <class Change>
void expect_no_harm(const GltfBuilder& whole, const Change& change) {
  change(whole.bytes, [&](const std::string& bytes) {
    GltfBuilder bad = whole;
    bad.bytes = bytes;
    bad.bytes.resize(whole.bytes.size());
    const auto scene = bad.load({.memory_limit = uint64_t{64} << 20});
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
    } else {
      EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    }
  });
}

TEST(GltfCompressed, DamagedDataEndInErrorsOrValidScenes) {
  GltfBuilder meshopt = make_patch();
  compress_with_meshopt(meshopt, {.index_mode = "TRIANGLES"});
  for (const GltfBuilder& whole : {draco_patch(false), draco_patch(true), meshopt}) {
    expect_no_harm(whole, [](const std::string& bytes, const auto& read) {
      for_every_truncation(bytes, read);
    });
    expect_no_harm(whole, [](const std::string& bytes, const auto& read) {
      for_random_patches(bytes, 1000, 29, read);
    });
  }
}

}  // namespace
}  // namespace sinew
