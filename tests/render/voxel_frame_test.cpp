// Pictures of voxels through render_frame(): shadows, mixed scenes, and the rasterised picture
// against the traced pipeline, which resolves one voxel after the other.
#include "sinew/render/voxels/voxel_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/voxel_scene.h"
#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/render/layers.h"

namespace sinew {
namespace {

using test::mean_difference;
using test::TestScene;
using test::VoxelScene;

// The light of one kind alone, on balls that only shade themselves.
float least_lit_share(LightType type, float least_cosine, uint32_t map) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  s.settings.voxels.shadow_map = map;
  Light& light = s.add_light(type, vec3(2.5f, 3.0f, 2.0f), vec3(-2.5f, -3.0f, -2.0f), 10.0f);
  light.outer_cone = 0.5f;
  list_objects(s.scene);
  ScenePose pose;
  sample(s.scene, kRestPose, 0.0, pose);
  std::vector<ShadingLight> lights;
  gather_lights(s.scene, pose, s.camera, lights);
  TextureTable textures;
  textures.build(s.scene);
  VoxelFrame frame;
  frame.bind(s.scene, textures);
  frame.begin(s.scene, pose, s.settings.voxels);
  frame.set_shadows(lights, true);
  frame.draw(s.camera, 128, 128, 1, vec2(0.5f));
  float least = 1.0f;
  uint32_t looked = 0;
  for (size_t pixel = 0; pixel < 128 * 128; ++pixel) {
    if (frame.visibility().keys[pixel] == kNothing) continue;
    const Ray ray = CameraRays(s.camera, 128, 128)(static_cast<float>(pixel % 128) + 0.5f,
                                                   static_cast<float>(pixel / 128) + 0.5f);
    Surface surface;
    frame.resolve(pixel, ray, {}, surface);
    const vec3 to_light = illuminate(lights[0], surface.position).direction;
    const float cosine = dot(surface.normal, to_light);
    if (cosine < least_cosine) continue;
    ++looked;
    least = std::min(least, lit_share(frame.shadows()[0],
                                      {surface.position, surface.normal, cosine, surface.voxel}));
  }
  EXPECT_GT(looked, 500u);
  return least;
}

TEST(VoxelShadows, AConvexBodyDoesNotShadeItself) {
  for (const LightType type : {LightType::directional, LightType::spot, LightType::point}) {
    for (const uint32_t map : {64u, 256u, 1024u}) {
      SCOPED_TRACE(testing::Message() << "light " << static_cast<int>(type) << ", map " << map);
      EXPECT_GE(least_lit_share(type, 0.1f, map), 0.999f);
    }
  }
}

// A small ball above a large one, the light above both.
TEST(VoxelShadows, FallFromOneBodyOnAnother) {
  for (const LightType type : {LightType::directional, LightType::spot, LightType::point}) {
    SCOPED_TRACE(testing::Message() << "light " << static_cast<int>(type));
    VoxelScene s;
    s.place_ball(vec3(0.0f));
    s.place_ball(vec3(0.0f, 1.8f, 0.0f), 0.3f);
    s.camera = look_at(vec3(3.0f, 4.0f, 3.0f), vec3(0.0f), vec3(0, 1, 0), 0.6f);
    s.add_light(type, vec3(0.0f, 8.0f, 0.0f), vec3(0.0f, -1.0f, 0.0f), 30.0f);
    const Image with = s.render();
    s.settings.shadows = false;
    const Image without = s.render();
    uint32_t dark = 0, between = 0, same = 0;
    for (size_t i = 0; i < with.pixels.size(); ++i) {
      if (with.pixels[i].w < 1.0f || !(without.pixels[i].x > 0.02f)) continue;
      const float share = with.pixels[i].x / without.pixels[i].x;
      dark += share < 0.02f;
      between += share >= 0.02f && share < 0.95f;
      same += share >= 0.95f;
    }
    EXPECT_GT(dark, 100u);
    EXPECT_GT(between, 10u);  // a filtered edge
    EXPECT_LT(between, dark + 200u);
    EXPECT_GT(same, 1500u);
  }
}

// The same lights, once through the kernels and once through the pipeline of traced surfaces.
TEST(VoxelFrame, RasterisedPictureIsTheTracedPipelines) {
  for (const bool lights : {false, true}) {
    VoxelScene s;
    s.scene.environment = {};
    s.place_ball(vec3(-0.4f, 0.0f, 0.0f));
    s.place_ball(vec3(0.8f, 0.8f, 0.3f), 0.5f);
    if (lights) {
      s.add_light(LightType::directional, vec3(2, 3, 1), vec3(-2, -3, -1), 2.0f);
      s.add_light(LightType::spot, vec3(-3, 3, 3), vec3(3, -3, -3), 20.0f).outer_cone = 0.4f;
      s.add_light(LightType::point, vec3(0.5f, -2, 2), vec3(0, 0, -1), 5.0f);
    }
    s.settings.samples = 3;
    s.settings.voxels.shadowing = VoxelShadowing::maps;
    s.settings.voxels.primary = VoxelPrimary::raster;
    const Image alone = s.render();
    EXPECT_EQ(s.stats.rays.total(), 0u);
    s.add_unseen_triangle();
    const Image traced = s.render();
    EXPECT_GT(s.stats.rays.primary, 0u);
    EXPECT_LT(mean_difference(alone, traced), 2e-4);
  }
}

TEST(VoxelFrame, SameBitsForAnyNumberOfThreads) {
  VoxelScene s;
  s.scene.environment = {};
  s.place_ball(vec3(-0.4f, 0.0f, 0.0f));
  s.place_ball(vec3(0.5f, 0.5f, 0.3f), 0.5f);
  s.settings.samples = 2;
  const Image expected = s.render();
  for (const int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    EXPECT_TRUE(s.render().pixels == expected.pixels);
  }
}

TEST(VoxelFrame, BackgroundMayBeLeftOut) {
  VoxelScene s;
  s.scene.environment = {};
  s.place_ball(vec3(0.0f));
  s.settings.transparent = true;
  const Image image = s.render();
  EXPECT_EQ(image.pixels[0], vec4(0.0f));
  EXPECT_EQ(image.pixels[64 * 128 + 64].w, 1.0f);
  s.settings.transparent = false;
  EXPECT_EQ(s.render().pixels[0].w, 1.0f);
}

TEST(VoxelFrame, SubsampledPicturesAreLikeFullOnes) {
  VoxelScene s;
  s.scene.environment = {};
  s.place_ball(vec3(0.0f));
  const Image full = s.render();
  s.settings.subsampling = 2;
  const Image coarse = s.render();
  ASSERT_EQ(coarse.pixels.size(), full.pixels.size());
  EXPECT_LT(mean_difference(full, coarse), 0.02);
}

// A floor through the ball's middle hides its lower half, which is blue; a roof takes its light.
TEST(MixedFrame, TheNearerOneIsSeenAndEachShadesTheOther) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  s.camera = look_at(vec3(0.0f, 5.0f, 5.0f), vec3(0.0f), vec3(0, 1, 0), 0.8f);
  s.add_light(LightType::directional, vec3(0, 5, 0), vec3(1.0f, -1.0f, 0.0f), 3.0f);
  const uint32_t white = s.add_material(vec3(0.8f));
  s.place(s.add_quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, white));
  const auto at = [&](const Image& image, vec3 p) {
    const RasterView view = camera_raster_view(s.camera, 128, 128);
    const vec4 q(p, 1.0f);
    const float w = dot(view.w, q);
    return vec3(image.pixels[static_cast<size_t>(dot(view.y, q) / w) * 128 +
                             static_cast<size_t>(dot(view.x, q) / w)]);
  };
  const Image open = s.render();
  for (const vec4& pixel : open.pixels) EXPECT_LE(pixel.z, 1.05f * pixel.x + 1e-3f) << "blue";
  const vec3 top = at(open, {0.0f, 1.0f, 0.1f});
  EXPECT_GT(top.x, 3.0f * top.z);                    // the ball, lit
  EXPECT_GT(at(open, {-1.6f, 0.0f, 0.0f}).x, 0.5f);  // the floor, lit
  EXPECT_LT(at(open, {1.2f, 0.0f, 0.0f}).x, 0.01f);  // in the ball's shadow
  s.place(s.add_quad({-1.6f, 2, 0.8f}, {1.6f, 0, 0}, {0, 0, -1.6f}, white));  // shades the top
  s.camera = look_at(vec3(0.0f, 1.2f, 5.0f), vec3(0.0f), vec3(0, 1, 0), 0.8f);
  const Image roofed = s.render();
  EXPECT_LT(at(roofed, {0.3f, 0.92f, 0.25f}).x, 0.01f);
}

TEST(MixedFrame, LayersShowTheNearerOne) {
  VoxelScene s;
  s.camera = TestScene().camera;
  s.camera.ymag = 1.5f;
  s.place_ball(vec3(0.0f));
  s.place(s.add_quad({-2, -2, 0}, {2, 0, 0}, {0, 4, 0}, 0));  // hides half of the ball's back
  const World world = s.prepare_world();
  LayerScratch scratch;
  FrameLayers layers;
  trace_layers(world, s.scene, world.pose(), s.camera, 129, 129, {}, scratch, layers);
  const size_t middle = 64 * 129 + 64, beside = 64 * 129 + 2, empty = 64 * 129 + 127;
  EXPECT_EQ(layers.object[middle], 1u);  // after the scene's objects
  EXPECT_NEAR(layers.depth[middle], 9.0f, 0.05f);
  EXPECT_GT(layers.normal[middle].z, 0.99f);
  EXPECT_EQ(layers.object[beside], 0u);
  EXPECT_NEAR(layers.depth[beside], 10.0f, 1e-4f);
  EXPECT_EQ(layers.object[empty], kNoObject);
  EXPECT_FALSE(std::isfinite(layers.depth[empty]));
}

}  // namespace
}  // namespace sinew
