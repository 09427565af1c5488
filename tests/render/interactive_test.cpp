// Sub-sampling, time budgets and refinement.
#include <gtest/gtest.h>

#include <cmath>

#include "render/test_scene.h"
#include "sinew/render/camera_wave.h"
#include "sinew/render/refinement.h"

namespace sinew {
namespace {

using test::hash_of;
using test::pixel;
using test::TestScene;

// A lit mirror ball over a floor, with a shadow.
TestScene ball_scene() {
  TestScene t;
  t.scene.environment = {vec3(0.2f, 0.3f, 0.6f), vec3(0.5f), vec3(0.2f)};
  const uint32_t floor = t.add_material(vec3(0.7f, 0.6f, 0.5f));
  const uint32_t mirror = t.add_material(vec3(0.9f), 0.0f);
  t.scene.materials[mirror].metallic = 1.0f;
  t.place(t.add_quad(vec3(-9, -1, 9), vec3(18, 0, 0), vec3(0, 0, -18), floor));
  t.place(t.add_mesh(test::sphere(3), mirror));
  t.add_light(LightType::directional, vec3(0.0f), vec3(0.5f, -1, -0.4f), 2.0f);
  t.camera = look_at(vec3(0, 1, 5), vec3(0), vec3(0, 1, 0), 0.8f);
  t.settings.width = 90;
  t.settings.height = 70;
  return t;
}

double mean_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  double sum = 0.0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const vec4 d = abs(a.pixels[i] - b.pixels[i]);
    sum += (d.x + d.y + d.z) / 3.0;
  }
  return sum / static_cast<double>(a.pixels.size());
}

TEST(Subsampling, DrawsOneRayASquareAndInterpolates) {
  TestScene t = ball_scene();
  const Image full = t.render();
  for (const uint32_t step : {2u, 5u, 10u}) {
    t.settings.subsampling = step;
    const Image coarse = t.render();
    ASSERT_EQ(coarse.pixels.size(), full.pixels.size());
    EXPECT_EQ(t.stats.rays.primary, ((90 + step - 1) / step) * ((70 + step - 1) / step));
    for (const vec4& p : coarse.pixels) EXPECT_NEAR(p.w, 1.0f, 1e-5f);
    EXPECT_LT(mean_difference(coarse, full), 0.01 * step);
  }
}

TEST(Subsampling, IsExactOnRampsAndClampsAtEdges) {
  Image drawn{4, 2, {}};
  for (uint32_t i = 0; i < 8; ++i) drawn.pixels.push_back(vec4(vec3(float(i % 4)), 1.0f));
  // The interpolated quantity is x / (1 + x).
  const auto value = [](float at) {
    const float i = std::floor(at), f = at - i;
    const float y = (1 - f) * i / (1 + i) + f * (i + 1) / (2 + i);
    return y / (1 - y);
  };
  Image out{10, 5, std::vector<vec4>(50)};
  upsample(drawn, 3, out);  // the last column and row of squares reach beyond the image
  EXPECT_NEAR(pixel(out, 0, 0).x, 0.0f, 1e-6f);
  EXPECT_NEAR(pixel(out, 1, 2).x, 0.0f, 1e-6f);
  EXPECT_NEAR(pixel(out, 4, 0).x, 1.0f, 1e-5f);
  EXPECT_NEAR(pixel(out, 5, 4).x, value(1.0f + 1.0f / 3.0f), 1e-5f);
  EXPECT_NEAR(pixel(out, 9, 4).x, value(2.0f + 2.0f / 3.0f), 1e-5f);
}

TEST(CoarseToFine, VisitsEveryPixelOnceAndFillsWhatIsMissing) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, {8u, 8u}, {33u, 17u}, {90u, 70u}}) {
    CoarseToFine order;
    order.resize(width, height);
    ASSERT_EQ(order.count(), size_t{width} * height);
    EXPECT_EQ(order.coarsest(), size_t{(width + 7) / 8} * ((height + 7) / 8));
    const DrawnPixels pixels{CameraRays({}, width, height), {width, height}};
    Wave wave;
    order.start_wave(pixels, 0, order.count(), wave);
    std::vector<int> seen(order.count());
    for (size_t i = 0; i < wave.count; ++i) ++seen[wave.paths[i].pixel];
    for (const int count : seen) EXPECT_EQ(count, 1);

    // Whatever is drawn of a constant image, all of it comes out.
    for (const size_t drawn : {order.coarsest(), order.count() / 3, order.count()}) {
      if (drawn < order.coarsest()) continue;
      Image image{width, height, std::vector<vec4>(order.count(), vec4(-1.0f))};
      for (size_t i = 0; i < drawn; ++i) image.pixels[wave.paths[i].pixel] = vec4(0.5f);
      order.fill(drawn, image);
      for (const vec4& p : image.pixels) ASSERT_EQ(p, vec4(0.5f));
    }
  }
}

TEST(TimeBudget, WithTimeEnoughItIsTheWholePicture) {
  TestScene t = ball_scene();
  const Image whole = t.render();
  const RayCounts rays = t.stats.rays;
  t.settings.time_budget_ms = 1e6;
  const Image budgeted = t.render();
  EXPECT_EQ(hash_of(budgeted), hash_of(whole));
  EXPECT_EQ(t.stats.rays.total(), rays.total());
  EXPECT_EQ(t.stats.skipped.total(), 0u);
}

TEST(TimeBudget, WithoutTimeItTracesTheCoarsestLatticeAndNothingElse) {
  TestScene t = ball_scene();
  const Image whole = t.render();
  t.settings.time_budget_ms = 1e-6;
  const Image image = t.render();
  EXPECT_GE(t.stats.rays.primary, 12u * 9u);
  EXPECT_EQ(t.stats.rays.primary + t.stats.skipped.primary, 90u * 70u);
  EXPECT_EQ(t.stats.rays.shadow + t.stats.rays.reflection + t.stats.rays.ambient, 0u);
  EXPECT_GT(t.stats.skipped.shadow, 0u);
  EXPECT_GT(t.stats.skipped.reflection, 0u);
  EXPECT_LT(mean_difference(image, whole), 0.1);
}

TEST(Refinement, ASubsampledStillBecomesThePictureOfManySamples) {
  TestScene t = ball_scene();
  t.settings.samples = 64;
  const Image reference = t.render();
  const World world = t.prepare_world();
  t.settings.samples = 2;
  t.settings.subsampling = 5;
  const RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement;
  Image image;
  double last = 1e9;
  for (int frame = 0; frame < 17; ++frame) {
    refinement.draw(world, t.scene, world.pose(), t.camera, t.settings, *scratch, image);
    EXPECT_EQ(refinement.samples(), 2u * static_cast<uint32_t>(frame));
    if (frame != 0 && frame != 1 && frame != 16) continue;
    const double difference = mean_difference(image, reference);
    EXPECT_LT(difference, last) << frame;
    last = difference;
  }
  EXPECT_LT(last, 0.0025);
}

TEST(Refinement, FirstFrameIsThePictureItself) {
  TestScene t = ball_scene();
  t.settings.samples = 3;
  const Image picture = t.render();
  const World world = t.prepare_world();
  const RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement;
  Image image;
  refinement.draw(world, t.scene, world.pose(), t.camera, t.settings, *scratch, image);
  EXPECT_EQ(hash_of(image), hash_of(picture));
  EXPECT_EQ(refinement.samples(), 3u);
}

TEST(Refinement, WithATimeBudgetItGoesOnWhereItStopped) {
  TestScene t = ball_scene();
  const World world = t.prepare_world();
  t.settings.time_budget_ms = 1e-6;            // one batch of 32 tiles a frame
  t.settings.width = t.settings.height = 128;  // 64 tiles
  const RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement;
  Image image;
  for (int frame = 0; frame < 5; ++frame) {
    refinement.draw(world, t.scene, world.pose(), t.camera, t.settings, *scratch, image);
    EXPECT_EQ(refinement.samples(), static_cast<uint32_t>(frame / 2));
  }
  // Two passes, the first of which is the plain picture's.
  t.settings.time_budget_ms = 0.0;
  Image plain;
  render_frame(world, t.scene, world.pose(), t.camera, t.settings, *scratch, plain);
  EXPECT_LT(mean_difference(image, plain), 0.01);
}

TEST(Refinement, StartsAnewWhenSomethingMoves) {
  TestScene t = ball_scene();
  const World world = t.prepare_world();
  const RenderScratchPtr scratch = make_render_scratch();
  Refinement refinement;
  Image image;
  const auto draw = [&] {
    refinement.draw(world, t.scene, world.pose(), t.camera, t.settings, *scratch, image);
    return refinement.samples();
  };
  EXPECT_EQ(draw(), 1u);
  EXPECT_EQ(draw(), 2u);
  t.camera.to_world[3].x += 1e-3f;
  EXPECT_EQ(draw(), 1u);
  EXPECT_EQ(draw(), 2u);
  t.settings.exposure = 1.0f;
  EXPECT_EQ(draw(), 1u);
  EXPECT_EQ(draw(), 2u);
  t.scene.materials[0].base_color = vec4(1.0f);
  refinement.restart();
  EXPECT_EQ(draw(), 1u);
}

}  // namespace
}  // namespace sinew
