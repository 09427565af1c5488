// The glTF loader as a whole: containers, extensions, warnings, limits.
#include "sinew/io/gltf/gltf.h"

#include "gltf_builder.h"

namespace sinew {
namespace {

using nlohmann::json;

std::string error_of(const std::string& bytes, const std::string& name = "a.glb") {
  const TemporaryFolder folder;
  const Result<Scene> scene = load_gltf(folder.write(name, bytes));
  if (scene) return "(loaded without error)";
  EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
  return scene.error().message();
}

TEST(Gltf, TheSameSceneFromGlbAndGltfAndExternalBuffer) {
  GltfBuilder b;
  b.add_triangle();
  const TemporaryFolder folder;
  const Result<Scene> glb = load_gltf(folder.write("a.glb", b.glb()));
  const Result<Scene> gltf = load_gltf(folder.write("a.gltf", b.gltf()));
  folder.write("my data.bin", b.bytes);
  b.json["buffers"] = {{{"byteLength", b.bytes.size()}, {"uri", "my%20data.bin"}}};
  const Result<Scene> external = load_gltf(folder.write("b.gltf", b.json.dump()));
  for (const Result<Scene>* scene : {&glb, &gltf, &external}) {
    ASSERT_TRUE(*scene) << scene->error().message();
    EXPECT_EQ((*scene)->meshes.at(0).positions[1], vec3(1, 0, 0));
  }
}

TEST(Gltf, DamagedContainers) {
  GltfBuilder b;
  b.add_triangle();
  const std::string glb = b.glb();
  expect_contains(error_of(""), "is empty");
  expect_contains(error_of("glTF"), "cut off");
  expect_contains(error_of("{", "a.gltf"), "is not valid JSON");
  expect_contains(error_of("[]", "a.gltf"), "is not a glTF file");
  expect_contains(error_of("{}", "a.gltf"), "\"asset.version\" is missing");
  std::string version_1 = glb;
  version_1[4] = 1;
  expect_contains(error_of(version_1), "GLB file of version 1");
  expect_contains(error_of(glb.substr(0, glb.size() - 4)), "cut off: it has");
  const auto container = [](const std::string& body) {
    return "glTF" + GltfBuilder::u32(2) +
           GltfBuilder::u32(static_cast<uint32_t>(body.size() + 12)) + body;
  };
  expect_contains(error_of(container(GltfBuilder::chunk(0x4E4F534A, "{}") + "xyz")),
                  "chunks are damaged");
  expect_contains(error_of(container(GltfBuilder::chunk(0x004E4942, "{}"))),
                  "the first GLB chunk, and no other, must be JSON");
  expect_contains(error_of(container(GltfBuilder::u32(99) + GltfBuilder::u32(0x4E4F534A))),
                  "a GLB chunk reaches past the end");
}

TEST(Gltf, VersionsOtherThanTwo) {
  GltfBuilder b;
  b.add_triangle();
  b.json["asset"]["version"] = "1.0";
  expect_contains(load_error(b), "is glTF 1.0; only version 2");
  b.json["asset"] = {{"version", "2.1"}, {"minVersion", "2.1"}};
  expect_contains(load_error(b), "needs glTF 2.1");
  b.json["asset"] = {{"version", "2.1"}};
  EXPECT_TRUE(b.load());
}

TEST(Gltf, ExtensionsAreNamed) {
  GltfBuilder b;
  b.add_triangle();
  b.json["extensionsUsed"] = {"KHR_materials_sheen", "KHR_texture_transform"};
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_contains(scene.warnings[0], "the extension KHR_materials_sheen is not supported");
  expect_contains(load_error(b, {.strict = true}), "KHR_materials_sheen");
  b.json["extensionsRequired"] = {"KHR_texture_transform"};
  EXPECT_TRUE(b.load());
  b.json["extensionsRequired"] = {"KHR_texture_basisu"};
  expect_contains(load_error(b), "needs the extension KHR_texture_basisu");
}

TEST(Gltf, PlainDataComeBeforeCompressedOnes) {
  GltfBuilder b;
  b.add_triangle();
  json& primitive = b.json["meshes"][0]["primitives"][0];
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}};
  EXPECT_TRUE(b.load());
  b.json["accessors"][0].erase("bufferView");
  expect_contains(load_error(b), "mesh 0 primitive 0: its Draco data");

  b.json["accessors"][0]["bufferView"] = 0;
  b.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}};
  b.json["bufferViews"][0]["buffer"] = 0;
  EXPECT_TRUE(b.load());
  b.bytes.clear();
  b.json["buffers"] = {{{"byteLength", 36}}};
  expect_contains(load_error(b), "buffer 0, which has no data");
  b.json["bufferViews"][0].erase("extensions");
  expect_contains(load_error(b), "buffer 0, which has no data");
}

TEST(Gltf, BuffersMustHoldWhatTheySay) {
  GltfBuilder b;
  b.add_triangle();
  const std::string bytes = b.bytes;
  b.bytes.clear();
  const TemporaryFolder folder;
  folder.write("a.bin", bytes.substr(0, 35));
  folder.write("inner/empty", "");
  const auto error = [&](const json& buffer) {
    b.json["buffers"] = json::array({buffer});
    const Result<Scene> scene = load_gltf(folder.write("inner/a.gltf", b.json.dump()));
    return scene ? "(loaded without error)" : scene.error().message();
  };
  folder.write("inner/short.bin", bytes.substr(0, 35));
  expect_contains(error({{"byteLength", 36}, {"uri", "short.bin"}}),
                  "buffer 0: has 35 bytes, but the file says 36");
  expect_contains(error({{"byteLength", 36}, {"uri", "missing.bin"}}),
                  "buffer 0: cannot read \"missing.bin\"");
  expect_contains(error({{"byteLength", 36}, {"uri", "../a.bin"}}),
                  "not a file within the asset's folder");
  expect_contains(error({{"byteLength", 36}, {"uri", "%2E%2E/a.bin"}}), "not a file within");
  expect_contains(error({{"byteLength", 36}, {"uri", "/etc/passwd"}}), "not a file within");
  expect_contains(error({{"byteLength", 36}, {"uri", "file:///etc/passwd"}}), "only files in");
  expect_contains(error({{"byteLength", 36}, {"uri", 7}}), "\"uri\" is not a text");
  expect_contains(error({{"byteLength", -1}, {"uri", "a.bin"}}), "\"byteLength\" is not a whole");
  expect_contains(error({{"byteLength", 36}, {"uri", "data:;base64,AAAA"}}), "has 3 bytes");
  expect_contains(error({{"byteLength", 36}, {"uri", "data:;base64,A*AA"}}), "wrong character");
}

TEST(Gltf, MissingFilesAndFolders) {
  const TemporaryFolder folder;
  const Result<Scene> missing = load_gltf(folder.path("none.glb"));
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(missing.error().file, folder.path("none.glb"));
  EXPECT_FALSE(load_gltf(folder.path(".")));
  EXPECT_FALSE(load_gltf(""));
}

TEST(Gltf, TheMemoryLimitHolds) {
  GltfBuilder b;
  b.add_mesh_node(
      {{"attributes", {{"POSITION", b.accessor<float>(std::vector<float>(3000), "VEC3")}}}});
  EXPECT_TRUE(b.load({.memory_limit = 200000}));
  expect_contains(load_error(b, {.memory_limit = 40000}), "needs more memory than the limit");
  EXPECT_FALSE(b.load({.memory_limit = 1000}));
  // Many meshes of one accessor: a small file that would fill any machine.
  for (int i = 0; i < 1000; ++i) {
    b.json["scenes"][0]["nodes"].push_back(
        b.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"targets", json::array()}}));
  }
  expect_contains(load_error(b, {.memory_limit = 10000000}), "needs more memory than the limit");
}

TEST(Gltf, ManyWarningsBecomeFew) {
  GltfBuilder b;
  b.add_triangle();
  b.json["extensionsUsed"] = json::array();
  for (int i = 0; i < 1000; ++i) b.json["extensionsUsed"].push_back("X_" + std::to_string(i));
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.warnings.size(), 65u);
  expect_contains(scene.warnings.back(), "936 further warnings");
}

}  // namespace
}  // namespace sinew
