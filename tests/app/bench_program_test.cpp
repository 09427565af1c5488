#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/program.h"

namespace sinew {
namespace {

#ifdef SINEW_HAVE_BENCH
#define SINEW_BENCH_OR_SKIP() (void)0
#else
#define SINEW_BENCH_OR_SKIP() GTEST_SKIP() << "built without `sinew bench`"
#endif

void expect_figures(const nlohmann::json& report, const std::vector<std::string>& names) {
  std::vector<std::string> found;
  for (const auto& figure : report["figures"]) {
    found.push_back(figure["name"]);
    EXPECT_TRUE(std::isfinite(figure["value"].get<double>())) << figure;
    EXPECT_GT(figure["value"].get<double>(), 0.0) << figure;
  }
  for (const std::string& name : names) {
    EXPECT_EQ(std::ranges::count(found, name), 1) << name;
  }
}

void expect_page(const std::string& page, const std::vector<std::string>& figures) {
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  for (size_t at = page.find(" src="); at != page.npos; at = page.find(" src=", at + 1)) {
    EXPECT_EQ(page.compare(at, 11, " src=\"data:"), 0) << page.substr(at, 80);
  }
  for (const std::string& name : figures) {
    EXPECT_NE(page.find("<code>" + name + "</code>"), std::string::npos) << name;
  }
}

TEST(Bench, UpdateReportsItsFigures) {
  SINEW_BENCH_OR_SKIP();
  TemporaryFolder folder;
  const std::string bodies = "study:bodies,subdivisions=2,bodies=2";
  const Outcome outcome = run_sinew({"bench",     "update",
                                     "--bodies",  bodies,
                                     "--scene",   bodies,
                                     "--herd",    "study:herd,count=1,triangles=2000,terrain=1000",
                                     "--width",   "48",
                                     "--height",  "32",
                                     "--rays",    "100",
                                     "--repeats", "1",
                                     "--json",    folder.path("u.json"),
                                     "--report",  folder.path("u.html")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<std::string> figures = {"refit_bodies",      "picks_100",  "picks_10000",
                                            "herd_frame",        "visible_30", "auto_regret",
                                            "bytes_per_triangle"};
  const auto report = nlohmann::json::parse(slurp(folder.path("u.json")));
  EXPECT_EQ(report["bench"], "update");
  expect_figures(report, figures);
  expect_page(slurp(folder.path("u.html")), figures);
  for (const std::string& name : figures) {
    EXPECT_NE(outcome.out.find(name), std::string::npos) << name;
  }
  // All engines that drew the same frame saw the same, but for rounding.
  double hits = 0.0;
  for (const auto& row : report["rows"]) {
    if (row["table"] != "herd_frame") continue;
    if (hits == 0.0) hits = row["hits"];
    EXPECT_NEAR(row["hits"], hits, 2.0) << row;
  }
  EXPECT_GT(hits, 100.0);
}

TEST(Bench, TraceReportsItsFigures) {
  SINEW_BENCH_OR_SKIP();
  TemporaryFolder folder;
  const Outcome outcome = run_sinew(
      {"bench", "trace", "--scene", "study:bodies,subdivisions=2,bodies=1", "--width", "48",
       "--height", "32", "--repeats", "1", "--json", "-", "--report", folder.path("t.html")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  expect_figures(report, {"single_ray_robust", "packet_speed", "refit_ratio"});
  expect_page(slurp(folder.path("t.html")), {"single_ray_robust", "packet_speed"});
  for (const auto& row : report["rows"]) {
    if (row["table"] != "trees") continue;
    EXPECT_LT(row["primary_hits_differ"], 0.01) << row;
  }
}

TEST(Bench, TsahReportsItsFigures) {
  SINEW_BENCH_OR_SKIP();
  TemporaryFolder folder;
  const Outcome outcome = run_sinew({"bench",
                                     "tsah",
                                     "--scene",
                                     "study:fracture,triangles=10000,pieces=20",
                                     "--evaluated",
                                     "4",
                                     "--representatives",
                                     "3",
                                     "--width",
                                     "48",
                                     "--height",
                                     "32",
                                     "--frames",
                                     "1",
                                     "--repeats",
                                     "1",
                                     "--json",
                                     folder.path("t.json"),
                                     "--report",
                                     folder.path("t.html")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<std::string> figures = {
      "recovered",  "best_single_frame", "best_single_frame_scattering",
      "frame_full", "frame_primary",     "segments_regret"};
  const auto report = nlohmann::json::parse(slurp(folder.path("t.json")));
  EXPECT_EQ(report["bench"], "tsah");
  expect_figures(report, figures);
  const std::string page = slurp(folder.path("t.html"));
  expect_page(page, figures);
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  std::map<std::string, double> cost;
  std::set<nlohmann::json> hits;  // of every engine: all saw the same
  for (const auto& row : report["rows"]) {
    if (row["table"] == "tsah_cost") cost[row["method"]] = row["average"];
    if (row["table"] == "tsah_frame") hits.insert(row["primary_hits"]);
  }
  EXPECT_GT(cost["SAH-rebuild"], 0.0);
  EXPECT_LT(cost["SAH-rebuild"], cost["T-SAH k=0"]);
  EXPECT_LT(2.0 * cost["T-SAH k=0"], cost["SAH0"]);
  EXPECT_EQ(hits.size(), 1u);
}

TEST(Bench, AsvoReportsItsFigures) {
  SINEW_BENCH_OR_SKIP();
  TemporaryFolder folder;
  const Outcome outcome = run_sinew({"bench",        "asvo",
                                     "--creature",   "study:creature,triangles=8000,texture=256",
                                     "--body",       "creature,coarse,static",
                                     "--fine",       "128",
                                     "--resolution", "96",
                                     "--size",       "64",
                                     "--frames",     "1",
                                     "--repeats",    "1",
                                     "--json",       folder.path("a.json"),
                                     "--report",     folder.path("a.html")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(slurp(folder.path("a.json")));
  EXPECT_EQ(report["bench"], "asvo");
  std::map<std::string, double> figures;
  for (const auto& figure : report["figures"]) figures[figure["name"]] = figure["value"];
  for (const char* name : {"fps_800", "splats_per_core", "over_thesis", "over_revoxelise",
                           "bytes_memory", "bytes_disk", "voxelise_per_core"}) {
    EXPECT_GT(figures[name], 0.0) << name;
  }
  EXPECT_EQ(figures["holes"], 0.0);
  uint64_t thesis_holes = 0;
  for (const auto& row : report["rows"]) {
    if (row["table"] == "asvo_holes" && row["method"] == "thesis without S") {
      thesis_holes += row["holes"].get<uint64_t>();
    }
  }
  EXPECT_GT(thesis_holes, 0u);  // they can be found
  expect_page(slurp(folder.path("a.html")), {"fps_800", "holes", "over_thesis"});
}

TEST(Bench, RefusesPartsThatAreNone) {
  SINEW_BENCH_OR_SKIP();
  const Outcome tsah = run_sinew({"bench", "tsah", "--only", "costs,tables"});
  EXPECT_EQ(tsah.exit_code, 2);
  EXPECT_NE(tsah.err.find("convergence"), std::string::npos) << tsah.err;
  const Outcome outcome = run_sinew({"bench", "update", "--only", "picks_100,tables"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("tables"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("picks_10000"), std::string::npos) << outcome.err;
}

TEST(Bench, RefusesBeforeItMeasures) {
  SINEW_BENCH_OR_SKIP();
  for (const std::string part : {"trace", "update", "larsson", "bounds", "tsah"}) {
    const Outcome outcome = run_sinew({"bench", part, "--json", "no/such/folder.json"});
    EXPECT_EQ(outcome.exit_code, 4) << part;
    EXPECT_EQ(outcome.out, "") << part;
    EXPECT_NE(outcome.err.find("no/such/folder.json"), std::string::npos) << outcome.err;
    const Outcome misspelt = run_sinew({"bench", part, "--repeat", "3"});
    EXPECT_EQ(misspelt.exit_code, 2) << part;
    EXPECT_NE(misspelt.err.find("did you mean --repeats?"), std::string::npos) << misspelt.err;
    EXPECT_NE(misspelt.err.find("sinew bench " + part + " --help"), std::string::npos);
  }
  const Outcome unknown = run_sinew({"bench", "updat"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("did you mean update?"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace sinew
