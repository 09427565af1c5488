// `sinew render --mode`: what becomes voxels, what is refused, what is said about it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/program.h"

namespace sinew {
namespace {

using Json = nlohmann::json;

std::vector<std::string> render_words(const std::string& out, std::vector<std::string> more) {
  std::vector<std::string> words = {"render", "study:creature", "-o",     out,
                                    "--size", "64x48",          "--time", "0.5"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Json statistics(const TemporaryFolder& folder, std::vector<std::string> options) {
  options.insert(options.end(), {"--json", folder.path("stats.json")});
  const Outcome outcome = run_sinew(render_words(folder.path("out.png"), options));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return Json::parse(slurp(folder.path("stats.json")));
}

TEST(RenderVoxels, EverythingBecomesVoxels) {
  const TemporaryFolder folder;
  const Json all = statistics(folder, {"--mode", "voxels", "--resolution", "200"});
  EXPECT_EQ(all["triangles"], 0);
  EXPECT_GT(all["voxels"], 10000);
  const Json& frame = all["frames"][0];
  EXPECT_EQ(frame["rays"]["primary"], 0);
  EXPECT_EQ(frame["voxels"]["objects"], 4);
  EXPECT_GT(frame["voxels"]["voxels_drawn"], 1000);
  EXPECT_GT(frame["voxels"]["shadow_voxels_drawn"], 1000);
  const Json coarse =
      statistics(folder, {"--mode", "voxels", "--resolution", "200", "--no-shadows", "--lod", "0"});
  EXPECT_EQ(coarse["frames"][0]["voxels"]["shadow_voxels_drawn"], 0);
  EXPECT_EQ(coarse["frames"][0]["voxels"]["nodes_drawn"], 0);
}

TEST(RenderVoxels, MixedPicturesHoldBoth) {
  const TemporaryFolder folder;
  const Json mixed = statistics(folder, {"--mode", "mixed", "--voxelize", "body", "--voxelize",
                                         "arm*", "--resolution", "100"});
  EXPECT_GT(mixed["triangles"], 100);
  EXPECT_GT(mixed["voxels"], 1000);
  EXPECT_EQ(mixed["frames"][0]["rays"]["primary"], 64 * 48);
  EXPECT_EQ(mixed["frames"][0]["voxels"]["objects"], 2);
}

TEST(RenderVoxels, SaysHowVoxelsWereFound) {
  const TemporaryFolder folder;
  const std::vector<std::string> voxels = {"--mode", "voxels", "--resolution", "100"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), voxels.begin(), voxels.end());
    return statistics(folder, more)["frames"][0];
  };
  const Json alone = with({});
  EXPECT_EQ(alone["voxels"]["objects_rasterised"], 4);
  EXPECT_EQ(alone["voxels"]["objects_traced"], 0);
  EXPECT_EQ(alone["voxels"]["shadow_maps"], true);
  const Json traced = with({"--primary", "trace"});
  EXPECT_EQ(traced["voxels"]["objects_rasterised"], 0);
  EXPECT_EQ(traced["voxels"]["objects_traced"], 4);
  EXPECT_EQ(traced["voxels"]["shadow_maps"], false);
  EXPECT_EQ(traced["rays"]["primary"], 64 * 48);
  EXPECT_EQ(traced["voxels"]["voxels_drawn"], 0);
  const Json occluded = with({"--ao", "2", "--primary", "raster"});
  EXPECT_EQ(occluded["voxels"]["objects_rasterised"], 4);
  EXPECT_EQ(occluded["voxels"]["shadow_maps"], false);
  EXPECT_GT(occluded["rays"]["ao"], 1000);
  const Json mapped = with({"--ao", "2", "--voxel-shadows", "maps"});
  EXPECT_EQ(mapped["voxels"]["shadow_maps"], true);
  EXPECT_GT(mapped["voxels"]["shadow_voxels_drawn"], 100);
  with({"--view", "heatmap"});
}

TEST(RenderVoxels, TrianglesAreTheDefaultOfMeshes) {
  const TemporaryFolder folder;
  const Json plain = statistics(folder, {});
  EXPECT_EQ(plain["voxels"], 0);
  EXPECT_FALSE(plain["frames"][0].contains("voxels"));
}

TEST(RenderVoxels, OpponentsDrawLikePictures) {
  const TemporaryFolder folder;
  const auto draw = [&](const std::string& skinning) {
    const std::string out = folder.path(skinning + ".png");
    const Outcome outcome = run_sinew(
        render_words(out, {"--mode", "voxels", "--resolution", "800", "--skinning", skinning}));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return out;
  };
  const std::string lattice = draw("lattice");
  for (const char* opponent : {"thesis", "corners"}) {
    const std::string drawn = draw(opponent);
    EXPECT_NE(slurp(drawn), slurp(lattice)) << opponent;
    const Outcome alike = run_sinew({"compare", lattice, drawn, "--max-flip", "0.1"});
    EXPECT_EQ(alike.exit_code, 0) << opponent << alike.out;
  }
}

TEST(RenderVoxels, SaysWhatMakesNoSense) {
  const TemporaryFolder folder;
  const struct {
    std::vector<std::string> options;
    const char* says;
  } rows[] = {
      {{"--mode", "mixed"}, "--voxelize"},
      {{"--mode", "mixed", "--voxelize", "unicorn"}, "fits no object"},
      {{"--mode", "voxels", "--voxelize", "body"}, "mixed"},
      {{"--voxelize", "body"}, "mixed"},
      {{"--mode", "voxels", "--resolution", "0"}, "--resolution"},
      {{"--mode", "voxels", "--resolution", "4097"}, "--resolution"},
      {{"--mode", "voxels", "--shadow-map", "8"}, "--shadow-map"},
      {{"--mode", "voxels", "--lod", "-1"}, "--lod"},
      {{"--mode", "voxels", "--skinning", "bones"}, "--skinning"},
      {{"--mode", "voxels", "--primary", "both"}, "--primary"},
      {{"--mode", "voxels", "--voxel-shadows", "soft"}, "--voxel-shadows"},
      {{"--mode", "voxels", "--primary", "trace", "--skinning", "thesis"}, "lattice"},
      {{"--mode", "voxels", "--resolution", "50", "--view", "heatmap", "--primary", "raster"},
       "rasterised"},
      {{"--mode", "voxels", "--tree", "a.tree"}, "--tree"},
  };
  for (const auto& row : rows) {
    const Outcome outcome = run_sinew(render_words(folder.path("out.png"), row.options));
    EXPECT_EQ(outcome.exit_code, 2) << row.options.back();
    EXPECT_NE(outcome.err.find(row.says), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace sinew
