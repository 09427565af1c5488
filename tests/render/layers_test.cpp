// Layers against what geometry says, and their way into an EXR file.
#include "sinew/render/layers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "io/hostile.h"
#include "sinew/base/parallel.h"
#include "sinew/render/frame_exr.h"
#include "test_scene.h"

namespace sinew {
namespace {

using test::TestScene;

constexpr uint32_t kSide = 32;

// A square that fills the view's left half, at z = 2, in front of nothing.
TestScene half_square() {
  TestScene t;
  t.place(t.add_quad(vec3(-1, -1, 2), vec3(1, 0, 0), vec3(0, 2, 0), t.add_material(vec3(0.5f))));
  return t;
}

FrameLayers layers_of(TestScene& t, const LayerChoice& choice = {}) {
  const World world = t.prepare_world();
  LayerScratch scratch;
  FrameLayers layers;
  trace_layers(world, t.scene, world.pose(), t.camera, kSide, kSide, choice, scratch, layers);
  return layers;
}

TEST(Layers, ASquareInHalfThePicture) {
  TestScene t = half_square();
  const FrameLayers layers = layers_of(t);
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const size_t i = size_t{y} * kSide + x;
      const bool on_square = x < kSide / 2;
      ASSERT_EQ(layers.object[i], on_square ? 0u : kNoObject) << x << ", " << y;
      // The diagonal of the quad goes from the lower left to the upper right corner.
      if (on_square) {
        const float u = (static_cast<float>(x) + 0.5f) / 16.0f;
        const float v = 1.0f - (static_cast<float>(y) + 0.5f) / 32.0f;
        ASSERT_EQ(layers.primitive[i], u > v ? 0u : 1u) << x << ", " << y;
      } else {
        ASSERT_EQ(layers.primitive[i], kNoObject);
      }
      ASSERT_EQ(layers.depth[i], on_square ? 8.0f : std::numeric_limits<float>::infinity());
      ASSERT_EQ(layers.normal[i], on_square ? vec3(0, 0, 1) : vec3(0)) << x << ", " << y;
    }
  }
  EXPECT_GE(layers.traversal[0], 1u);
}

TEST(Layers, DepthIsAlongTheAxisInPerspective) {
  TestScene t = half_square();
  t.camera = look_at(vec3(0, 0, 6), vec3(0, 0, 0), vec3(0, 1, 0), 0.9f);
  const FrameLayers layers = layers_of(t);
  size_t met = 0;
  for (const float depth : layers.depth) {
    if (std::isinf(depth)) continue;
    EXPECT_NEAR(depth, 4.0f, 1e-5f);
    ++met;
  }
  EXPECT_GT(met, 50u);
}

TEST(Layers, OnlyChosenOnesAreMade) {
  TestScene t = half_square();
  const FrameLayers layers = layers_of(t, {false, true, false, false, false, false});
  EXPECT_EQ(layers.depth.size(), size_t{kSide} * kSide);
  EXPECT_TRUE(layers.normal.empty() && layers.object.empty() && layers.primitive.empty());
  EXPECT_TRUE(layers.traversal.empty());
}

TEST(Layers, HolesOfMasksShowWhatIsBehind) {
  TestScene t = half_square();
  t.scene.materials[0].alpha_mode = AlphaMode::mask;
  t.scene.materials[0].base_color.w = 0.2f;
  t.place(t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), t.add_material(vec3(0.5f))));
  for (const uint32_t object : layers_of(t).object) ASSERT_EQ(object, 1u);
}

TEST(Layers, SameBitsForAnyThreadCount) {
  TestScene t;
  t.camera.ymag = 1.2f;
  t.place(t.add_mesh(test::sphere(4), t.add_material(vec3(0.5f))));
  FrameLayers first;
  for (const int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    const FrameLayers layers = layers_of(t);
    if (threads == 1) first = layers;
    EXPECT_EQ(layers.depth, first.depth);
    EXPECT_EQ(layers.normal, first.normal);
    EXPECT_EQ(layers.object, first.object);
    EXPECT_EQ(layers.primitive, first.primitive);
    EXPECT_EQ(layers.traversal, first.traversal);
  }
}

TEST(FrameExr, HoldsWhatItsHeaderSays) {
  TestScene t = half_square();
  const FrameLayers layers = layers_of(t);
  Image color{kSide, kSide,
              std::vector<vec4>(size_t{kSide} * kSide, vec4(0.25f, 2.0f, 0.5f, 1.0f))};
  const TemporaryFolder folder;
  const std::string path = folder.path("a.exr");
  ASSERT_TRUE(write_frame_exr(path, color, layers, {}, t.camera, {{"Source", "square"}}));
  const Result<ExrImage> exr = read_exr(path);
  ASSERT_TRUE(exr) << exr.error().message();
  std::vector<std::string> names;
  for (const ExrPlane& plane : exr->planes) names.push_back(plane.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"A", "B", "G", "R", "depth.Z", "normal.X", "normal.Y",
                                      "normal.Z", "object.id", "primitive.id", "traversal.steps"}));
  EXPECT_EQ(exr->find("G")->floats[5], 2.0f);
  EXPECT_EQ(exr->find("depth.Z")->floats, layers.depth);
  EXPECT_EQ(exr->find("normal.Z")->floats[0], 1.0f);
  EXPECT_EQ(exr->find("object.id")->integers[0], 1u);
  EXPECT_EQ(exr->find("object.id")->integers[kSide - 1], 0u);
  EXPECT_EQ(exr->find("traversal.steps")->integers, layers.traversal);
  EXPECT_EQ(exr->attributes.texts, ImageMetadata({{"Source", "square"}}));

  ASSERT_TRUE(
      write_frame_exr(path, {}, layers, {false, true, false, false, false, false}, t.camera));
  EXPECT_EQ(read_exr(path)->planes.size(), 1u);
  ASSERT_TRUE(
      write_frame_exr(path, color, {}, {true, false, false, false, false, false}, t.camera));
  EXPECT_EQ(read_exr(path)->planes.size(), 4u);
}

// A point on the ray through a pixel is projected back to that pixel by the file's matrices.
TEST(FrameExr, TheCameraInTheFileIsTheOneThatDrew) {
  const Image color{40, 20, std::vector<vec4>(800)};
  const TemporaryFolder folder;
  for (const bool orthographic : {false, true}) {
    CameraView camera = look_at(vec3(3, 2, 5), vec3(0, 1, 0), vec3(0, 1, 0), 0.7f);
    camera.orthographic = orthographic;
    camera.ymag = 2.0f;
    const std::string path = folder.path("a.exr");
    ASSERT_TRUE(
        write_frame_exr(path, color, {}, {true, false, false, false, false, false}, camera));
    const ExrAttributes attributes = read_exr(path)->attributes;
    ASSERT_TRUE(attributes.world_to_camera && attributes.world_to_ndc);
    for (const vec2 at : {vec2(0, 0), vec2(40, 20), vec2(12.5f, 3.5f)}) {
      const Ray ray = camera_ray(camera, at.x, at.y, 40, 20);
      const vec4 point(ray.origin + 3.0f * ray.direction, 1.0f);
      const vec4 ndc = *attributes.world_to_ndc * point;
      EXPECT_NEAR(40.0f * ndc.x / ndc.w, at.x, 1e-4f);
      EXPECT_NEAR(20.0f * ndc.y / ndc.w, at.y, 1e-4f);
      const vec4 seen = *attributes.world_to_camera * point;
      EXPECT_GT(seen.z, 0.0f);
      EXPECT_EQ(seen.x > 0.0f, at.x > 20.0f);
      EXPECT_EQ(seen.y > 0.0f, at.y < 10.0f);
    }
  }
}

}  // namespace
}  // namespace sinew
