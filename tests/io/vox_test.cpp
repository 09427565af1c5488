// MagicaVoxel's files: models, scene graphs, frames, materials; read, written, made bad.
#include "sinew/io/vox/vox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "io/hostile.h"
#include "io/vox_builder.h"
#include "sinew/io/load.h"
#include "sinew/math/srgb.h"
#include "sinew/scene/sample.h"
#include "svo/svo_oracle.h"

namespace sinew {
namespace {

using namespace test;

Result<Scene> parse(const std::string& bytes, const LoadOptions& options = {}) {
  return parse_vox({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "a.vox",
                   options);
}

// Middles of all voxels that are shown at the time, in the world, in file voxels; with colours.
struct ShownVoxel {
  glm::ivec3 twice;  // the middle times two: whole numbers
  uint16_t color;
  auto operator<=>(const ShownVoxel& other) const {
    return std::array{twice.x, twice.y, twice.z, int{color}} <=>
           std::array{other.twice.x, other.twice.y, other.twice.z, int{other.color}};
  }
  bool operator==(const ShownVoxel&) const = default;
};
std::vector<ShownVoxel> shown(const Scene& scene, double time, float side = kVoxSide) {
  ScenePose pose;
  sample(scene, scene.clips.empty() ? kRestPose : 0, time, pose);
  std::vector<ShownVoxel> out;
  for (size_t i = 0; i < scene.voxels.size(); ++i) {
    if (!pose.voxels[i].present) continue;
    const Svo& svo = scene.octrees[scene.voxels[i].octree];
    for (const ReadVoxel& voxel : read_voxels(svo)) {
      const vec3 world = transform_point(pose.voxels[i].placement, svo.grid.center(voxel.voxel));
      const vec3 twice = 2.0f * world / side;
      EXPECT_LT(length(twice - glm::round(twice)), 1e-3f);
      out.push_back({glm::ivec3(glm::round(twice)), voxel.color});
    }
  }
  std::ranges::sort(out);
  return out;
}
std::vector<glm::ivec3> places(const std::vector<ShownVoxel>& voxels) {
  std::vector<glm::ivec3> out;
  for (const ShownVoxel& voxel : voxels) out.push_back(voxel.twice);
  return out;
}
// Of the file's voxel at (x, y, z) in the world: +Z up becomes +Y up.
glm::ivec3 middle(int x, int y, int z) {
  return {2 * x + 1, 2 * z + 1, -2 * y - 1};
}

TEST(Vox, OneModelStandsOnTheGround) {
  const Result<Scene> scene =
      parse(vox_file(vox_model(3, 5, 4, {{0, 0, 0, 1}, {2, 4, 3, 2}}), 150));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(validate(*scene), "");
  ASSERT_EQ(scene->octrees.size(), 1u);
  EXPECT_TRUE(scene->clips.empty());
  const std::vector<ShownVoxel> voxels = shown(*scene, 0.0);
  ASSERT_EQ(voxels.size(), 2u);
  EXPECT_EQ(voxels[0].twice, middle(-1, -2, 0));
  EXPECT_EQ(voxels[1].twice, middle(1, 2, 3));
  EXPECT_EQ(voxels[0].color, pack_color(vec3(1.0f)));  // of the palette that all have
  EXPECT_EQ(voxels[1].color, pack_color(vec3(1.0f, 1.0f, srgb_to_linear(0.8f))));
}

TEST(Vox, TheLastOfSeveralVoxelsCountsAndColourNoneIsNone) {
  const Result<Scene> scene =
      parse(vox_file(vox_model(4, 4, 4, {{1, 1, 1, 1}, {2, 2, 2, 0}, {1, 1, 1, 225}})));
  ASSERT_TRUE(scene) << scene.error().message();
  const std::vector<ShownVoxel> voxels = shown(*scene, 0.0);
  ASSERT_EQ(voxels.size(), 1u);
  EXPECT_EQ(unpack_color(voxels[0].color).y, 0.0f);  // the darkest red
}

// Transforms, groups, a rotation by a quarter about z, a mirror, hidden things.
TEST(Vox, PlacesModels) {
  const std::string models = vox_model(2, 2, 2, {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 0, 1, 1}});
  const std::string graph =
      vox_transform(0, 1, {}, {{}}) + vox_group(1, {2, 4, 6, 8}) +
      vox_transform(2, 3, {{"_name", "moved"}}, {{{"_t", "10 20 30"}}}) + vox_shape(3, {{0, {}}}) +
      // x from -y, y from x: row 0 has column 1, row 1 column 0, the first sign is minus.
      vox_transform(4, 5, {}, {{{"_r", std::to_string(1 | 0 << 2 | 1 << 4)}}}) +
      vox_shape(5, {{0, {}}}) +
      // z mirrored
      vox_transform(6, 7, {}, {{{"_r", std::to_string(0 | 1 << 2 | 1 << 6)}, {"_t", "-5 0 0"}}}) +
      vox_shape(7, {{0, {}}}) + vox_transform(8, 9, {{"_hidden", "1"}}, {{}}) +
      vox_shape(9, {{0, {}}});
  const Result<Scene> scene = parse(vox_file(models + graph));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(validate(*scene), "");
  EXPECT_EQ(scene->octrees.size(), 1u);
  EXPECT_EQ(scene->voxels.size(), 4u);
  std::vector<glm::ivec3> expected = {middle(9, 19, 29), middle(10, 19, 29), middle(9, 19, 30)};
  // Corner (x, y) of [-1, 1]^2 goes to (-y, x).
  for (const auto& v : {middle(0, -1, -1), middle(0, 0, -1), middle(0, -1, 0)})
    expected.push_back(v);
  for (const auto& v : {middle(-6, -1, 0), middle(-5, -1, 0), middle(-6, -1, -1)})
    expected.push_back(v);
  std::vector<glm::ivec3> found = places(shown(*scene, 0.0));
  const auto less = [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  std::ranges::sort(expected, less);
  std::ranges::sort(found, less);
  EXPECT_EQ(found, expected);
  EXPECT_TRUE(std::ranges::any_of(scene->nodes, [](const Node& n) { return n.name == "moved"; }));
}

TEST(Vox, FramesBecomeAClip) {
  const std::string models = vox_model(2, 2, 2, {{0, 0, 0, 1}}) +
                             vox_model(2, 2, 2, {{1, 1, 1, 1}}) + vox_model(1, 1, 1, {});
  const std::string graph =
      vox_transform(0, 1, {}, {{}}) + vox_group(1, {2}) +
      vox_transform(2, 3, {}, {{{"_f", "0"}}, {{"_f", "3"}, {"_t", "7 0 0"}}}) +
      vox_shape(3, {{0, {{"_f", "0"}}}, {1, {{"_f", "2"}}}, {2, {{"_f", "5"}}}});
  const Result<Scene> scene = parse(vox_file(models + graph));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(validate(*scene), "");
  ASSERT_EQ(scene->clips.size(), 1u);
  EXPECT_NEAR(scene->clips[0].end, 6 / kVoxFps, 1e-9);
  const auto at = [&](int frame) { return places(shown(*scene, (frame + 0.5) / kVoxFps)); };
  using Places = std::vector<glm::ivec3>;
  EXPECT_EQ(at(0), Places{middle(-1, -1, -1)});
  EXPECT_EQ(at(1), Places{middle(-1, -1, -1)});
  EXPECT_EQ(at(2), Places{middle(0, 0, 0)});
  EXPECT_EQ(at(3), Places{middle(7, 0, 0)});
  EXPECT_EQ(at(5), Places{});
}

TEST(Vox, ModelsWithoutASceneAreFrames) {
  const Result<Scene> scene =
      parse(vox_file(vox_chunk("PACK", vox_number(2)) + vox_model(2, 2, 2, {{0, 0, 0, 1}}) +
                         vox_model(2, 2, 2, {{1, 1, 1, 1}}),
                     150));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->clips.size(), 1u);
  EXPECT_EQ(places(shown(*scene, 0.0)), std::vector{middle(-1, -1, 0)});
  EXPECT_EQ(places(shown(*scene, 1.5 / kVoxFps)), std::vector{middle(0, 0, 1)});
}

TEST(Vox, Materials) {
  const std::string file =
      vox_file(vox_model(4, 1, 1, {{0, 0, 0, 1}, {1, 0, 0, 2}, {2, 0, 0, 3}, {3, 0, 0, 4}}) +
               vox_material(2, {{"_type", "_metal"}, {"_metal", "0.75"}, {"_rough", "0.25"}}) +
               vox_material(3, {{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "1"}}) +
               vox_material(4, {{"_type", "_glass"}}) + vox_material(9, {{"_type", "_metal"}}));
  const Result<Scene> scene = parse(file);
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->materials.size(), 3u);  // glass is as the plain one, colour 9 is nowhere
  EXPECT_EQ(scene->materials[1].metallic, 0.75f);
  EXPECT_EQ(scene->materials[1].roughness, 0.25f);
  EXPECT_NEAR(scene->materials[2].emissive.x, 5.0f, 1e-5f);
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_NE(scene->warnings[0].find("glass"), std::string::npos);
  EXPECT_FALSE(parse(file, {.strict = true}));
}

// A ball's normals point outwards.
TEST(Vox, NormalsFollowTheSurface) {
  std::vector<std::array<uint8_t, 4>> voxels;
  const vec3 center(15.5f);
  for (int z = 0; z < 32; ++z) {
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        if (length(vec3(x, y, z) - center) > 14.0f) continue;
        voxels.push_back({uint8_t(x), uint8_t(y), uint8_t(z), 1});
      }
    }
  }
  const Result<Scene> scene = parse(vox_file(vox_model(32, 32, 32, voxels)));
  ASSERT_TRUE(scene) << scene.error().message();
  size_t surface = 0;
  for (const ReadVoxel& v : read_voxels(scene->octrees[0])) {
    const vec3 away = vec3(v.voxel) - center;
    if (length(away) < 13.0f) continue;
    ++surface;
    EXPECT_GT(dot(unpack_normal(v.normal), normalize(away)), 0.9f);
  }
  EXPECT_GT(surface, 1000u);
}

// ---- written and read again ----

std::vector<Material> some_materials() {
  std::vector<Material> materials(3);
  materials[1].metallic = 1.0f;
  materials[1].roughness = 0.5f;
  materials[2].emissive = vec3(3.0f, 3.0f, 3.0f);
  return materials;
}

// What the file must show: voxels of all objects in voxels of the world, with +Y up.
std::map<std::array<int, 3>, uint16_t> expected_voxels(std::span<const VoxObject> objects,
                                                       size_t frame) {
  std::map<std::array<int, 3>, uint16_t> out;
  for (const VoxObject& object : objects) {
    const auto origin = glm::ivec3(glm::round(object.grid.origin / object.grid.voxel));
    for (const PlainVoxel& v : object.frames[std::min(frame, object.frames.size() - 1)]) {
      const glm::ivec3 at = 2 * (origin + glm::ivec3(voxel_of(v.voxel))) + 1;
      out[{at.x, at.y, at.z}] = v.color;
    }
  }
  return out;
}

uint16_t few_colors(uint32_t bits) {
  return pack_color(vec3(float(bits % 3), float(bits / 3 % 3), float(bits / 9 % 3)) * 0.5f);
}

TEST(Vox, WrittenFilesComeBack) {
  const TemporaryFolder folder;
  std::vector<VoxObject> objects(2);
  for (size_t i = 0; i < objects.size(); ++i) {
    objects[i].name = i == 0 ? "ball" : "block";
    objects[i].grid = {vec3(i == 0 ? -70.0f : 200.0f, 3.0f, -9.0f), 0.5f, uvec3(i == 0 ? 300 : 40)};
    for (uint32_t frame = 0; frame < (i == 0 ? 4u : 1u); ++frame) {
      const uint32_t seed = 5 + (frame == 2 ? 1 : frame);  // frame 2 is as frame 1
      auto voxels = random_voxels(objects[i].grid.resolution.x, 3000, 3, seed);
      for (PlainVoxel& v : voxels) v.color = few_colors(v.color);
      objects[i].frames.push_back(std::move(voxels));
    }
  }
  const Result<SavedVox> report = save_vox(objects, some_materials(), folder.path("a.vox"));
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_TRUE(report->warnings.empty()) << report->warnings[0];
  EXPECT_EQ(report->frames, 4u);
  EXPECT_EQ(report->bytes, std::filesystem::file_size(folder.path("a.vox")));
  const Result<Scene> scene = load(folder.path("a.vox"));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->clips.size(), 1u);
  EXPECT_NEAR(scene->clips[0].end, 4 / kVoxFps, 1e-9);
  for (const size_t frame : {0, 1, 2, 3}) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    std::map<std::array<int, 3>, uint16_t> found;
    for (const ShownVoxel& v : shown(*scene, (static_cast<double>(frame) + 0.5) / kVoxFps)) {
      found[{v.twice.x, v.twice.y, v.twice.z}] = v.color;
    }
    EXPECT_EQ(found, expected_voxels(objects, frame));
  }
  const auto has = [&](const auto& test) { return std::ranges::any_of(scene->materials, test); };
  EXPECT_TRUE(has([](const Material& m) { return m.metallic == 1.0f && m.roughness == 0.5f; }));
  EXPECT_TRUE(has([](const Material& m) { return std::abs(m.emissive.x - 3.0f) < 0.1f; }));
}

TEST(Vox, ManyColoursBecome255) {
  const TemporaryFolder folder;
  VoxObject object{"ball", {vec3(0.0f), 0.1f, uvec3(64)}, {random_voxels(64, 4000, 3, 8)}};
  const Result<SavedVox> report = save_vox({&object, 1}, some_materials(), folder.path("a.vox"));
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ(report->colors, kVoxColors);
  EXPECT_EQ(report->warnings.size(), 1u);
  const Scene scene = *load(folder.path("a.vox"));
  double error = 0.0;
  std::map<std::array<int, 3>, uint16_t> wanted = expected_voxels({&object, 1}, 0);
  const std::vector<ShownVoxel> voxels = shown(scene, 0.0);
  ASSERT_EQ(voxels.size(), wanted.size());
  for (const ShownVoxel& v : voxels) {
    const vec3 a = glm::sqrt(unpack_color(v.color));
    const vec3 b = glm::sqrt(unpack_color(wanted.at({v.twice.x, v.twice.y, v.twice.z})));
    error += double{dot(a - b, a - b)};
  }
  // Colours drawn at random fill the cube: 255 boxes are a sixth of its side wide.
  EXPECT_LT(std::sqrt(error / (3.0 * static_cast<double>(voxels.size()))), 0.07);
}

TEST(Vox, WhatCannotBeWrittenIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.vox");
  const auto materials = some_materials();
  const auto voxels = random_voxels(8, 20, 1, 1);
  const VoxelGrid grid{vec3(0.0f), 1.0f, uvec3(8)};
  const auto refuse = [&](const std::vector<VoxObject>& objects, const char* part) {
    const Result<SavedVox> result = save_vox(objects, materials, path);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    EXPECT_NE(result.error().problem.find(part), std::string::npos) << result.error().problem;
  };
  refuse({}, "no voxels");
  refuse({{"a", grid, {}}}, "0 frames");
  refuse({{"a", grid, {voxels, voxels}}, {"b", grid, {voxels, voxels, voxels}}}, "3 frames");
  refuse({{"a", grid, {voxels}}, {"b", {vec3(0.0f), 2.0f, uvec3(8)}, {voxels}}}, "another size");
  refuse({{"a", {vec3(1e9f), 1.0f, uvec3(8)}, {voxels}}}, "too far");
  auto bad = voxels;
  bad[0].material = 3;
  refuse({{"a", grid, {bad}}}, "material 3");
  EXPECT_EQ(save_vox({}, {}, folder.path("a.glb")).error().kind, ErrorKind::usage);
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Vox, PlainVoxelsAreThoseOfTheOctree) {
  const auto voxels = random_voxels(100, 3000, 3, 4);
  const Svo svo = *make_svo({vec3(0.0f), 1.0f, uvec3(100)}, voxels);
  const std::vector<PlainVoxel> again = plain_voxels(svo);
  ASSERT_EQ(again.size(), voxels.size());
  for (size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_EQ(again[i].voxel, voxels[i].voxel);
    EXPECT_EQ(again[i].material, voxels[i].material);
    EXPECT_EQ(again[i].normal, voxels[i].normal);
  }
}

// ---- bad files ----

std::string small_file() {
  return vox_file(
      vox_model(4, 3, 2, {{0, 0, 0, 1}, {1, 2, 1, 2}, {3, 0, 0, 200}}) +
      vox_model(1, 1, 1, {{0, 0, 0, 3}}) + vox_transform(0, 1, {}, {{}}) + vox_group(1, {2}) +
      vox_transform(2, 3, {{"_name", "n"}},
                    {{{"_f", "0"}, {"_r", "17"}}, {{"_f", "3"}, {"_t", "7 0 -2"}}}, 4) +
      vox_shape(3, {{0, {{"_f", "0"}}}, {1, {{"_f", "2"}}}}) +
      vox_chunk("LAYR", vox_number(4) + vox_dictionary({{"_hidden", "0"}}) + vox_number(-1)) +
      vox_material(2, {{"_type", "_emit"}, {"_emit", "0.5"}}) + vox_chunk("NOTE", "what?"));
}

void expect_error_or_scene(const std::string& bytes) {
  const Result<Scene> scene = parse(bytes, {.memory_limit = uint64_t{64} << 20});
  if (scene) {
    EXPECT_EQ(validate(*scene), "");
  } else {
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_FALSE(scene.error().problem.empty());
    EXPECT_EQ(scene.error().file, "a.vox");
  }
}

TEST(Vox, TruncatedFiles) {
  ASSERT_TRUE(parse(small_file())) << parse(small_file()).error().message();
  for_every_truncation(small_file(), [](const std::string& bytes) {
    EXPECT_FALSE(parse(bytes));
    expect_error_or_scene(bytes);
  });
}

TEST(Vox, EveryFlippedBit) {
  std::string bytes = small_file();
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    SCOPED_TRACE("bit " + std::to_string(bit));
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
    expect_error_or_scene(bytes);
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
  }
  for_random_patches(small_file(), 3000, 23, expect_error_or_scene);
}

TEST(Vox, HostileFilesAreRefused) {
  const std::string model = vox_model(1, 1, 1, {{0, 0, 0, 1}});
  const auto refuse = [](const std::string& chunks, const char* part) {
    const Result<Scene> scene = parse(vox_file(chunks));
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().problem.find(part), std::string::npos) << scene.error().problem;
  };
  refuse(vox_chunk("SIZE", vox_number(257) + vox_number(1) + vox_number(1)), "1 to 256");
  refuse(vox_chunk("SIZE", vox_number(0) + vox_number(1) + vox_number(1)), "1 to 256");
  refuse(vox_model(1, 1, 1, {{0, 1, 0, 1}}), "outside of its model");
  refuse(vox_chunk("XYZI", vox_number(0)), "no size");
  refuse(vox_chunk("SIZE", vox_number(1) + vox_number(1) + vox_number(1)), "no voxels");
  refuse(model + vox_transform(0, 0, {}, {{}}), "its own ancestor");
  refuse(model + vox_transform(0, 1, {}, {{}}) + vox_group(1, {2, 2}) + vox_shape(2, {{0, {}}}),
         "two parents");
  refuse(model + vox_transform(0, 5, {}, {{}}), "no node 5");
  refuse(model + vox_shape(0, {{3, {}}}), "shows model 3");
  refuse(model + vox_transform(0, 1, {}, {{{"_r", "5"}}}), "no rotation");
  refuse(model + vox_transform(0, 1, {}, {{{"_t", "1 2"}}}), "no translation");
  refuse(model + vox_transform(0, 1, {}, {{{"_t", "1 2 1e9"}}}), "no translation");
  refuse(model + vox_transform(0, 1, {}, {{{"_f", "3"}}, {{"_f", "3"}}}), "do not rise");
  EXPECT_NE(parse(vox_file(model, 99)).error().problem.find("version 99"), std::string::npos);
  EXPECT_NE(parse("PNG").error().problem.find("no .vox"), std::string::npos);
}

}  // namespace
}  // namespace sinew
