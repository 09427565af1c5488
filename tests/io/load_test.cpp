#include "sinew/io/load.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/hostile.h"
#include "sinew/scene/sample.h"
#include "test_data.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

std::string triangle(float x) {
  return fmt::format("v {} 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", x);
}
constexpr char kQuad[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

// Three points, two samples.
std::string make_pc2() {
  std::string bytes("POINTCACHE2\0\1\0\0\0\3\0\0\0\0\0\0\0\0\0\x80\x3f\2\0\0\0", 32);
  bytes.append(2 * 3 * 12, '\0');
  return bytes;
}

struct LoadTest : testing::Test {
  TemporaryFolder folder;

  Scene expect_scene(const std::string& name, const LoadOptions& options = {}) {
    auto scene = load(folder.path(name), options);
    EXPECT_TRUE(scene) << scene.error().message();
    if (!scene) return {};
    EXPECT_EQ(validate(*scene), "");
    EXPECT_FALSE(scene->name.empty());
    return std::move(*scene);
  }
  void expect_error(const std::string& input, const std::string& part,
                    const LoadOptions& options = {}) {
    const auto scene = load(input, options);
    ASSERT_FALSE(scene) << input;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_NE(scene.error().message().find(part), std::string::npos) << scene.error().message();
  }
};

using Load = LoadTest;

TEST_F(Load, TheExtensionDecidesInAnyCase) {
  folder.write("Walk.OBJ", triangle(0));
  EXPECT_EQ(expect_scene("Walk.OBJ").name, "Walk");
  folder.write("a.stl", "solid");
  expect_error(folder.path("a.stl"), "\".stl\" are not supported (give .gltf, .glb, .obj, .ply");
  expect_error(folder.path("a"), "no extension");
  expect_error("", "no extension");
  expect_error(folder.path("none.obj"), "does not exist");
  expect_error(folder.path("none.glb"), "none.glb");
  fs::create_directory(folder.path("folder.obj"));
  expect_error(folder.path("folder.obj"), "not a regular file");
}

TEST_F(Load, StudyScenesHaveTheirPrefix) {
  const auto scene = load("study:twist");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_FALSE(scene->name.empty());
  const auto unknown = load("study:none");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::usage);
}

TEST_F(Load, CachesOverABase) {
  folder.write("base.obj", triangle(0));
  folder.write("p.pc2", make_pc2());
  const std::string input = folder.path("base.obj") + "+" + folder.path("p.pc2");
  const auto scene = load(input);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->name, "p");
  EXPECT_EQ(scene->meshes[0].keys, 2u);
  expect_error(folder.path("p.pc2"), "needs its base mesh");
  expect_error(folder.path("none.obj") + "+" + folder.path("p.pc2"), "none.obj");
  expect_error(folder.path("base.obj") + "+" + folder.path("none.pc2"), "none.pc2");
}

TEST_F(Load, APlusInANameIsFine) {
  folder.write("a+b.obj", triangle(0));
  EXPECT_EQ(expect_scene("a+b.obj").name, "a+b");
  folder.write("p+q.pc2", make_pc2());
  const auto scene = load(folder.path("a+b.obj") + "+" + folder.path("p+q.pc2"));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->meshes[0].keys, 2u);
  folder.write("x.obj+y.pc2", "a file of this very name wins");
  expect_error(folder.path("x.obj+y.pc2"), "needs its base mesh");
}

TEST_F(Load, ASequenceOfOneTopologyIsACache) {
  for (int i : {8, 9, 10, 11}) {
    folder.write(fmt::format("w_{:04}.obj", i), triangle(static_cast<float>(i)));
  }
  folder.write("w_11.obj", "not of the sequence: two digits");
  folder.write("w_000a.obj", "nor this");
  folder.write("w_00012.obj", "nor this: five digits beginning with 0");
  for (const char* pattern : {"w_####.obj", "w_%04d.obj"}) {
    const Scene scene = expect_scene(pattern);
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].keys, 4u);
    EXPECT_TRUE(scene.meshes[0].normals.empty());
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.default_frames, 4);
    EXPECT_EQ(scene.default_fps, 24.0);
    ScenePose pose;
    std::vector<vec3> positions(3);
    sample(scene, 0, 2.5 / 24.0, pose);
    world_positions(scene, pose, 0, positions);
    EXPECT_NEAR(positions[0].x, 10.5f, 1e-5f);
  }
}

TEST_F(Load, GapsInASequenceKeepTheirTime) {
  for (int i : {1, 2, 6}) folder.write(fmt::format("w{}.obj", i), triangle(static_cast<float>(i)));
  const Scene scene = expect_scene("w%d.obj");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "the sequence has gaps: 3 frames are missing, the first after w2.obj");
  EXPECT_EQ(scene.default_frames, 6);
  EXPECT_FLOAT_EQ(scene.clips[0].channels[0].times[2], 5.0f / 24.0f);
}

TEST_F(Load, WhatOnlyLaterFilesOfASequenceLackIsNamedOnce) {
  const auto warnings = [&](const std::string& last) {
    folder.write("w1.obj", "curv 0 1\n" + triangle(0));
    for (int i : {2, 3}) folder.write(fmt::format("w{}.obj", i), "curv 0 1\nsurf\n" + triangle(1));
    folder.write("w4.obj", last);
    return expect_scene("w#.obj").warnings;
  };
  const std::vector<std::string> cached = warnings(triangle(4));
  ASSERT_EQ(cached.size(), 2u);
  EXPECT_NE(cached[0].find("curv"), std::string::npos);
  EXPECT_EQ(cached[1].find("w2.obj: line 2: statement \"surf\""), 0u) << cached[1];
  EXPECT_EQ(warnings(kQuad), cached) << "and where the topology changes";
}

TEST_F(Load, AChangingTopologyShowsOneNodeAFrame) {
  folder.write("w1.obj", triangle(0));
  folder.write("w2.obj", kQuad);
  folder.write("w3.obj", triangle(3));
  const Scene scene = expect_scene("w#.obj");
  ASSERT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.meshes[1].triangles.size(), 2u);
  EXPECT_FALSE(scene.meshes[0].normals.empty()) << "nothing deforms";
  ScenePose pose;
  for (int frame = 0; frame < 3; ++frame) {
    sample(scene, 0, (frame + 0.5) / 24.0, pose);
    for (int node = 0; node < 3; ++node) EXPECT_EQ(pose.visible[node] != 0, node == frame);
  }
  sample(scene, kRestPose, 0.0, pose);
  EXPECT_EQ(pose.visible, (std::vector<uint8_t>{1, 0, 0}));
}

TEST_F(Load, WrongSequencesAreErrors) {
  folder.write("w1.obj", triangle(0));
  folder.write("w2.obj", "v 0 0 0\nf 1 2 3\n");
  expect_error(folder.path("x##.obj"), "no file matches");
  expect_error(folder.path("none/w#.obj"), "folder cannot be read");
  expect_error(folder.path("w#.obj"), "w2.obj: line 2");
  expect_error(folder.path("w#.obj"), "memory limit", {.memory_limit = 10});
  EXPECT_FALSE(load(folder.path("w%99d.obj")));
  EXPECT_FALSE(load(folder.path("w%sd.obj")));
  EXPECT_FALSE(load(folder.path("w############.obj")));
  EXPECT_EQ(expect_scene("w1.obj").meshes.size(), 1u);
}

TEST_F(Load, OneFrameIsASequence) {
  folder.write("w7.obj", triangle(0));
  EXPECT_EQ(expect_scene("w#.obj").meshes[0].keys, 1u);
}

TEST_F(Load, StrictReachesTheReaders) {
  folder.write("a.obj", std::string(kQuad) + "l 1 2\n");
  EXPECT_EQ(expect_scene("a.obj").warnings.size(), 1u);
  expect_error(folder.path("a.obj"), "line 6", {.strict = true});
}

TEST(LoadData, RealCachesLoadByTheirCombinedName) {
  SINEW_DATA_OR_SKIP(data, "vertex-cache");
  const auto scene = load(data + "/cloth-drapes/base.obj+" + data + "/cloth-drapes/positions.pc2");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->meshes[0].keys, 9u);
  EXPECT_EQ(count(*scene).triangles, 115'200u);
}

TEST(LoadData, ACacheBesideItsBaseNeedsNoFolder) {
  SINEW_DATA_OR_SKIP(base, "vertex-cache/cloth-drapes/base.obj");
  const auto scene = load(base + "+positions.pc2");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->meshes[0].keys, 9u);
}

TEST(LoadData, GltfFilesLoad) {
  SINEW_DATA_OR_SKIP(data, "khronos-gltf/Fox");
  size_t loaded = 0;
  for (const auto& entry : fs::recursive_directory_iterator(data)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".gltf") && !path.ends_with(".glb")) continue;
    const auto scene = load(path);
    EXPECT_TRUE(scene) << scene.error().message();
    ++loaded;
  }
  EXPECT_GT(loaded, 0u);
}

}  // namespace
}  // namespace sinew
