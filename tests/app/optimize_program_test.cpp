// `sinew optimize` and `sinew render --tree`.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/program.h"

namespace sinew {
namespace {

constexpr const char* kScene = "study:soup,triangles=500";

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" not in: " << text;
}

std::vector<std::string> render(const std::string& picture, const std::string& tree) {
  std::vector<std::string> arguments = {"render",   kScene, "-o",     picture,
                                        "--frames", "20",   "--size", "80x60"};
  if (!tree.empty()) arguments.insert(arguments.end(), {"--tree", tree});
  return arguments;
}

TEST(OptimizeProgram, MakesTreesThatDrawTheSamePicture) {
  TemporaryFolder folder;
  const std::string tree = folder.path("soup.tree"), report = folder.path("report.json");
  const Outcome outcome =
      run_sinew({"optimize", kScene, "-o", tree, "--segments", "3", "--json", report});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_contains(outcome.out, "triangles  trees");
  EXPECT_EQ(outcome.err, "");
  const auto json = nlohmann::json::parse(slurp(report));
  EXPECT_EQ(json["bytes"], slurp(tree).size());
  EXPECT_EQ(json["bodies"][0]["deforms"], true);
  EXPECT_LT(json["bodies"][0]["cost"], json["bodies"][0]["middle_frame_cost"]);

  const std::string with = folder.path("with.exr"), without = folder.path("without.exr");
  const Outcome drawn = run_sinew(render(with, tree));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_EQ(drawn.err.find("warning"), std::string::npos) << drawn.err;
  ASSERT_EQ(run_sinew(render(without, "")).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", with, without, "--psnr", "1000"}).exit_code, 0);
}

TEST(OptimizeProgram, WhatDoesNotFitIsMadeAnewOrRefused) {
  TemporaryFolder folder;
  const std::string tree = folder.path("other.tree"), picture = folder.path("a.png");
  ASSERT_EQ(run_sinew({"optimize", "study:twist,triangles=1000", "-o", tree}).exit_code, 0);
  const std::string bytes = slurp(tree);
  const Outcome other = run_sinew(render(picture, tree));
  EXPECT_EQ(other.exit_code, 0) << other.err;
  expect_contains(other.err, "made for another scene");
  EXPECT_EQ(slurp(tree), bytes);
  const std::string cut = folder.write("cut.tree", bytes.substr(0, bytes.size() / 2));
  const Outcome damaged = run_sinew(render(picture, cut));
  EXPECT_EQ(damaged.exit_code, 0) << damaged.err;
  expect_contains(damaged.err, "cut.tree: it has");
  std::vector<std::string> strict = render(picture, cut);
  strict.push_back("--strict");
  EXPECT_EQ(run_sinew(strict).exit_code, 3);
  EXPECT_EQ(run_sinew(render(picture, folder.path("none.tree"))).exit_code, 0);
}

TEST(OptimizeProgram, SaysWhichTreesDoNotKeepTheLimit) {
  TemporaryFolder folder;
  const std::string tree = folder.path("soup.tree");
  const auto optimized = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"optimize", kScene, "-o", tree});
    const Outcome outcome = run_sinew(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out;
  };
  expect_contains(optimized({}), "above the limit of 1.15: try --segments auto");
  expect_contains(optimized({"--segments", "2"}), "above the limit of 1.15: try --segments 4");
  EXPECT_EQ(optimized({"--cost-limit", "1000"}).find("limit"), std::string::npos);
}

TEST(OptimizeProgram, RefusesWithTheRightExitCode) {
  TemporaryFolder folder;
  const std::string out = folder.path("a.tree");
  const struct {
    std::vector<std::string> arguments;
    int exit_code;
    const char* message;
  } cases[] = {
      {{kScene}, 2, "--output is required"},
      {{kScene, "-o", out, "--segments", "0"}, 2, "--segments '0'"},
      {{kScene, "-o", out, "--segments", "many"}, 2, "write auto"},
      {{kScene, "-o", out, "--choice", "best"}, 2, "uniform or medoids"},
      {{kScene, "-o", out, "--clip", "walk"}, 2, "there is no clip \"walk\""},
      {{kScene, "-o", out, "--budget", "1000"}, 2, "budget"},
      {{kScene, "-o", out, "--budget", "lots"}, 2, "--budget 'lots'"},
      {{kScene, "-o", "-", "--json", "-"}, 2, "cannot both go to standard output"},
      {{kScene, "-o", folder.path("walk.glb")}, 2, "name the output .tree"},
      {{kScene, "-o", out, "--camera-share", "0.3"}, 2, "--camera"},
      {{kScene, "-o", out, "--hide", "zebra"}, 2, "zebra"},
      {{kScene, "-o", folder.path("no/such/folder/a.tree")}, 4, "folder"},
      {{folder.path("none.glb"), "-o", out}, 3, "none.glb"},
  };
  for (const auto& [arguments, exit_code, message] : cases) {
    std::vector<std::string> all = {"optimize"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run_sinew(all);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    expect_contains(outcome.err, message);
  }
  EXPECT_EQ(folder.file_count(), 0u);
}

}  // namespace
}  // namespace sinew
