// Voxels in the rays of a picture: traced against rasterised, shadows, occlusion, mirrors, both
// ways between voxels and triangles.
#include <gtest/gtest.h>

#include <cmath>

#include "render/voxel_scene.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/render/layers.h"
#include "sinew/render/voxelize_scene.h"
#include "sinew/render/voxels/voxel_primary.h"

namespace sinew {
namespace {

using test::mean_difference;
using test::pixel;
using test::VoxelScene;

// Of display values, over all pixels.
double psnr(const Image& a, const Image& b) {
  Image8 x, y;
  tonemap(a, 0.0f, x);
  tonemap(b, 0.0f, y);
  double sum = 0.0;
  for (size_t i = 0; i < x.pixels.size(); ++i) {
    const double d = double(x.pixels[i]) - double(y.pixels[i]);
    sum += d * d;
  }
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(x.pixels.size()) / sum);
}

// Pixels of `a` that are covered, and further than a pixel from what `b` covers.
uint32_t beyond(const Image& a, const Image& b) {
  const auto covered = [](const Image& image, uint32_t x, uint32_t y) {
    return x < image.width && y < image.height && pixel(image, x, y).w > 0.0f;
  };
  uint32_t count = 0;
  for (uint32_t y = 0; y < a.height; ++y) {
    for (uint32_t x = 0; x < a.width; ++x) {
      if (!covered(a, x, y)) continue;
      bool near = false;
      for (uint32_t k = 0; k < 9; ++k) near |= covered(b, x + k % 3 - 1, y + k / 3 - 1);
      count += !near;
    }
  }
  return count;
}

// The study's creature as triangles or as voxels, walking, seen by the same camera.
struct Creature {
  VoxelScene s;
  Scene triangles;
  Creature(uint32_t resolution) {
    Result<Scene> loaded = load("study:creature");
    EXPECT_TRUE(loaded.has_value());
    triangles = std::move(*loaded);
    VoxelizeSceneOptions options;
    options.resolution = resolution;
    Result<VoxelizedScene> made = voxelize_scene(triangles, options);
    EXPECT_TRUE(made.has_value());
    s.scene = std::move(made->scene);
    s.settings.width = s.settings.height = 160;
  }
  Image render(const Scene& scene) {
    Result<World> world = prepare(scene);
    EXPECT_TRUE(world.has_value());
    EXPECT_TRUE(world->set_time(0.4).has_value());
    s.camera = frame_box(world->box(), vec3(0.7f, 0.35f, 0.6f), 0.6f, 1.0f);
    const RenderScratchPtr scratch = make_render_scratch();
    Image image;
    s.stats = render_frame(*world, scene, world->pose(), s.camera, s.settings, *scratch, image);
    return image;
  }
};

TEST(VoxelRays, TracedAndRasterisedPicturesAgree) {
  Creature c(300);
  RenderSettings& settings = c.s.settings;
  settings.transparent = true;
  settings.voxels.shadowing = VoxelShadowing::rays;
  for (const float lod : {0.0f, 0.75f, 3.0f}) {
    SCOPED_TRACE(lod);
    settings.voxels.lod = lod;
    settings.voxels.primary = VoxelPrimary::raster;
    const Image drawn = c.render(c.s.scene);
    EXPECT_EQ(c.s.stats.voxels.traced, 0u);
    settings.voxels.primary = VoxelPrimary::trace;
    const Image traced = c.render(c.s.scene);
    EXPECT_EQ(c.s.stats.voxels.traced, c.s.stats.voxels.objects);
    EXPECT_GT(c.s.stats.voxels.objects, 0u);
    EXPECT_EQ(beyond(drawn, traced), 0u);
    EXPECT_EQ(beyond(traced, drawn), 0u);
    const double agreement = psnr(drawn, traced);
    RecordProperty("psnr_lod_" + std::to_string(lod), std::to_string(agreement));
    EXPECT_GT(agreement, 25.0);
  }
}

TEST(VoxelRays, ShadowsByRaysAreLikeThoseByMaps) {
  Creature c(300);
  c.s.settings.voxels.shadowing = VoxelShadowing::maps;
  const Image maps = c.render(c.s.scene);
  EXPECT_TRUE(c.s.stats.voxels.shadow_maps);
  c.s.settings.voxels.shadowing = VoxelShadowing::rays;
  const Image rays = c.render(c.s.scene);
  EXPECT_FALSE(c.s.stats.voxels.shadow_maps);
  EXPECT_GT(c.s.stats.rays.shadow, 1000u);
  EXPECT_GT(psnr(maps, rays), 22.0);
}

TEST(VoxelRays, SameBitsForAnyNumberOfThreads) {
  VoxelScene s;
  s.place_ball(vec3(-0.4f, 0.0f, 0.0f));
  s.place_ball(vec3(0.5f, 0.5f, 0.3f), 0.5f);
  s.add_light(LightType::directional, vec3(2, 3, 1), vec3(-2, -3, -1), 2.0f);
  s.place(s.add_quad({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}, s.add_material(vec3(0.9f), 0.0f)));
  s.settings.ambient_rays = 2;
  s.settings.voxels.primary = VoxelPrimary::trace;
  const Image expected = s.render();
  EXPECT_GT(s.stats.rays.reflection, 0u);
  for (const int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    EXPECT_TRUE(s.render().pixels == expected.pixels) << threads;
  }
}

// What a convex body shows of rays that meet it where they begin.
TEST(VoxelRays, AConvexBodyShadesNothingOfItself) {
  for (const VoxelPrimary primary : {VoxelPrimary::raster, VoxelPrimary::trace}) {
    for (const float lod : {0.0f, 0.75f, 4.0f}) {
      SCOPED_TRACE(testing::Message() << "lod " << lod << ", " << static_cast<int>(primary));
      VoxelScene s;
      s.place_ball(vec3(0.0f));
      s.scene.nodes.back().rotation = glm::angleAxis(0.6f, normalize(vec3(1, 2, 3)));
      s.settings.voxels.primary = primary;
      s.settings.voxels.lod = lod;
      s.settings.voxels.shadowing = VoxelShadowing::rays;
      s.scene.environment.ambient = vec3(1.0f);
      s.settings.ambient_rays = 16;
      const Image occluded = s.render();
      s.settings.ambient_rays = 0;
      const Image open = s.render();
      double sum = 0.0;
      float least = 1.0f;
      uint32_t count = 0;
      for (size_t i = 0; i < open.pixels.size(); ++i) {
        if (!(open.pixels[i].x > 0.02f) || open.pixels[i].w < 1.0f) continue;
        const float share = occluded.pixels[i].x / open.pixels[i].x;
        sum += share;
        least = std::min(least, share);
        ++count;
      }
      EXPECT_GT(count, 1000u);
      EXPECT_GT(sum / count, 0.99);
      EXPECT_GT(least, 0.7f);
    }
  }
}

TEST(VoxelRays, OcclusionDarkensWhereTheyTouch) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  s.place(s.add_quad({-4, -1, 4}, {8, 0, 0}, {0, 0, -8}, s.add_material(vec3(0.8f))));
  s.camera = look_at(vec3(0.0f, 1.0f, 8.0f), vec3(0.0f, -0.5f, 0.0f), vec3(0, 1, 0), 0.5f);
  s.scene.environment.ambient = vec3(1.0f);
  s.settings.ambient_rays = 64;
  s.settings.ambient_distance = 1.5f;
  for (const VoxelPrimary primary : {VoxelPrimary::raster, VoxelPrimary::trace}) {
    s.settings.voxels.primary = primary;
    const Image image = s.render();
    const auto at = [&](vec3 p) {
      const RasterView view = camera_raster_view(s.camera, 128, 128);
      const vec4 q(p, 1.0f);
      const float w = dot(view.w, q);
      return pixel(image, static_cast<uint32_t>(dot(view.x, q) / w),
                   static_cast<uint32_t>(dot(view.y, q) / w));
    };
    const float far = at({2.0f, -1.0f, 0.5f}).x, close = at({0.0f, -1.0f, 0.6f}).x;
    EXPECT_LT(close, 0.75f * far);
    // The ball's lower half is blue: above the ground, and near it.
    const float middle = at({0.0f, -0.1f, 0.99f}).z, foot = at({0.0f, -0.85f, 0.52f}).z;
    EXPECT_LT(foot, 0.6f * middle);
  }
}

// A mirror shows what the camera would see from behind it.
TEST(VoxelRays, MirrorsOfTrianglesShowVoxels) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  Material mirror;
  mirror.base_color = vec4(1.0f);
  mirror.metallic = 1.0f;
  mirror.roughness = 0.0f;
  s.scene.materials.push_back(mirror);
  s.place(s.add_quad({-9, -9, -3}, {18, 0, 0}, {0, 18, 0},
                     static_cast<uint32_t>(s.scene.materials.size() - 1)));
  s.scene.environment.ambient = vec3(1.0f);
  // Looks at the mirror alone, the ball behind the camera's back.
  s.camera = look_at(vec3(0.3f, 0.2f, -1.5f), vec3(0.0f, 0.0f, -3.0f), vec3(0, 1, 0), 0.9f);
  const Image reflected = s.render();
  EXPECT_EQ(s.stats.rays.reflection, 128u * 128u);
  // The same eye, mirrored.
  s.camera = look_at(vec3(0.3f, 0.2f, -4.5f), vec3(0.0f, 0.0f, -3.0f), vec3(0, 1, 0), 0.9f);
  s.scene.nodes.back().mesh = -1;
  Image direct = s.render();
  for (uint32_t y = 0; y < 128; ++y) {
    std::reverse(direct.pixels.begin() + y * 128, direct.pixels.begin() + (y + 1) * 128);
  }
  uint32_t red = 0;
  for (const vec4& p : direct.pixels) red += p.x > 2.0f * p.z && p.x > 0.1f;
  EXPECT_GT(red, 500u);
  EXPECT_GT(psnr(reflected, direct), 25.0);
}

TEST(VoxelRays, MirrorsOfVoxelsShowTriangles) {
  VoxelScene s;
  s.scene.materials[0].metallic = 1.0f;
  s.scene.materials[0].roughness = 0.0f;
  for (uint16_t& color : s.scene.octrees[0].colors) color = pack_color(vec3(1.0f));
  s.place_ball(vec3(0.0f));
  const uint32_t red = s.add_material(vec3(0.9f, 0.0f, 0.0f));
  s.scene.environment.ambient = vec3(1.0f);
  // Behind the camera, as a wall.
  s.place(s.add_quad({-20, -20, 12}, {40, 0, 0}, {0, 40, 0}, red));
  s.camera = look_at(vec3(0.0f, 0.0f, 8.0f), vec3(0.0f), vec3(0, 1, 0), 0.4f);
  for (const VoxelPrimary primary : {VoxelPrimary::raster, VoxelPrimary::trace}) {
    s.settings.voxels.primary = primary;
    const Image image = s.render();
    const vec4 middle = pixel(image, 64, 64);
    EXPECT_GT(middle.x, 0.3f);
    EXPECT_LT(middle.y, 0.1f * middle.x);
    // And a ball of voxels in a mirror of voxels.
    EXPECT_GT(s.stats.rays.reflection, 500u);
  }
}

TEST(VoxelRays, BlendsLieBeforeVoxels) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  Material glass;
  glass.base_color = vec4(0.0f, 0.0f, 0.0f, 0.5f);
  glass.alpha_mode = AlphaMode::blend;
  glass.unlit = true;
  s.scene.materials.push_back(glass);
  s.settings.shadows = false;
  s.scene.environment.ambient = vec3(1.0f);
  s.camera = look_at(vec3(0.0f, 0.0f, 8.0f), vec3(0.0f), vec3(0, 1, 0), 0.4f);
  const vec4 open = pixel(s.render(), 64, 60);
  s.place(s.add_quad({-4, -4, 2}, {8, 0, 0}, {0, 8, 0},
                     static_cast<uint32_t>(s.scene.materials.size() - 1)));
  for (const VoxelPrimary primary : {VoxelPrimary::raster, VoxelPrimary::trace}) {
    s.settings.voxels.primary = primary;
    const vec4 behind = pixel(s.render(), 64, 60);
    EXPECT_NEAR(behind.x, 0.5f * open.x, 0.03f * open.x);
  }
}

TEST(VoxelRays, LayersAreTheSameDrawnOrTraced) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  s.place(s.add_quad({-2, -2, 0}, {2, 0, 0}, {0, 4, 0}, 0));
  const World world = s.prepare_world();
  FrameLayers layers[2];
  for (int i = 0; i < 2; ++i) {
    LayerScratch scratch;
    VoxelSettings voxels;
    voxels.primary = i == 0 ? VoxelPrimary::raster : VoxelPrimary::trace;
    trace_layers(world, s.scene, world.pose(), s.camera, 128, 128, {}, scratch, layers[i], voxels);
  }
  uint32_t same = 0, voxels = 0, steps = 0;
  for (size_t i = 0; i < layers[0].object.size(); ++i) {
    if (layers[0].object[i] != 1 || layers[1].object[i] != 1) continue;
    ++voxels;
    const bool near = std::abs(layers[0].depth[i] - layers[1].depth[i]) < 0.06f;
    same += near && dot(layers[0].normal[i], layers[1].normal[i]) > 0.95f;
    steps += layers[1].traversal[i] > 0;
  }
  EXPECT_GT(voxels, 2000u);
  EXPECT_GT(same, 0.9 * voxels);
  EXPECT_EQ(steps, voxels);
}

TEST(VoxelPrimary, TheCheaperIsChosen) {
  VoxelScene s;
  s.place_ball(vec3(0.0f));
  list_objects(s.scene);
  ScenePose pose;
  sample(s.scene, kRestPose, 0.0, pose);
  VoxelBodies bodies;
  bodies.bind(s.scene);
  bodies.set_pose(s.scene, pose);
  const VoxelInstance& object = bodies.instances()[0];
  const auto view = [](float distance) {
    const CameraView camera = look_at(vec3(0, 0, distance), vec3(0.0f), vec3(0, 1, 0), 0.6f);
    return camera_raster_view(camera, 256, 256);
  };
  VoxelSettings settings;
  const PrimaryCosts near = estimate_primary(object, view(4.0f), settings);
  EXPECT_LT(near.raster_us, near.trace_us);
  EXPECT_FALSE(is_traced(object, view(4.0f), settings, true));
  // Without levels of detail all voxels are drawn for a few pixels.
  settings.lod = 0.0f;
  EXPECT_TRUE(is_traced(object, view(400.0f), settings, true));
  EXPECT_FALSE(is_traced(object, view(400.0f), settings, false));
  settings.primary = VoxelPrimary::trace;
  EXPECT_TRUE(is_traced(object, view(4.0f), settings, false));
  settings.primary = VoxelPrimary::raster;
  EXPECT_FALSE(is_traced(object, view(400.0f), settings, true));
  settings = {.skinning = VoxelSkinning::thesis, .primary = VoxelPrimary::trace};
  EXPECT_FALSE(is_traced(object, view(4.0f), settings, true));
  // In it, and behind the eye.
  settings = {};
  for (const float distance : {0.0f, 0.9f, -4.0f}) {
    const PrimaryCosts costs = estimate_primary(object, view(distance), settings);
    EXPECT_TRUE(std::isfinite(costs.raster_us) && std::isfinite(costs.trace_us)) << distance;
  }
}

}  // namespace
}  // namespace sinew
