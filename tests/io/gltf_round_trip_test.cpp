// Whole scenes through a glTF file and back: study scenes and real files play the same.
#include "io/everything_scene.h"
#include "io/round_trip.h"
#include "sinew/io/load.h"
#include "test_data.h"

namespace sinew {
namespace {

// Of the scene's size: float's 24 bits, less what matrices lose as rotations and scales.
constexpr double kTolerance = 2e-6;

void expect_round_trip(const std::string& input) {
  const Result<Scene> scene = load(input);
  ASSERT_TRUE(scene) << scene.error().message();
  const TemporaryFolder folder;
  test::expect_same_motion(*scene, test::save_and_load(*scene, folder), kTolerance);
}

class GltfRoundTripStudy : public testing::TestWithParam<const char*> {};

TEST_P(GltfRoundTripStudy, PlaysTheSame) {
  expect_round_trip(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Scenes, GltfRoundTripStudy,
                         testing::Values("study:creature,triangles=8000,texture=256",
                                         "study:twist,triangles=2000", "study:soup,triangles=1000",
                                         "study:fracture,triangles=10000,pieces=20",
                                         "study:bodies,subdivisions=2",
                                         "study:bodies,subdivisions=2,bodies=3,motion=free",
                                         "study:cloth,triangles=800,frames=10",
                                         "study:cell24,triangles=10000",
                                         "study:herd,count=3,triangles=2000,terrain=1000"));

class GltfRoundTripFile : public testing::TestWithParam<const char*> {};

TEST_P(GltfRoundTripFile, PlaysTheSame) {
  SINEW_DATA_OR_SKIP(path, GetParam());
  expect_round_trip(path);
}

INSTANTIATE_TEST_SUITE_P(
    Files, GltfRoundTripFile,
    testing::Values("khronos-gltf/InterpolationTest/glTF-Binary/InterpolationTest.glb",
                    "khronos-gltf/RecursiveSkeletons/glTF-Binary/RecursiveSkeletons.glb",
                    "khronos-gltf/MorphStressTest/glTF-Binary/MorphStressTest.glb",
                    "khronos-gltf/MorphPrimitivesTest/glTF-Binary/MorphPrimitivesTest.glb",
                    "khronos-gltf/SimpleInstancing/glTF-Binary/SimpleInstancing.glb",
                    "khronos-gltf/SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf",
                    "khronos-gltf/RiggedFigure/glTF-Binary/RiggedFigure.glb",
                    "khronos-gltf/Fox/glTF-Binary/Fox.glb", "skinned/pigman/pigman.glb",
                    "skinned/robot-expressive/RobotExpressive.glb",
                    "skinned/emoji-heart/emoji_heart.glb",
                    "skinned/littlest-tokyo/LittlestTokyo.glb",
                    "bart/scene_kitchen/aff/kitchen.aff", "bart/scene_robot/aff/Robot.aff",
                    "bart/scene_museum/aff/museum5.aff"),
    [](const auto& file) { return std::filesystem::path(file.param).stem().string(); });

TEST(GltfRoundTrip, VertexCachePlaysTheSame) {
  SINEW_DATA_OR_SKIP(folder, "vertex-cache/cloth-drapes");
  expect_round_trip(folder + "/base.obj+" + folder + "/positions.pc2");
}

TEST(GltfRoundTrip, SequenceWhoseTopologyChangesPlaysTheSame) {
  const TemporaryFolder folder;
  folder.write("a_1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.write("a_2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 4\n");
  folder.write("a_3.obj", "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n");
  const Result<Scene> scene = load(folder.path("a_#.obj"));
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->nodes.size(), 3u);
  const TemporaryFolder out;
  const Scene loaded = test::save_and_load(*scene, out);
  EXPECT_EQ(loaded.nodes.size(), 3u);
  EXPECT_EQ(loaded.clips.at(0).channels.size(), 3u);
  test::expect_same_motion(*scene, loaded, 0.0);
}

TEST(GltfRoundTrip, AnyNumberOfFramesIsKept) {
  Scene scene = test::everything_scene();
  scene.default_frames = 100'000'000;
  const TemporaryFolder folder;
  EXPECT_EQ(test::save_and_load(scene, folder).default_frames, scene.default_frames);
}

TEST(GltfRoundTrip, EverythingPlaysTheSame) {
  const Scene scene = test::everything_scene();
  ASSERT_EQ(validate(scene), "");
  for (const char* name : {"a.glb", "b.gltf"}) {
    const TemporaryFolder folder;
    const Scene loaded = test::save_and_load(scene, folder, name);
    test::expect_same_motion(scene, loaded, kTolerance);
    const TemporaryFolder again;  // what has gone through once stays as it is
    const Scene twice = test::save_and_load(loaded, again, name);
    test::expect_same_motion(loaded, twice, kTolerance);
    EXPECT_EQ(loaded.nodes.size(), twice.nodes.size());
    for (size_t i = 0; i < loaded.meshes.size(); ++i) {
      EXPECT_EQ(loaded.meshes[i].positions, twice.meshes[i].positions) << loaded.meshes[i].name;
      EXPECT_EQ(loaded.meshes[i].triangles, twice.meshes[i].triangles);
      EXPECT_EQ(loaded.meshes[i].normals, twice.meshes[i].normals);
    }
  }
}

}  // namespace
}  // namespace sinew
