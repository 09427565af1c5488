// Saved scenes before the Khronos glTF validator: no errors, whatever the scene holds. It is an npm
// package that scripts/install-npm installs.
#include <cstdio>

#include "io/everything_scene.h"
#include "io/gltf_builder.h"
#include "sinew/io/load.h"
#include "sinew/io/save.h"
#include "test_data.h"

namespace sinew {
namespace {

struct Verdict {
  std::string text;
  int exit_code = -1;
};

class GltfValidator : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(SINEW_GLTF_VALIDATOR "/node_modules/gltf-validator")) {
      GTEST_SKIP() << "no gltf-validator: run scripts/install-npm";
    }
    if (std::system("node --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no Node.js";
  }

  void save(const std::string& name, const Scene& scene) {
    const Result<SaveReport> report = save_gltf(scene, folder_.path(name));
    ASSERT_TRUE(report) << report.error().message();
    ++files_;
  }
  void save(const std::string& name, const std::string& input) {
    const Result<Scene> scene = load(input);
    ASSERT_TRUE(scene) << scene.error().message();
    save(name, *scene);
  }

  Verdict validate_all() const {
    const std::string command =
        "node " SINEW_GLTF_VALIDATOR "/validate.mjs '" + folder_.path("") + "' 2>&1";
    Verdict verdict;
    FILE* const pipe = popen(command.c_str(), "r");
    char buffer[4096];
    while (const size_t size = std::fread(buffer, 1, sizeof buffer, pipe)) {
      verdict.text.append(buffer, size);
    }
    verdict.exit_code = pclose(pipe);
    return verdict;
  }
  void expect_no_errors() const {
    const Verdict verdict = validate_all();
    EXPECT_EQ(verdict.exit_code, 0);
    EXPECT_EQ(verdict.text, std::to_string(files_) + " files\n");
  }

  TemporaryFolder folder_;
  int files_ = 0;
};

TEST_F(GltfValidator, FindsErrors) {
  GltfBuilder b;
  const int normals = b.accessor<float>({0, 0, 2, 0, 0, 1, 0, 0, 1}, "VEC3");
  b.add_mesh_node({{"attributes", {{"POSITION", b.triangle_positions()}, {"NORMAL", normals}}}});
  folder_.write("a.glb", b.glb());
  const Verdict verdict = validate_all();
  EXPECT_NE(verdict.exit_code, 0);
  expect_contains(verdict.text,
                  "a.glb: ACCESSOR_VECTOR3_NON_UNIT at /meshes/0/primitives/0/attributes/NORMAL");
}

TEST_F(GltfValidator, AcceptsStudyScenes) {
  save("creature.glb", "study:creature,triangles=8000,texture=256");
  save("twist.glb", "study:twist,triangles=2000");
  save("soup.glb", "study:soup,triangles=1000");
  save("fracture.glb", "study:fracture,triangles=10000,pieces=20");
  save("bodies.glb", "study:bodies,subdivisions=2");
  save("cloth.glb", "study:cloth,triangles=800,frames=10");
  save("cell24.glb", "study:cell24,triangles=10000");
  save("herd.glb", "study:herd,count=3,triangles=2000,terrain=1000");
  save("free.glb", "study:bodies,subdivisions=2,bodies=3,motion=free");
  expect_no_errors();
}

TEST_F(GltfValidator, AcceptsEverything) {
  const Scene scene = test::everything_scene();
  save("a.glb", scene);
  save("with space.gltf", scene);
  save("empty.glb", Scene());
  expect_no_errors();
}

TEST_F(GltfValidator, AcceptsRealFiles) {
  SINEW_DATA_OR_SKIP(data, "");
  const char* const files[] = {
      "khronos-gltf/CesiumMilkTruck/glTF-Binary/CesiumMilkTruck.glb",
      "khronos-gltf/Fox/glTF-Binary/Fox.glb",
      "khronos-gltf/InterpolationTest/glTF-Binary/InterpolationTest.glb",
      "khronos-gltf/MorphPrimitivesTest/glTF-Binary/MorphPrimitivesTest.glb",
      "khronos-gltf/MorphStressTest/glTF-Binary/MorphStressTest.glb",
      "khronos-gltf/RecursiveSkeletons/glTF-Binary/RecursiveSkeletons.glb",
      "khronos-gltf/RiggedFigure/glTF-Binary/RiggedFigure.glb",
      "khronos-gltf/SimpleInstancing/glTF-Binary/SimpleInstancing.glb",
      "khronos-gltf/ToyCar/glTF/ToyCar.gltf",
      "skinned/emoji-heart/emoji_heart.glb",
      "skinned/littlest-tokyo/LittlestTokyo.glb",
      "skinned/pigman/pigman.glb",
      "skinned/robot-expressive/RobotExpressive.glb",
      "static/dream-apartment/dream-apartment.glb",
      "bart/scene_kitchen/aff/kitchen.aff",
      "bart/scene_robot/aff/Robot.aff",
      "bart/scene_museum/aff/museum5.aff",
  };
  for (const char* file : files) {
    save(std::filesystem::path(file).stem().string() + ".glb", data + "/" + file);
  }
  const std::string caches = data + "/vertex-cache/";
  save("cloth.glb", caches + "cloth-drapes/base.obj+" + caches + "cloth-drapes/positions.pc2");
  save("face.glb",
       caches + "ict-facekit/generic_neutral_mesh.obj+" + caches + "ict-facekit/expressions.pc2");
  expect_no_errors();
}

}  // namespace
}  // namespace sinew
