// Goldens through the program: small pictures of the study scenes, drawn by `sinew render` and held
// against tests/golden by `sinew compare`. A new one is one line here and one picture there,
// which running the test with SINEW_UPDATE_GOLDENS=1 in the environment makes.
// Change a golden only in a commit that shows the picture before and after.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "app/program.h"
#include "test_data.h"

namespace sinew {
namespace {

struct Golden {
  const char* name;
  const char* input;
  std::vector<std::string> options;
};

// The mean FLIP error. Other instruction sets may round differently, which shows in a few pixels; a
// wrong picture is far above this.
constexpr const char* kMostFlip = "0.005";

class GoldenPicture : public testing::TestWithParam<Golden> {};
INSTANTIATE_TEST_SUITE_P(
    All, GoldenPicture,
    testing::Values(
        Golden{"creature_walk", "study:creature", {"--time", "0.7", "--samples", "4"}},
        Golden{"creature_ao", "study:creature", {"--time", "0", "--ao", "16", "--camera", "Side"}},
        Golden{"twist", "study:twist", {"--time", "0.6", "--reflections", "2"}},
        Golden{"soup", "study:soup", {"--time", "1.2"}},
        Golden{"fracture", "study:fracture", {"--time", "1.0"}},
        Golden{"bodies", "study:bodies,subdivisions=4", {"--time", "2.6", "--samples", "4"}},
        Golden{"bodies_free", "study:bodies,subdivisions=4,motion=free", {"--time", "2.6"}},
        Golden{"cell24", "study:cell24,triangles=20000", {"--time", "1.2", "--samples", "4"}},
        Golden{"cloth_falls", "study:cloth,triangles=5000,frames=12", {"--time", "0.44"}},
        Golden{"herd",
               "study:herd,count=12,triangles=5000,terrain=100000",
               {"--time", "1", "--samples", "4"}},
        Golden{"creature_heatmap", "study:creature", {"--time", "0.7", "--view", "heatmap"}},
        Golden{"creature_normals", "study:creature", {"--time", "0.7", "--view", "normals"}},
        Golden{"bodies_boxes", "study:bodies", {"--time", "2.6", "--view", "boxes=2"}},
        Golden{"bodies_objects", "study:bodies", {"--time", "2.6", "--view", "objects"}},
        Golden{"creature_voxels",
               "study:creature",
               {"--time", "0.7", "--mode", "voxels", "--resolution", "1000", "--samples", "2"}},
        Golden{
            "creature_voxels_near",
            "study:creature",
            {"--time", "0.7", "--mode", "voxels", "--resolution", "600", "--camera", "Portrait"}},
        Golden{"creature_voxels_normals",
               "study:creature",
               {"--time", "0.7", "--mode", "voxels", "--view", "normals"}},
        Golden{"creature_mixed",
               "study:creature",
               {"--time", "0.7", "--mode", "mixed", "--voxelize", "body", "--voxelize", "armour",
                "--resolution", "200", "--samples", "2"}},
        Golden{"creature_mixed_ao",
               "study:creature",
               {"--time", "0.7", "--mode", "mixed", "--voxelize", "body", "--voxelize", "armour",
                "--resolution", "200", "--primary", "trace", "--ao", "16"}},
        Golden{"twist_voxels",
               "study:twist",
               {"--time", "0.6", "--mode", "voxels", "--resolution", "300", "--samples", "4"}},
        // The picture in an .exr is the one in tests/golden once it is finished.
        Golden{"twist_exr", "study:twist", {"--time", "0.6", "--format", "exr"}},
        Golden{"fox",
               SINEW_TEST_DATA "/khronos-gltf/Fox/glTF-Binary/Fox.glb",
               {"--clip", "Run", "--time", "0.3", "--samples", "4"}},
        Golden{"robot",
               SINEW_TEST_DATA "/skinned/robot-expressive/RobotExpressive.glb",
               {"--clip", "Wave", "--time", "0.7"}},
        Golden{"tokyo",
               SINEW_TEST_DATA "/skinned/littlest-tokyo/LittlestTokyo.glb",
               {"--time", "3", "--samples", "2"}},
        Golden{"pigman",
               SINEW_TEST_DATA "/skinned/pigman/pigman.glb",
               {"--clip", "2", "--time", "0.4", "--hide", "Object_44", "--hide", "Object_32"}},
        Golden{"kitchen",
               SINEW_TEST_DATA "/bart/scene_kitchen/aff/kitchen.aff",
               {"--frames", "601", "--reflections", "3", "--samples", "4"}},
        Golden{"museum",
               SINEW_TEST_DATA "/bart/scene_museum/aff/museum5.aff",
               {"--frames", "180", "--reflections", "2"}},
        Golden{"robots",
               SINEW_TEST_DATA "/bart/scene_robot/aff/Robot.aff",
               {"--frames", "321", "--subsample", "2"}},
        Golden{"cloth",
               SINEW_TEST_DATA "/vertex-cache/cloth-drapes/base.obj+" SINEW_TEST_DATA
                               "/vertex-cache/cloth-drapes/positions.pc2",
               {"--time", "0.1"}}),
    [](const auto& golden) { return std::string(golden.param.name); });

TEST_P(GoldenPicture, IsDrawnAsBefore) {
  const Golden& golden = GetParam();
  const std::string input = golden.input;
  const std::string first_file = input.substr(0, input.find(".obj+") + 4);
  if (!input.starts_with("study:") &&
      !std::filesystem::exists(input.find(".obj+") == input.npos ? input : first_file)) {
    GTEST_SKIP() << "no test data at " << input;
  }
  const TemporaryFolder folder;
  const std::string drawn = folder.path("drawn.png");
  std::vector<std::string> words = {"render", input, "-o", drawn, "--size", "160x120"};
  words.insert(words.end(), golden.options.begin(), golden.options.end());
  const Outcome render = run_sinew(words);
  ASSERT_EQ(render.exit_code, 0) << render.err;
  const std::string expected = std::string(SINEW_GOLDEN "/") + golden.name + ".png";
  if (std::getenv("SINEW_UPDATE_GOLDENS")) {
    const auto replace = std::filesystem::copy_options::overwrite_existing;
    std::filesystem::copy_file(drawn, expected, replace);
  }
  const Outcome compare = run_sinew({"compare", expected, drawn, "--max-flip", kMostFlip});
  EXPECT_EQ(compare.exit_code, 0) << compare.out << compare.err;
}

}  // namespace
}  // namespace sinew
