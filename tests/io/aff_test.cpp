#include "sinew/io/aff/aff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "io/hostile.h"
#include "sinew/io/aff/material.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

const std::string kTriangle = "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 2\n";
const std::string kView = "v from 0 2 5 at 0 2 0 up 0 1 0 angle 45 hither 0.1 resolution 8 6\n";

// 2 x 2 pixels: red, green / blue, white.
const std::string kPpm = std::string("P6 # a comment\n2 2\n255\n") +
                         std::string("\xff\0\0\0\xff\0\0\0\xff\xff\xff\xff", 12);

struct AffTest : testing::Test {
  TemporaryFolder folder;

  std::string write(const std::string& name, const std::string& text) {
    return folder.write("aff/" + name, text);
  }
  Result<Scene> load(const std::string& text, const AffOptions& aff = {},
                     const LoadOptions& options = {}) {
    return load_aff(write("top.aff", text), aff, options);
  }
  Scene loaded(const std::string& text) {
    Result<Scene> scene = load(text);
    EXPECT_TRUE(scene) << scene.error().message();
    if (!scene) return {};
    EXPECT_EQ(validate(*scene), "");
    return std::move(*scene);
  }
  void expect_error(const std::string& text, const std::string& line, const std::string& part) {
    const Result<Scene> scene = load(text);
    ASSERT_FALSE(scene) << text;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(scene.error().element, "line " + line) << scene.error().message();
    EXPECT_NE(scene.error().message().find(part), std::string::npos) << scene.error().message();
  }
};

using Aff = AffTest;

bool any_contains(const std::vector<std::string>& texts, const std::string& part) {
  return std::ranges::any_of(
      texts, [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

TEST_F(Aff, CommentsBracesAndLineEndsInAllForms) {
  const Scene scene = loaded("# one\r\n%two\r\nxs 1 1 1 0 0 1 0.0 0 0 0{" + kTriangle +
                             "}\n  # three } {\nb 0 0 0.5% four");
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.meshes[0].name, "top");
  EXPECT_NEAR(scene.environment.zenith.z, 0.21404f, 1e-4f) << "as a screen shows it";
  EXPECT_EQ(scene.environment.ambient, vec3(0.0f));
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.clips.empty());
}

TEST_F(Aff, ViewsAndTiming) {
  const Scene scene = loaded(kView + "a -1 5 300\n");
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_FLOAT_EQ(scene.cameras[0].yfov, glm::radians(45.0f));
  EXPECT_FLOAT_EQ(scene.cameras[0].znear, 0.1f);
  const vec3 forward = scene.nodes[0].rotation * vec3(0, 0, -1);
  EXPECT_NEAR(distance(forward, vec3(0, 0, -1)), 0.0f, 1e-6f);
  EXPECT_EQ(scene.default_frames, 300);
  EXPECT_DOUBLE_EQ(scene.default_fps, 299.0 / 6.0) << "the last frame shows the end";
  ASSERT_EQ(scene.clips.size(), 1u);
  EXPECT_EQ(scene.clips[0].start, -1.0);
  EXPECT_EQ(scene.clips[0].end, 5.0);
}

TEST_F(Aff, ViewsLookWhereTheyAreTold) {
  const Scene scene =
      loaded("v from 1 2 3 at 4 -2 8 up 0.3 1 0 angle 30 hither 1 resolution 1 1\n");
  const quat rotation = scene.nodes[0].rotation;
  EXPECT_NEAR(distance(rotation * vec3(0, 0, -1), normalize(vec3(3, -4, 5))), 0.0f, 1e-6f);
  EXPECT_GT(dot(rotation * vec3(0, 1, 0), vec3(0.3f, 1, 0)), 0.0f);
  EXPECT_NEAR(dot(rotation * vec3(1, 0, 0), vec3(0.3f, 1, 0)), 0.0f, 1e-6f);
}

TEST_F(Aff, LightsKeepTheirStrengthAtEveryDistance) {
  const Scene scene = loaded("l 1 2 3\nl 4 5 6 0.1 0.2 0.3\nla lamp 7 8 9 1 1 1\n" +
                             std::string("k lamp { transl 4 0 0 0 0 0 0 0 1 1 0 0 0 0 0 "
                                         "2 2 0 0 0 0 0 3 3 0 0 0 0 0 }"));
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].color, vec3(1.0f));
  EXPECT_EQ(scene.lights[1].color, vec3(0.1f, 0.2f, 0.3f));
  EXPECT_FALSE(scene.lights[1].falloff);
  EXPECT_FLOAT_EQ(scene.lights[1].intensity, 3.14159265f) << "diffuse surfaces divide by pi";
  EXPECT_EQ(scene.nodes[1].translation, vec3(4, 5, 6));
  ScenePose pose;
  sample(scene, 0, 1.5, pose);
  EXPECT_EQ(pose.nodes[2][3], vec3(1.5f, 0, 0)) << "keys replace the place of an animated light";
}

TEST_F(Aff, MaterialsKeepEnergyAndMirror) {
  aff::Fill fill;
  fill.diffuse = vec3(0.2f, 0.3f, 0.4f);
  fill.specular = vec3(0.5f, 0.4f, 0.3f);
  fill.shine = 50.0f;
  Material material = aff::convert(fill);
  EXPECT_EQ(vec3(material.base_color), fill.diffuse);
  const float f0 = 0.2f * 0.2f;  // of the index 1.5
  EXPECT_NEAR(f0 * material.specular_color.x, 0.5f, 1e-6f);
  EXPECT_LE(material.roughness, 0.2f) << "sharp reflections";
  EXPECT_EQ(material.transmission, 0.0f);

  fill.transmittance = 0.5f;
  material = aff::convert(fill);
  EXPECT_TRUE(material.thin) << "no index of refraction";
  EXPECT_NEAR(material.transmission * material.base_color.y, 0.8f * 0.5f / 0.8f, 1e-6f);

  fill.ior = 1.55f;
  material = aff::convert(fill);
  EXPECT_FALSE(material.thin);
  EXPECT_EQ(material.ior, 1.55f);

  fill = {};
  fill.shine = 30.0f;
  EXPECT_EQ(aff::convert(fill).roughness, 1.0f) << "no highlight without Ks";
  fill.specular = vec3(0.05f);
  EXPECT_FLOAT_EQ(aff::convert(fill).roughness, 0.5f) << "2 / r^4 - 2 = 30";
}

TEST_F(Aff, FillsHoldOnThroughBracesAndIncludes) {
  write("param.aff", "fm 0 0 0 0.1 0.2 0.3 0 0 0 1 0 0\n");
  const Scene scene = loaded("am 2 2 2\nf 0.5 1 1 0.5 0 1 0 0\n" + kTriangle +
                             "xs 1 1 1 0 0 1 0 0 0 0 { i 0 param.aff }\n" + kTriangle +
                             "fm 0.2 0.2 0.2 0 0 0 0 0 0 0 0 0\n" + kTriangle);
  ASSERT_EQ(scene.meshes.size(), 1u) << "a file of materials is no object";
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].base_color, vec4(0.25f, 0.5f, 0.5f, 1));
  EXPECT_EQ(scene.materials[1].base_color, vec4(0.1f, 0.2f, 0.3f, 1));
  EXPECT_EQ(scene.meshes[0].material_of(2), 2u);
  EXPECT_NEAR(scene.materials[2].emissive.x, 0.13287f, 1e-4f) << "a display value of 0.4";
  EXPECT_EQ(scene.materials[0].emissive, vec3(0.0f)) << "NFF has no ambient colour";
}

TEST_F(Aff, StaticTransformsScaleThenTurnThenMove) {
  const Scene scene = loaded("xs 2 2 2 0 0 1 90 10 0 0 {\nxs 1 3 1 0 0 1 0 0 0 1 {" + kTriangle +
                             "}" + kTriangle + "}" + kTriangle);
  const auto& p = scene.meshes[0].positions;
  ASSERT_EQ(p.size(), 9u);
  const auto near = [](vec3 a, vec3 b) { return distance(a, b) < 1e-5f; };
  EXPECT_TRUE(near(p[1], vec3(10, 2, 2))) << "the inner one first";
  EXPECT_TRUE(near(p[2], vec3(4, 0, 2)));
  EXPECT_TRUE(near(p[4], vec3(10, 2, 0)));
  EXPECT_EQ(p[7], vec3(1, 0, 0));
}

TEST_F(Aff, MirroringTransformsKeepTheOutsideOutside) {
  const Scene scene = loaded(
      "xs -1 1 1 0 0 1 0 0 0 0 {"
      "m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1 "
      "triangles 1 0 1 2 0 0 0 }");
  const Mesh& mesh = scene.meshes[0];
  const uvec3 t = mesh.triangles[0];
  const vec3 face =
      cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
  EXPECT_GT(face.z, 0.0f);
  EXPECT_EQ(mesh.normals[mesh.corners[0].x], vec3(0, 0, 1));
}

TEST_F(Aff, MeshesHaveTheirOwnIndicesForNormalsAndCoordinates) {
  folder.write("TextureFiles/t.ppm", kPpm);
  const Scene scene = loaded(
      "m vertices 4 0 0 0 1 0 0 1 1 0 0 1 0 normals 2 0 0 2 0 3 4 texturecoords 3 t.ppm 0 0 1 0 "
      "0.5 1 triangles 2 0 1 2 0 0 1 2 1 0 0 2 3 0 1 1 2 0 1\n" +
      kTriangle);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
  EXPECT_EQ(mesh.normals[mesh.corners[0].z], vec3(0, 0.6f, 0.8f));
  EXPECT_EQ(mesh.texcoords[0][mesh.corners[0].x], vec2(0.5f, 1));
  EXPECT_EQ(mesh.corners[0].x, mesh.corners[1].x) << "equal corners are stored once";
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_FALSE(mesh.parts[0].flat);
  EXPECT_TRUE(mesh.parts[1].flat) << "no normals";
  const Material& material = scene.materials[mesh.material_of(0)];
  EXPECT_EQ(material.base_color_texture.image, 0);
  EXPECT_EQ(scene.images[0].at(1, 0)[1], 255) << "the first row is v = 0";
  EXPECT_EQ(scene.materials[mesh.material_of(2)].base_color_texture.image, -1);
}

TEST_F(Aff, PolygonsPatchesAndTexturedTriangles) {
  write("t.ppm", kPpm);
  const Scene scene = loaded(
      "p 5 0 0 0 2 0 0 2 1 0 1 2 0 0 1 0\n"
      "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n"
      "tt t.ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n"
      "ttp t.ppm 0 0 0 0 0 1 0 1 1 0 0 0 0 1 1 1 0 1 0 0 0 1 1 0\n");
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.triangles.size(), 6u);
  EXPECT_EQ(mesh.triangles[2], uvec3(0, 3, 4));
  ASSERT_EQ(mesh.parts.size(), 4u);
  EXPECT_EQ(std::ranges::count(mesh.parts, true, &MeshPart::flat), 2);
  EXPECT_EQ(mesh.texcoords[0][mesh.corners[4].x], vec2(0, 1));
  EXPECT_EQ(scene.materials.size(), 2u);
}

TEST_F(Aff, SpheresAndConesAreRoundAndFaceOutwards) {
  for (const float side : {1.0f, -1.0f}) {
    const std::string r = side > 0 ? "2" : "-2";
    const Scene scene = loaded("s 1 2 3 " + r + "\n");
    const Mesh& mesh = scene.meshes[0];
    double area = 0.0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const uvec3 t = mesh.triangles[i];
      const vec3 a = mesh.positions[t.x];
      const vec3 face = cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
      EXPECT_GT(dot(face, a - vec3(1, 2, 3)) * side, 0.0f);
      EXPECT_GT(dot(face, mesh.normals[mesh.corners[i].x]), 0.0f);
      EXPECT_NEAR(distance(a, vec3(1, 2, 3)), 2.0f, 1e-5f);
      area += 0.5 * length(face);
    }
    EXPECT_NEAR(area, 4.0 * 3.14159265 * 4.0, 1.0) << "closed";
  }
  const Scene cone = loaded("c 0 0 0 1  0 0 2 0\n");
  const Scene cylinder = loaded("c 0 0 0 1  0 0 2 1\n");
  EXPECT_EQ(cone.meshes[0].triangles.size(), 32u);
  EXPECT_EQ(cylinder.meshes[0].triangles.size(), 64u);
  for (const Scene* scene : {&cone, &cylinder}) {
    const Mesh& mesh = scene->meshes[0];
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      const uvec3 t = mesh.triangles[i];
      const vec3 a = mesh.positions[t.x];
      const vec3 face = cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
      EXPECT_GT(dot(face, mesh.normals[mesh.corners[i].x]), 0.9f * length(face));
      EXPECT_GT(dot(face, vec3(a.x, a.y, 0)), 0.0f);
    }
  }
}

TEST_F(Aff, AnimatedTransformsBecomeNodesThatKeysMove) {
  const Scene scene =
      loaded("x arm {\nxs 1 1 1 0 0 1 0 0 5 0 {\nx hand {" + kTriangle + "} } }\n" +
             "k hand { rot 4 0 0 0 1 0 0 0 0  1 0 0 1 0 0 0 0  2 0 0 1 90 0 0 0  3 0 0 1 90 0 0 0\n"
             "scale 4 0 1 1 1 0 0 0 1 1 1 1 0 0 0 2 3 3 3 0 0 0 3 3 3 3 0 0 0 }\n"
             "k arm { transl 4 0 0 0 0 0 0 0 1 0 0 0 0 0 0 2 7 0 0 0 0 0 3 7 0 0 0 0 0\n"
             "visibility 2 1.5 0 1.75 1 }\na 1 2 11\n");
  ASSERT_EQ(scene.nodes.size(), 4u) << "arm, the way to the hand, hand, its mesh";
  EXPECT_EQ(scene.nodes[2].name, "hand");
  ScenePose pose;
  sample(scene, 0, 2.0, pose);
  const vec3 tip = transform_point(pose.nodes[3], vec3(1, 0, 0));
  EXPECT_NEAR(distance(tip, vec3(7, 5 + 3, 0)), 0.0f, 1e-5f) << "scaled, turned, moved";
  for (const auto& [time, visible] : {std::pair(1.0, 1), {1.6, 0}, {1.75, 1}, {9.0, 1}}) {
    sample(scene, 0, time, pose);
    EXPECT_EQ(int{pose.visible[3]}, visible) << time;
  }
}

TEST_F(Aff, CamerasFollowTheirKeys) {
  const Scene scene =
      loaded(kView +
             "k camera { transl 4 0 1 2 3 0 0 0 1 1 2 3 0 0 0 2 4 5 6 0 0 0 3 4 5 6 0 0 0\n"
             "rot 4 0 0 1 0 90 0 0 0 1 0 1 0 90 0 0 0 2 0 1 0 90 0 0 0 3 0 1 0 90 0 0 0 }");
  ScenePose pose;
  sample(scene, 0, 2.0, pose);
  EXPECT_NEAR(distance(pose.nodes[0][3], vec3(4, 5, 6)), 0.0f, 1e-6f);
  EXPECT_NEAR(distance(-pose.nodes[0][2], vec3(-1, 0, 0)), 0.0f, 1e-6f);
  EXPECT_EQ(scene.clips[0].start, 1.0) << "without timing, as long as there are keys";
  EXPECT_EQ(scene.clips[0].end, 2.0);
}

TEST_F(Aff, IncludedFilesAreObjectsAndRepeatedOnesShareAMesh) {
  write("part.aff", "fm 0 0 0 1 0 0 0 0 0 0 0 0\ni 0 leaf.aff\n" + kTriangle);
  write("leaf.aff", kTriangle);
  const Scene scene = loaded(
      "i 0 part.aff\nxs 1 1 1 0 0 1 0 0 3 0 { i 0 part.aff }\n"
      "x mover { i 0 part.aff }\nk mover { visibility 1 5 1 }\n");
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.meshes[0].name, "part");
  EXPECT_EQ(scene.meshes[0].triangles.size(), 2u) << "with what it includes";
  ScenePose pose;
  sample(scene, kRestPose, 0.0, pose);
  EXPECT_EQ(pose.objects[1].placement[3], vec3(0, 3, 0));
  EXPECT_EQ(scene.nodes[scene.objects[2].node].parent, 0);
}

TEST_F(Aff, TheFinestDetailIsTakenUntilTheFileNamesALevel) {
  write("fine.aff", kTriangle);
  EXPECT_EQ(count(loaded("i 0 fine.aff\ni 9 fine.aff\n")).triangles, 2u);
  EXPECT_EQ(count(loaded("d 3\ni 3 fine.aff\ni 4 fine.aff\n")).triangles, 1u);
}

TEST_F(Aff, AnimatedTrianglesBecomeKeys) {
  const std::string normals[2] = {" 0 0 1\n", " 0 0.1 1\n"};
  std::string text;
  for (int i = 0; i < 2; ++i) {
    const std::string far = i == 0 ? "1 0 0" : "1 1 0";
    text += "tpa 2 -1 0 0 0" + normals[0] + far + normals[i] + "0 1 0" + normals[0] + "4 0 0 9" +
            normals[0] + far + normals[i] + "0 1 9" + normals[0];
  }
  const Scene scene = loaded(text);
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.keys, 2u);
  EXPECT_EQ(mesh.positions.size(), 4u) << "corners that stand together at all times are one";
  EXPECT_EQ(mesh.key_positions[4], vec3(0, 0, 9));
  const Channel& channel = scene.clips[0].channels[0];
  EXPECT_EQ(channel.path, ChannelPath::cache_key);
  EXPECT_EQ(channel.times, (std::vector<float>{-1, 4}));
  EXPECT_EQ(channel.values, (std::vector<float>{0, 1}));
  ScenePose pose;
  sample(scene, 0, 1.5, pose);
  EXPECT_FLOAT_EQ(pose.objects[0].key_fraction, 0.5f);
}

TEST_F(Aff, TexturesLieBesideTheFileOrInTheirOwnFolder) {
  const std::string use = "tt %.ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n";
  const auto with = [&](const std::string& name) { return "tt " + name + use.substr(8); };
  write("beside.ppm", kPpm);
  folder.write("TextureFiles/own.ppm", kPpm);
  folder.write("elsewhere/far.ppm", kPpm);
  EXPECT_EQ(loaded(with("beside.ppm") + with("own.ppm") + with("beside.ppm")).images.size(), 2u);
  expect_error("\n" + with("../elsewhere/far.ppm"), "2", "outside");
  expect_error(with("/etc/passwd"), "1", "outside");
  const Scene scene = loaded(with("missing.ppm"));
  EXPECT_TRUE(any_contains(scene.warnings, "\"missing.ppm\" is missing"));
  write("text.ppm", "hello");
  expect_error(with("text.ppm"), "1", "neither PPM");
}

TEST_F(Aff, WhatNothingAnswersToIsNamed) {
  const Scene scene = loaded("k ghost { visibility 1 0 1 }\n" + kTriangle);
  EXPECT_TRUE(any_contains(scene.warnings, "\"ghost\" move nothing"));
}

TEST_F(Aff, ComplexityNeedsAnimatedTriangles) {
  const Result<Scene> none = load(kTriangle, {.complexity = 8});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::usage);
  const Result<Scene> few =
      load("tpa 1 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n", {.complexity = 8});
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().kind, ErrorKind::usage);
  EXPECT_NE(few.error().message().find("1 animated triangles"), std::string::npos);
}

TEST(AffInput, OptionsComeBeforeThePath) {
  EXPECT_EQ(parse_aff_input("a/b.aff")->path, "a/b.aff");
  const auto input = parse_aff_input("complexity=8,a,b=c.aff");
  ASSERT_TRUE(input) << input.error().message();
  EXPECT_EQ(input->options.complexity, 8);
  EXPECT_EQ(input->path, "a,b=c.aff");
  for (const char* bad : {"complexity=4,a.aff", "complexity=9,a.aff", "complexity=,a.aff",
                          "complexity=8x,a.aff", "speed=3,a.aff", "", "complexity=8,"}) {
    const auto result = parse_aff_input(bad);
    ASSERT_FALSE(result) << bad;
    EXPECT_EQ(result.error().kind, ErrorKind::usage);
    EXPECT_FALSE(result.error().remedy.empty());
  }
}

TEST_F(Aff, IsLoadedByItsName) {
  const std::string path = write("scene.AFF", kTriangle);
  EXPECT_EQ(sinew::load(path)->name, "scene");
  EXPECT_EQ(sinew::load("aff:" + path)->name, "scene");
  EXPECT_EQ(sinew::load("aff:complexity=8," + path).error().kind, ErrorKind::usage);
}

}  // namespace
}  // namespace sinew
