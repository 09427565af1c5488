// `sinew voxelize`.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "app/program.h"

namespace sinew {
namespace {

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" not in: " << text;
}

TEST(VoxelizeProgram, WritesOctreesThatInfoReads) {
  TemporaryFolder folder;
  const std::string out = folder.path("creature.svo"), report = folder.path("report.json");
  const Outcome outcome =
      run_sinew({"voxelize", "study:creature,triangles=12000", "-o", out, "--resolution", "64",
                 "--object", "body", "--object", "eyes", "--only", "--json", report});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  expect_contains(outcome.out, "B/voxel");
  const auto json = nlohmann::json::parse(slurp(report));
  ASSERT_EQ(json["objects"].size(), 2u);
  EXPECT_EQ(json["objects"][0]["name"], "body");
  EXPECT_EQ(json["objects"][0]["resolution"][2], 64);
  EXPECT_GT(json["objects"][0]["voxels"], 500);
  EXPECT_GT(json["voxels_per_s"], 0.0);
  EXPECT_EQ(json["file_bytes"], slurp(out).size());
  const Outcome info = run_sinew({"info", out});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  expect_contains(info.out, "Walk");
}

TEST(VoxelizeProgram, SameFileForAnyNumberOfThreads) {
  TemporaryFolder folder;
  const std::string input = folder.write("box.obj", small_obj());
  std::string first;
  for (const char* threads : {"1", "2", "3"}) {
    const std::string out = folder.path("box.svo");
    const Outcome outcome = run_sinew({"voxelize", input, "-o", out, "--resolution", "100",
                                       "--shell", "conservative", "--solid", "--threads", threads});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    if (first.empty()) first = slurp(out);
    EXPECT_EQ(slurp(out), first);
  }
}

// A soft limit on the size of files, which programs inherit, while it lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(VoxelizeProgram, AFullDiskLeavesTheOldFile) {
  TemporaryFolder folder;
  const std::string out = folder.write("box.svo", "old"),
                    input = folder.write("b.obj", small_obj());
  const std::string good = folder.path("good.svo");
  ASSERT_EQ(run_sinew({"voxelize", input, "-o", good, "--resolution", "200"}).exit_code, 0);
  const size_t files = folder.file_count();
  const rlim_t size = slurp(good).size();
  for (const rlim_t bytes : {size / 8, size - 1}) {  // of what waits on disk; of the file
    Outcome outcome;
    {
      const FileSizeLimit limit(bytes);
      outcome = run_sinew({"voxelize", input, "-o", out, "--resolution", "200"});
    }
    EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
    expect_contains(outcome.err, "larger than files may be");
    EXPECT_TRUE(slurp(out) == "old");
    EXPECT_EQ(folder.file_count(), files);
  }
}

TEST(VoxelizeProgram, SameFileWhateverTheMemory) {
  TemporaryFolder folder;
  const std::string report = folder.path("report.json"), out = folder.path("c.svo");
  const auto voxelize_with = [&](const std::string& memory) {
    return run_sinew({"voxelize", "study:creature,triangles=12000", "-o", out, "--resolution",
                      "1000", "--threads", "2", "--object", "body", "--only", "--memory-limit",
                      memory, "--json", report});
  };
  const auto parts = [&] { return nlohmann::json::parse(slurp(report))["objects"][0]["parts"]; };
  ASSERT_EQ(voxelize_with("4G").exit_code, 0);
  EXPECT_EQ(parts(), 1);
  const std::string at_once = slurp(out);
  const Outcome refused = voxelize_with("40M");
  EXPECT_EQ(refused.exit_code, 1) << refused.err;
  const std::string remedy = "give --memory-limit ";
  const size_t at = refused.err.find(remedy);
  ASSERT_NE(at, std::string::npos) << refused.err;
  const int least = std::stoi(refused.err.substr(at + remedy.size()));
  const Outcome enough = voxelize_with(std::to_string(least + 4) + "M");
  ASSERT_EQ(enough.exit_code, 0) << enough.err;
  EXPECT_GT(parts(), 1);
  EXPECT_GT(nlohmann::json::parse(slurp(report))["peak_bytes"], 1 << 20);
  EXPECT_TRUE(slurp(out) == at_once);
}

TEST(VoxelizeProgram, ClipsBecomeFramesOfVox) {
  TemporaryFolder folder;
  const std::string out = folder.path("walk.vox"), report = folder.path("report.json");
  const Outcome outcome =
      run_sinew({"voxelize", "study:creature,triangles=12000", "-o", out, "--resolution", "40",
                 "--object", "body", "--clip", "Walk", "--fps", "2", "--json", report});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(slurp(report))["frames"], 4);
  EXPECT_EQ(slurp(out).substr(0, 4), "VOX ");
}

TEST(VoxelizeProgram, VoxelsAreNotVoxelisedAgain) {
  TemporaryFolder folder;
  const std::string input = folder.write("box.obj", small_obj()), out = folder.path("box.svo");
  ASSERT_EQ(run_sinew({"voxelize", input, "-o", out, "--resolution", "8"}).exit_code, 0);
  const Outcome again = run_sinew({"voxelize", out, "-o", folder.path("again.svo")});
  EXPECT_EQ(again.exit_code, 2);
  expect_contains(again.err, "sinew scene");
}

TEST(VoxelizeProgram, RefusesWithTheRightExitCode) {
  TemporaryFolder folder;
  const std::string out = folder.path("a.svo"), input = folder.write("box.obj", small_obj());
  const std::string flat = folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const size_t files = folder.file_count();
  const struct {
    std::vector<std::string> arguments;
    int exit_code;
    const char* message;
  } cases[] = {
      {{input}, 2, "--output is required"},
      {{input, "-o", out, "--resolution", "0"}, 2, "from 1 to 4096"},
      {{input, "-o", out, "--resolution", "4097"}, 2, "from 1 to 4096"},
      {{input, "-o", out, "--resolution", "9", "--voxel-size", "1"}, 2, "excludes"},
      {{input, "-o", out, "--voxel-size", "-1"}, 2, "--voxel-size"},
      {{input, "-o", out, "--voxel-size", "1e-6"}, 2, "at most 4096"},
      {{input, "-o", out, "--shell", "thick"}, 2, "thin or conservative"},
      {{input, "-o", out, "--object", "zebra"}, 2, "zebra"},
      {{input, "-o", out, "--clip", "walk"}, 2, "--clip is for .vox"},
      {{input, "-o", folder.path("a.vox"), "--clip", "walk"}, 2, "there is no clip"},
      {{input, "-o", folder.path("a.glb")}, 2, "name the output .svo or .vox"},
      {{input, "-o", "-", "--json", "-"}, 2, "cannot both go to standard output"},
      {{input, "-o", folder.path("no/such/folder/a.svo")}, 4, "folder"},
      {{folder.path("none.glb"), "-o", out}, 3, "none.glb"},
      {{flat, "-o", out}, 3, "no object to voxelise"},
      {{input, "-o", out, "--resolution", "4000", "--solid", "--memory-limit", "64M"},
       1,
       "more memory"},
  };
  for (const auto& [arguments, exit_code, message] : cases) {
    std::vector<std::string> all = {"voxelize"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run_sinew(all);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    expect_contains(outcome.err, message);
  }
  EXPECT_EQ(folder.file_count(), files);
}

}  // namespace
}  // namespace sinew
