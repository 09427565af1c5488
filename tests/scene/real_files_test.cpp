// Whole files against the twin in double: every clip at several times, every triangle of every
// object. And what the sample assets are known to show.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scene/gltf_twin.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"
#include "test_data.h"

namespace sinew {
namespace {

using glm::dvec3;
using test::GltfTwin;

std::vector<vec3> world_corners(const Scene& scene, const ScenePose& pose, uint32_t object) {
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  std::vector<vec3> points(mesh.positions.size()), corners;
  world_positions(scene, pose, object, points);
  for (const uvec3 t : mesh.triangles) {
    corners.insert(corners.end(), {points[t.x], points[t.y], points[t.z]});
  }
  return corners;
}

// The largest distance between the library's corners and the twin's, as a part of the size of the
// scene.
double largest_error(const Scene& scene, const GltfTwin& twin, int clip, double time) {
  ScenePose pose;
  sample(scene, clip, time, pose);
  const std::vector<std::vector<dvec3>> expected = twin.corners(clip, time);
  EXPECT_EQ(scene.objects.size(), expected.size());
  double error = 0.0, size = 0.0;
  for (uint32_t object = 0; object < expected.size(); ++object) {
    EXPECT_TRUE(pose.objects[object].present) << twin.object_name(object);
    const std::vector<vec3> corners = world_corners(scene, pose, object);
    EXPECT_EQ(corners.size(), expected[object].size()) << twin.object_name(object);
    for (size_t i = 0; i < std::min(corners.size(), expected[object].size()); ++i) {
      error = std::max(error, glm::distance(dvec3(corners[i]), expected[object][i]));
      size = std::max(size, glm::length(expected[object][i]));
    }
  }
  EXPECT_GT(size, 0.0);
  return error / size;
}

class RealFile : public testing::TestWithParam<const char*> {};

TEST_P(RealFile, MovesAsItsTwinInDouble) {
  SINEW_DATA_OR_SKIP(path, GetParam());
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(validate(*scene), "");
  const GltfTwin twin(path);
  ASSERT_EQ(scene->clips.size(), static_cast<size_t>(twin.animation_count()));

  // Of the size of the scene: 24 bits, less what chains of joints and large matrices cost.
  constexpr double kTolerance = 1e-6;
  EXPECT_LE(largest_error(*scene, twin, kRestPose, 0.0), kTolerance);
  for (int clip = 0; clip < twin.animation_count(); ++clip) {
    const double end = twin.animation_end(clip);
    EXPECT_NEAR(scene->clips[clip].end, end, 1e-6);
    for (const double u : {-0.1, 0.0, 0.137, 0.5, 0.831, 1.0, 1.2}) {
      EXPECT_LE(largest_error(*scene, twin, clip, u * end), kTolerance)
          << "clip " << clip << " at " << u * end << " s";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Files, RealFile,
    testing::Values("khronos-gltf/InterpolationTest/glTF-Binary/InterpolationTest.glb",
                    "khronos-gltf/RecursiveSkeletons/glTF-Binary/RecursiveSkeletons.glb",
                    "khronos-gltf/MorphStressTest/glTF-Binary/MorphStressTest.glb",
                    "khronos-gltf/SimpleSkin/glTF/SimpleSkin.gltf",
                    "khronos-gltf/SimpleMorph/glTF/SimpleMorph.gltf",
                    "khronos-gltf/AnimatedMorphCube/glTF-Binary/AnimatedMorphCube.glb",
                    "khronos-gltf/BoxAnimated/glTF-Binary/BoxAnimated.glb",
                    "khronos-gltf/RiggedSimple/glTF-Binary/RiggedSimple.glb",
                    "khronos-gltf/RiggedFigure/glTF-Binary/RiggedFigure.glb",
                    "khronos-gltf/Fox/glTF-Binary/Fox.glb", "skinned/pigman/pigman.glb",
                    "skinned/robot-expressive/RobotExpressive.glb",
                    "skinned/emoji-heart/emoji_heart.glb",
                    "skinned/littlest-tokyo/LittlestTokyo.glb"),
    [](const auto& file) { return std::filesystem::path(file.param).stem().string(); });

// Nine cubes, each moved by one interpolation of one property.
TEST(RealFiles, InterpolationTestHasItsNineChannels) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/InterpolationTest/glTF-Binary/InterpolationTest.glb");
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << scene.error().message();
  int seen[3][3] = {};  // by interpolation, by path
  for (const Clip& clip : scene->clips) {
    for (const Channel& channel : clip.channels) {
      ASSERT_LT(static_cast<int>(channel.path), 3);
      ++seen[static_cast<int>(channel.interpolation)][static_cast<int>(channel.path)];
    }
  }
  for (const auto& of_path : seen) {
    for (const int count : of_path) EXPECT_EQ(count, 1);
  }
}

TEST(RealFiles, RecursiveSkeletonsHasAllItsSkins) {
  SINEW_DATA_OR_SKIP(path, "khronos-gltf/RecursiveSkeletons/glTF-Binary/RecursiveSkeletons.glb");
  const Result<Scene> scene = load(path);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->skins.size(), 84u);
  EXPECT_EQ(scene->nodes.size(), 924u);
  const Box box = animation_bounds(*scene, 0, 9);
  EXPECT_TRUE(std::isfinite(length(box.extent())));
}

}  // namespace
}  // namespace sinew
