#include "sinew/io/polygon/scene.h"

#include <gtest/gtest.h>

#include "io/hostile.h"
#include "sinew/io/image_file.h"
#include "test_data.h"

namespace sinew {
namespace {

Result<Scene> load_text(const std::string& text, const LoadOptions& options = {}) {
  TemporaryFolder folder;
  return load_polygons(folder.write("a.obj", text), options);
}

const Mesh& mesh_of(const Result<Scene>& scene) {
  EXPECT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(validate(*scene), "");
  return scene->meshes[0];
}

bool any_contains(const std::vector<std::string>& texts, const std::string& part) {
  for (const std::string& text : texts) {
    if (text.find(part) != std::string::npos) return true;
  }
  return false;
}

const std::string kQuad =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n";

TEST(Obj, PolygonsBecomeFansWithAllFormsOfIndices) {
  for (const char* face :
       {"f 1 2 3 4", "f 1/1 2/2 3/3 4/4", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/2/1 3/3/1 4/4/1",
        "f -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1", "fo 1/1/ 2/2/ 3/3/ 4/4/"}) {
    const auto scene = load_text(kQuad + face);
    if (std::string(face).starts_with("fo")) {  // a slash must be followed by an index
      EXPECT_FALSE(scene);
      continue;
    }
    const Mesh& mesh = mesh_of(scene);
    ASSERT_EQ(mesh.triangles.size(), 2u) << face;
    EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
    EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
    EXPECT_TRUE(mesh.corners.empty()) << "each vertex has one set of attributes";
    const bool has_uv = std::string(face).find("/1") == 3 || face[2] == '-';
    if (has_uv && std::string(face).find("//") == std::string::npos) {
      ASSERT_EQ(mesh.texcoords[0].size(), 4u);
      EXPECT_EQ(mesh.texcoords[0][2], vec2(1, 0)) << "v goes down in sinew";
    }
  }
}

TEST(Obj, TextInAllItsForms) {
  const auto scene = load_text(
      "\xef\xbb\xbf# comment\r\n\tv\t0 0 0 # here too\r\nv +1 0e0 \\\r\n  .0\nv 0 1. -0\r\n"
      "\n   \nvn 0 0 2e10\no name\ng a b\nf 1//1 \\\n2//1\\\n 3//1");
  const Mesh& mesh = mesh_of(scene);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.positions[1], vec3(1, 0, 0));
  EXPECT_EQ(mesh.positions[2], vec3(0, 1, 0));
  EXPECT_EQ(mesh.normals[0], vec3(0, 0, 1)) << "normals are brought to unit length";
  EXPECT_TRUE(scene->warnings.empty());
}

TEST(Obj, SeamsLiveAtCornersAndPositionsStay) {
  const auto scene = load_text(kQuad + "v 9 9 9\nf 1/1 2/2 3/3\nf 1/2 3/3 4/4\n");
  const Mesh& mesh = mesh_of(scene);
  EXPECT_EQ(mesh.positions.size(), 5u) << "a vertex cache indexes unused positions too";
  EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
  ASSERT_EQ(mesh.corners.size(), 2u);
  EXPECT_EQ(mesh.texcoords[0][mesh.corners[0].x], vec2(0, 1));
  EXPECT_EQ(mesh.texcoords[0][mesh.corners[1].x], vec2(1, 1));
  EXPECT_EQ(mesh.corners[0].z, mesh.corners[1].y) << "equal attributes are stored once";
}

TEST(Obj, WithoutNormalsThereAreNoneAndOnlySmoothingOffIsFlat) {
  const auto scene = load_text(kQuad + "f 1 2 3\ns off\nf 1 3 4\ns 1\nf 2 3 4\n");
  const Mesh& mesh = mesh_of(scene);
  EXPECT_TRUE(mesh.normals.empty());
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_FALSE(mesh.parts[mesh.triangle_part[0]].flat);
  EXPECT_TRUE(mesh.parts[mesh.triangle_part[1]].flat);
  EXPECT_EQ(mesh.triangle_part[2], mesh.triangle_part[0]);
}

TEST(Obj, MissingAndZeroNormalsTakeTheTriangles) {
  const auto scene = load_text(
      "v 0 0 0\nv 1 0 0\nv 0 0 1\nvn 0 0 0\nvn 0 0 1e-30\n"
      "f 1//1 2//2 3\n");
  const Mesh& mesh = mesh_of(scene);
  const uvec3 corner = mesh.corner_of(0);
  EXPECT_EQ(mesh.normals[corner.x], vec3(0, -1, 0));
  EXPECT_EQ(mesh.normals[corner.y], vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[corner.z], vec3(0, -1, 0));
  EXPECT_TRUE(any_contains(scene->warnings, "2 corners"));
}

TEST(Obj, VertexColours) {
  const auto scene = load_text("v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 0 1 0 1 0 0 1\nf 1 2 3\n");
  const Mesh& mesh = mesh_of(scene);
  ASSERT_EQ(mesh.colors.size(), 3u);
  EXPECT_NEAR(mesh.colors[0].z, 0.21404f, 1e-4f) << "sRGB 0.5 in linear light";
  EXPECT_EQ(mesh.colors[2], vec4(0, 0, 1, 1));
}

TEST(Obj, ErrorsNameTheLine) {
  struct Case {
    const char* text;
    const char* problem;
  };
  const Case cases[] = {
      {"v 0 0 0\nv 0 nan 0\n", "line 2: \"nan\" is not a finite number"},
      {"v 0 0 inf\n", "line 1: \"inf\" is not a finite number"},
      {"v 0 0 1e39\n", "line 1: \"1e39\" is not a finite number"},
      {"v 0 0 1e999\n", "not a finite number"},
      {"v 0 0 0x10\n", "line 1: \"0x10\" is not a number"},
      {"v 0 0\n", "line 1: has fewer than 3"},
      {"v 0 0 0 0 0\n", "line 1: a vertex cannot have 5"},
      {"v 0 0 0 0 0 0 0 0\n", "line 1: has more than 7"},
      {"v 0 0 0\nv 1 0 0\nv 1 1 0\n\nf 1 2 4\n", "line 5: vertex 4 does not exist: there are 3"},
      {"v 0 0 0\nf 1 1 0\n", "line 2: vertex 0 does not exist"},
      {"v 0 0 0\nf 1 1 -2\n", "line 2: vertex -2 does not exist"},
      {"v 0 0 0\nf 1 1 99999999999999999999999\n", "does not exist"},
      {"v 0 0 0\nf 1/1 1/1 1/1\n", "texture coordinate 1 does not exist"},
      {"v 0 0 0\nf 1//1 1//1 1//1\n", "normal 1 does not exist"},
      {"v 0 0 0\nf 1 1\n", "line 2: a face needs at least 3"},
      {"v 0 0 0\nf 1 1 x\n", "\"x\" is not an index"},
      {"v 0 0 0\nf 1 1 1/\n", "is not an index"},
      {"v 0 0 0\nf 1 1 1.5\n", "\".5\" is not part of a face"},
      {"v 0 0 0\nf 1/2/3/4 1 1\n", "texture coordinate 2"},
      {"v 0 0 0\n", "has no faces"},
      {"", "has no faces"},
  };
  for (const Case& c : cases) {
    const auto scene = load_text(c.text);
    ASSERT_FALSE(scene) << c.text;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_NE(scene.error().message().find(c.problem), std::string::npos)
        << scene.error().message();
  }
}

TEST(Obj, TinyNumbersAreNumbers) {
  const auto scene = load_text("v 1e-60 -1e-42 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(mesh_of(scene).positions[0].x, 0.0f);
}

TEST(Obj, UnsupportedStatementsWarnOnceAndFailWhenStrict) {
  const std::string text = kQuad + "l 1 2\np 1\nl 2 3\nf 1 2 3\n";
  const auto scene = load_text(text);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->warnings.size(), 2u);
  EXPECT_EQ(scene->warnings[0], "line 10: statement \"l\" is not supported: ignored 2 times");
  EXPECT_EQ(scene->warnings[1], "line 11: statement \"p\" is not supported: ignored 1 time");
  const auto strict = load_text(text, {.strict = true});
  ASSERT_FALSE(strict);
  EXPECT_EQ(strict.error().element, "line 10");

  std::string garbage;
  for (int i = 0; i < 100; ++i) garbage += "word" + std::to_string(i) + "\n";
  EXPECT_FALSE(load_text(garbage + kQuad + "f 1 2 3\n"));
}

TEST(Obj, TheMemoryLimitHolds) {
  std::string text = "v 0 0 0\n";
  for (int i = 0; i < 5000; ++i) text += "f 1 1 1 1 1 1 1 1\n";
  ASSERT_TRUE(load_text(text));
  const auto limited = load_text(text, {.memory_limit = 200'000});
  ASSERT_FALSE(limited);
  EXPECT_NE(limited.error().message().find("memory limit"), std::string::npos);
  EXPECT_FALSE(load_text(text, {.memory_limit = 100}));
}

// Materials.

Image8 solid(uint8_t r, uint8_t g, uint8_t b) {
  return {2, 1, {r, g, b, 255, g, r, b, 255}};
}

struct MaterialTest : testing::Test {
  TemporaryFolder folder;
  Result<Scene> load(const std::string& mtl, const LoadOptions& options = {}) {
    folder.write("a.mtl", mtl);
    return load_polygons(
        folder.write("a.obj", "mtllib a.mtl\n" + kQuad + "usemtl m\nf 1/1 2/2 3/3\n"), options);
  }
};

using ObjMaterial = MaterialTest;

TEST_F(ObjMaterial, NumbersAreMapped) {
  const auto scene = load(
      "newmtl unused\nKd 1 0 0\nnewmtl m\r\nKa 1 1 1\nKd 0.1 0.2 0.3\n"
      "Ks 0.5 0.5 0.5\nNs 30\nKe 1 2 3\nd 0.25\nNi 1.5\nillum 2\n");
  mesh_of(scene);
  EXPECT_TRUE(scene->warnings.empty());
  ASSERT_EQ(scene->materials.size(), 1u) << "only what is used";
  const Material& material = scene->materials[0];
  EXPECT_EQ(material.name, "m");
  EXPECT_EQ(material.base_color, vec4(0.1f, 0.2f, 0.3f, 0.25f));
  EXPECT_EQ(material.emissive, vec3(1, 2, 3));
  EXPECT_EQ(material.alpha_mode, AlphaMode::blend);
  EXPECT_NEAR(material.roughness, 0.5f, 1e-6f) << "(2 / (30 + 2))^(1/4)";
  EXPECT_EQ(material.metallic, 0.0f);
}

TEST_F(ObjMaterial, IllumSaysWhatCounts) {
  EXPECT_EQ(load("newmtl m\nKd 1 1 1\nKs 1 1 1\nillum 1\n")->materials[0].roughness, 1.0f);
  EXPECT_TRUE(load("newmtl m\nKd 1 1 1\nillum 0\n")->materials[0].unlit);
  const Material mirror = load("newmtl m\nKd 0 0 0\nKs 1 0.5 0\nNs 1000\nillum 3\n")->materials[0];
  EXPECT_EQ(mirror.metallic, 1.0f);
  EXPECT_EQ(mirror.base_color, vec4(1, 0.5f, 0, 1));
  EXPECT_NEAR(load("newmtl m\nTr 0.75\n")->materials[0].base_color.w, 0.25f, 1e-6f);
  const Material physical = load("newmtl m\nPr 0.3\nPm 0.6\n")->materials[0];
  EXPECT_EQ(physical.roughness, 0.3f);
  EXPECT_EQ(physical.metallic, 0.6f);
}

TEST_F(ObjMaterial, MapsAreFoundAndPlaced) {
  ASSERT_TRUE(write_png(folder.path("my colours.png"), solid(10, 20, 30)));
  std::filesystem::create_directory(folder.path("maps"));
  ASSERT_TRUE(write_png(folder.path("maps/normal.png"), solid(128, 120, 255)));
  const auto scene = load(
      "newmtl m\nKd 0 0 0\n"
      "map_Kd -s 2 4 1 -o 0.5 0.25 -clamp on my colours.png\n"
      "map_d my colours.png\nmap_Bump -bm 0.5 maps\\normal.png\n");
  mesh_of(scene);
  EXPECT_TRUE(scene->warnings.empty());
  const Material& material = scene->materials[0];
  ASSERT_EQ(scene->images.size(), 2u);
  EXPECT_EQ(material.base_color, vec4(1)) << "black beside a map means the map";
  EXPECT_EQ(material.base_color_texture.image, 0);
  EXPECT_EQ(material.base_color_texture.scale, vec2(2, 4));
  // v up 0.5 -> 0.25 + 4 * 0.5 = 2.25 up -> -1.25 down; v down 0.5 -> -3.25 + 4 * 0.5
  EXPECT_EQ(material.base_color_texture.offset, vec2(0.5f, -3.25f));
  EXPECT_EQ(material.base_color_texture.wrap_s, Wrap::clamp);
  EXPECT_EQ(material.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(material.normal_texture.image, 1);
  EXPECT_EQ(material.normal_scale, 0.5f);
}

TEST_F(ObjMaterial, MissingFilesWarn) {
  const auto no_map = load("newmtl m\nmap_Kd none.png\n");
  mesh_of(no_map);
  EXPECT_TRUE(any_contains(no_map->warnings, "\"none.png\" is missing"));
  const auto other = load("newmtl other\n");
  mesh_of(other);
  EXPECT_EQ(other->materials[0].base_color, vec4(0.8f, 0.8f, 0.8f, 1)) << "a matt light grey";
  EXPECT_TRUE(any_contains(other->warnings, "1 materials are not defined"));
  std::filesystem::remove(folder.path("a.mtl"));
  const auto no_library = load_polygons(folder.path("a.obj"), {});
  mesh_of(no_library);
  EXPECT_TRUE(any_contains(no_library->warnings, "\"a.mtl\" is missing"));
}

TEST_F(ObjMaterial, UnsupportedMapsWarnOrFailWhenStrict) {
  ASSERT_TRUE(write_png(folder.path("heights.png"), Image8{1, 1, {7, 7, 7, 255}}));
  folder.write("a.tga", "not an image that sinew knows");
  for (const char* line : {"map_Bump heights.png", "map_Kd a.tga", "map_d heights.png",
                           "map_Ns heights.png", "Kd spectral a.rfl", "Tf 1 1 1"}) {
    const std::string mtl = std::string("newmtl m\n") + line + "\n";
    const auto scene = load(mtl);
    mesh_of(scene);
    EXPECT_EQ(scene->warnings.size(), 1u) << line;
    const auto strict = load(mtl, {.strict = true});
    ASSERT_FALSE(strict) << line;
    EXPECT_EQ(strict.error().element, "line 2");
  }
}

TEST_F(ObjMaterial, NothingOutsideTheFolderIsRead) {
  TemporaryFolder elsewhere;
  const std::string outside = elsewhere.path("outside.png");
  ASSERT_TRUE(write_png(outside, solid(1, 2, 3)));
  std::filesystem::create_symlink(outside, folder.path("link.png"));
  for (const std::string& name :
       {outside, std::string("link.png"), std::string("../a.png"), std::string("x/../../b.png"),
        std::string("..\\a.png"), std::string(".")}) {
    const auto scene = load("newmtl m\nmap_Kd " + name + "\n");
    ASSERT_FALSE(scene) << name;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_NE(scene.error().problem.find("outside"), std::string::npos) << name;
  }
  EXPECT_FALSE(
      load_polygons(folder.write("b.obj", "mtllib ../../etc/passwd\n" + kQuad + "f 1 2 3\n"), {}));
}

TEST_F(ObjMaterial, DamagedLibrariesAndMapsAreErrors) {
  folder.write("bad.png", "\x89PNG\r\n\x1a\n and no more");
  for (const char* mtl :
       {"Kd 1 1 1\n", "newmtl m\nKd 1 nan 1\n", "newmtl m\nKd 1 2\n", "newmtl m\nNs x\n",
        "newmtl m\nd\n", "newmtl m\nmap_Kd\n", "newmtl m\nmap_Kd -s\n",
        "newmtl m\nmap_Kd -bm inf a.png\n", "newmtl m\nmap_Kd -what a.png\n",
        "newmtl m\nillum 1e9\n", "newmtl m\nmap_Kd bad.png\n"}) {
    const auto scene = load(mtl);
    ASSERT_FALSE(scene) << mtl;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
  }
}

// Hostile files.

const std::string kSmallObj =
    "mtllib a.mtl\n" + kQuad +
    "vn 0 1 0\nusemtl m\ns off\nf 1/1/1 2/2/1 3/3/1 4/4/2\nusemtl n\nf -4 -3 \\\n -2\nl 1 2\n";
const std::string kSmallMtl =
    "newmtl m\nKd 0.1 0.2 0.3\nKs 1 1 1\nNs 10\nd 0.5\nillum 2\nmap_Kd -s 1 2 -o 3 a.png\n"
    "map_Bump -bm 0.5 a.png\nnewmtl n\nTr 0.5\nKe 1 1 1\n";

void expect_scene_or_error(const Result<Scene>& scene) {
  if (scene) {
    EXPECT_EQ(validate(*scene), "");
  } else {
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input) << scene.error().message();
    EXPECT_FALSE(scene.error().problem.empty());
    EXPECT_FALSE(scene.error().file.empty());
  }
}

struct HostileObj : testing::Test {
  TemporaryFolder folder;
  void SetUp() override {
    folder.write("a.mtl", kSmallMtl);
    folder.write("a.obj", kSmallObj);
    ASSERT_TRUE(write_png(folder.path("a.png"), solid(1, 2, 3)));
    ASSERT_TRUE(load_polygons(folder.path("a.obj"), {}));
  }
};

TEST_F(HostileObj, EveryTruncation) {
  for_every_truncation(kSmallObj, [&](const std::string& bytes) {
    expect_scene_or_error(load_polygons(folder.write("b.obj", bytes), {}));
  });
  for_every_truncation(kSmallMtl, [&](const std::string& bytes) {
    folder.write("a.mtl", bytes);
    expect_scene_or_error(load_polygons(folder.path("a.obj"), {}));
  });
}

TEST_F(HostileObj, RandomPatches) {
  for_random_patches(kSmallObj, 4000, 31, [&](const std::string& bytes) {
    expect_scene_or_error(load_polygons(folder.write("b.obj", bytes), {}));
  });
  for_random_patches(kSmallMtl, 4000, 32, [&](const std::string& bytes) {
    folder.write("a.mtl", bytes);
    expect_scene_or_error(load_polygons(folder.path("a.obj"), {}));
  });
}

TEST_F(HostileObj, AbsurdShapes) {
  // One polygon of a million corners, a hundred thousand materials, a line without an end.
  std::string polygon = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 300'000; ++i) polygon += " 1 2 3";
  expect_scene_or_error(load_text(polygon));
  std::string materials = "v 0 0 0\n";
  for (int i = 0; i < 100'000; ++i) materials += "usemtl " + std::to_string(i) + "\nf 1 1 1\n";
  expect_scene_or_error(load_text(materials));
  std::string continued = "v 0 0 0\nf";
  for (int i = 0; i < 100'000; ++i) continued += " 1\\\n";
  expect_scene_or_error(load_text(continued));
  expect_scene_or_error(load_text(std::string(1'000'000, '\0')));
  expect_scene_or_error(load_text(std::string(1'000'000, '/')));
}

TEST(Obj, RealFilesHoldWhatTheirReadmeSays) {
  SINEW_DATA_OR_SKIP(data, "vertex-cache");
  const auto cloth = load_polygons(data + "/cloth-drapes/base.obj", {});
  EXPECT_EQ(mesh_of(cloth).positions.size(), 58'081u);
  EXPECT_EQ(mesh_of(cloth).triangles.size(), 115'200u);
  EXPECT_TRUE(mesh_of(cloth).normals.empty());
  EXPECT_EQ(mesh_of(cloth).texcoords[0].size(), 58'081u);
  const auto face = load_polygons(data + "/ict-facekit/generic_neutral_mesh.obj", {});
  EXPECT_EQ(mesh_of(face).positions.size(), 26'719u);
  EXPECT_EQ(mesh_of(face).triangles.size(), 52'220u);
  EXPECT_EQ(mesh_of(face).parts.size(), 12u);
  EXPECT_EQ(mesh_of(face).corners.size(), 52'220u);
}

}  // namespace
}  // namespace sinew
