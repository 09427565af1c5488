#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/program.h"
#include "io/vox_builder.h"
#include "sinew/io/load.h"
#include "sinew/io/svo/svo.h"
#include "sinew/scene/study.h"
#include "test_data.h"

namespace sinew {
namespace {

nlohmann::json info_json(const std::string& input) {
  const Outcome outcome = run_sinew({"info", input, "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out);
}

TEST(Info, CountsAStaticObj) {
  TemporaryFolder folder;
  const auto json = info_json(folder.write("tetrahedron.obj", small_obj()));
  EXPECT_EQ(json["triangles"], 4);
  EXPECT_EQ(json["vertices"], 4);
  EXPECT_EQ(json["joints"], 0);
  EXPECT_EQ(json["morphs"], 0);
  EXPECT_EQ(json["clips"].size(), 0u);
  EXPECT_EQ(json["frames"], 1);
  EXPECT_EQ(json["objects"], 1);
  EXPECT_TRUE(json["warnings"].is_array());
  EXPECT_EQ(json["bounds"]["max"], nlohmann::json({1.0, 1.0, 1.0}));
}

TEST(Info, CountsTheFramesOfASequence) {
  TemporaryFolder folder;
  for (int i = 1; i <= 5; ++i) {
    folder.write("walk_000" + std::to_string(i) + ".obj", small_obj(static_cast<float>(i)));
  }
  const auto json = info_json(folder.path("walk_####.obj"));
  EXPECT_EQ(json["triangles"], 4);
  EXPECT_EQ(json["frames"], 5);
  EXPECT_EQ(json["cache_keys"], 5);
  EXPECT_EQ(json["clips"].size(), 1u);
}

TEST(Info, SaysWhatAStudySceneHolds) {
  const auto json = info_json("study:bodies,subdivisions=2");
  EXPECT_EQ(json["triangles"], 9 * 320);
  EXPECT_EQ(json["frames"], 280);
  EXPECT_EQ(json["cameras"].size(), 1u);
  EXPECT_EQ(json["lights"].size(), 2u);
}

TEST(Info, CountsVoxels) {
  TemporaryFolder folder;
  const std::string vox =
      folder.write("a.vox", test::vox_file(test::vox_model(4, 4, 9, {{0, 0, 0, 1}, {3, 3, 8, 2}})));
  const auto json = info_json(vox);
  EXPECT_EQ(json["voxels"], 2);
  EXPECT_EQ(json["triangles"], 0);
  EXPECT_EQ(json["objects"], 0);
  EXPECT_EQ(json["voxel_objects"], 1);
  ASSERT_EQ(json["octrees"].size(), 1u);
  EXPECT_EQ(json["octrees"][0]["voxels"], 2);
  EXPECT_EQ(json["octrees"][0]["levels"], 7);
  EXPECT_EQ(json["octrees"][0]["resolution"], nlohmann::json({4, 9, 4}));
  EXPECT_GT(json["octrees"][0]["bytes_by_part"]["topology"], 0);
  EXPECT_TRUE(json["svo_file"].empty());
  EXPECT_NEAR(json["bounds"]["max"][1].get<double>(), 0.9, 1e-5);

  ASSERT_TRUE(save_svo(*load(vox), folder.path("a.svo")));
  const auto svo = info_json(folder.path("a.svo"));
  EXPECT_EQ(svo["voxels"], 2);
  uint64_t sum = 0;
  for (const auto& part : svo["svo_file"]) sum += part.get<uint64_t>();
  EXPECT_EQ(sum, std::filesystem::file_size(folder.path("a.svo")));
  const Outcome text = run_sinew({"info", folder.path("a.svo")});
  EXPECT_NE(text.out.find("in the file"), std::string::npos) << text.out;
}

TEST(Info, ListsStudyScenes) {
  const Outcome outcome = run_sinew({"info", "study:"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  const auto json = nlohmann::json::parse(run_sinew({"info", "study:", "--json"}).out);
  EXPECT_EQ(json["studies"].size(), study_scenes().size());
  for (const auto& study : json["studies"]) {
    EXPECT_NE(outcome.out.find("study:" + study["name"].get<std::string>()), std::string::npos);
  }
}

TEST(Info, TextNamesTheNumbers) {
  TemporaryFolder folder;
  const Outcome outcome = run_sinew({"info", folder.write("a.obj", small_obj())});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.out.find("triangles    4\n"), std::string::npos) << outcome.out;
}

TEST(Info, NamesThatAreNotUtf8StillGiveJson) {
  TemporaryFolder folder;
  folder.write("m.mtl", "newmtl caf\xe9\nKd 1 0 0\n");
  const auto json =
      info_json(folder.write("a.obj", "mtllib m.mtl\nusemtl caf\xe9\n" + small_obj()));
  EXPECT_EQ(json["triangles"], 4);
}

TEST(Info, FindsWhatTheSharedDataHold) {
  SINEW_DATA_OR_SKIP(data, "skinned");
  const struct {
    const char* file;
    int triangles;
    int joints;
    size_t clips;
  } cases[] = {{"pigman/pigman.glb", 37136, 103, 4},
               {"robot-expressive/RobotExpressive.glb", 3237, 43, 14}};
  for (const auto& [file, triangles, joints, clips] : cases) {
    const auto json = info_json(data + "/" + file);
    EXPECT_EQ(json["triangles"], triangles) << file;
    EXPECT_EQ(json["joints"], joints) << file;
    EXPECT_EQ(json["clips"].size(), clips) << file;
  }
}

}  // namespace
}  // namespace sinew
