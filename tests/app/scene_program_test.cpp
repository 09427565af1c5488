// `sinew scene` as users run it.
#include <gtest/gtest.h>

#include "app/program.h"
#include "io/vox_builder.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" not in: " << text;
}

TEST(SceneProgram, WritesAGlbThatLoads) {
  TemporaryFolder folder;
  const std::string path = folder.path("out.glb");
  const Outcome outcome =
      run_sinew({"scene", folder.write("tetrahedron.obj", small_obj()), "-o", path});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_contains(outcome.out, "triangles 4, nodes 1, clips 0\n" + path + "  ");
  EXPECT_EQ(outcome.err, "");
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(count(*scene).triangles, 4u);
}

TEST(SceneProgram, NamesEveryFileAndWarnsOfCaches) {
  TemporaryFolder folder;
  const std::string path = folder.path("bodies.gltf");
  const Outcome outcome = run_sinew(
      {"scene", "study:bodies,subdivisions=2,bodies=2,motion=free", "-o", path, "--fps", "4"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* name : {"bodies.gltf", "bodies.bin", "bodies_cache.pc2", "bodies_cache_2.pc2"}) {
    expect_contains(outcome.out, folder.path(name) + "  ");
  }
  EXPECT_EQ(folder.file_count(), 4u);
  expect_contains(outcome.err, "sinew: warning: glTF has no vertex caches");
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->meshes.at(0).keys, 46u);  // 11.2 s; the last lies behind them
}

TEST(SceneProgram, WritesVoxelsAsSvoAndVox) {
  TemporaryFolder folder;
  const std::string vox = folder.write(
      "a.vox", test::vox_file(test::vox_model(4, 3, 2, {{0, 0, 0, 1}, {3, 2, 1, 200}})));
  const std::string svo = folder.path("a.svo"), again = folder.path("b.vox");
  const Outcome to_svo = run_sinew({"scene", vox, "-o", svo});
  ASSERT_EQ(to_svo.exit_code, 0) << to_svo.err;
  expect_contains(to_svo.out, "voxels 2\n");
  const Outcome to_vox = run_sinew({"scene", svo, "-o", again});
  ASSERT_EQ(to_vox.exit_code, 0) << to_vox.err;
  EXPECT_EQ(to_vox.err, "");
  expect_contains(to_vox.out, "voxels 2, models 1, colours 2\n");
  const Result<Scene> scene = load(again);
  ASSERT_TRUE(scene) << scene.error().message();
  const Box before = animation_bounds(*load(vox), kRestPose, 1);
  const Box after = animation_bounds(*scene, kRestPose, 1);
  EXPECT_LT(length(before.min - after.min) + length(before.max - after.max), 1e-5f);
  EXPECT_EQ(run_sinew({"scene", folder.write("a.obj", small_obj()), "-o", svo}).exit_code, 3);
}

TEST(SceneProgram, WritesToStandardOutput) {
  TemporaryFolder folder;
  const Outcome outcome = run_sinew({"scene", folder.write("a.obj", small_obj()), "-o", "-"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(load(folder.write("a.glb", outcome.out)));
}

TEST(SceneProgram, RefusesWithTheRightExitCode) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    const char* message;
  };
  const Case cases[] = {
      {{obj}, 2, "--output is required"},
      {{obj, "-o", folder.path("a.fbx")}, 2, "name the output .glb or .gltf"},
      {{folder.path("none.obj"), "-o", folder.path("a.glb")}, 3, "does not exist"},
      {{obj, "-o", folder.path("none/a.glb")}, 4, "folder does not exist"},
      {{obj, "-o", folder.path("a.glb"), "--fps", "nan"}, 2, "is not a number"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> arguments = {"scene"};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    const Outcome outcome = run_sinew(arguments);
    EXPECT_EQ(outcome.exit_code, c.exit_code) << outcome.err;
    expect_contains(outcome.err, c.message);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(folder.file_count(), 1u);
  }
}

}  // namespace
}  // namespace sinew
