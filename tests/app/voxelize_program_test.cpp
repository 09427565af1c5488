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
  const size_t files = folder.file_count();
  for (const rlim_t bytes : {2000, 60000}) {  // of a spool; of the file that they become
    Outcome outcome;
    {
      const FileSizeLimit limit(bytes);
      outcome = run_sinew({"voxelize", input, "-o", out, "--resolution", "200"});
    }
    EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
    expect_contains(outcome.err, "cannot be written");
    EXPECT_EQ(slurp(out), "old");
    EXPECT_EQ(folder.file_count(), files);
  }
  EXPECT_EQ(run_sinew({"voxelize", input, "-o", out, "--resolution", "200"}).exit_code, 0);
}

TEST(VoxelizeProgram, SameFileWhateverTheMemory) {
  TemporaryFolder folder;
  const std::string report = folder.path("report.json");
  const auto bytes_with = [&](const char* memory, uint64_t& parts) {
    const std::string out = folder.path("c.svo");
    const Outcome outcome =
        run_sinew({"voxelize", "study:creature,triangles=12000", "-o", out, "--resolution", "800",
                   "--memory-limit", memory, "--json", report});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(slurp(report));
    parts = json["objects"][0]["parts"];
    EXPECT_GT(json["peak_bytes"], 1 << 20);
    return slurp(out);
  };
  uint64_t one = 0, many = 0;
  const std::string at_once = bytes_with("4G", one);
  EXPECT_TRUE(bytes_with("192M", many) == at_once);
  EXPECT_EQ(one, 1u);
  EXPECT_GT(many, 1u);
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
