#include "sinew/render/views.h"

#include <gtest/gtest.h>

#include "sinew/render/box_lines.h"
#include "sinew/render/color_map.h"
#include "test_scene.h"

namespace sinew {
namespace {

// Relative luminance of an sRGB colour, 0..1.
double luminance(Color8 c) {
  const auto linear = [](uint8_t v) {
    const double s = v / 255.0;
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
}

TEST(ColorMap, HeatGrowsEvenlyLighter) {
  EXPECT_EQ(heat_color(0.0f), (Color8{0, 0, 0}));
  EXPECT_EQ(heat_color(-1.0f), heat_color(0.0f));
  EXPECT_EQ(heat_color(NAN), heat_color(0.0f));
  EXPECT_EQ(heat_color(7.0f), heat_color(1.0f));
  EXPECT_GT(luminance(heat_color(1.0f)), 0.85);
  // CIE lightness: steps of a tenth are alike, within what different measures of lightness differ.
  const auto lightness = [](float x) { return 116.0 * std::cbrt(luminance(heat_color(x))) - 16.0; };
  for (int i = 2; i <= 10; ++i) {
    const float x = 0.1f * static_cast<float>(i);
    EXPECT_NEAR(lightness(x) - lightness(x - 0.1f), 10.0, 4.5) << x;
  }
}

TEST(ColorMap, NeighbouringIndicesDiffer) {
  for (uint32_t i = 0; i < 1000; ++i) {
    const Color8 a = index_color(i), b = index_color(i + 1);
    int difference = 0;
    for (size_t c = 0; c < 3; ++c) difference += std::abs(a[c] - b[c]);
    EXPECT_GT(difference, 60) << i;
  }
}

TEST(Views, ScalesAreRoundNumbers) {
  EXPECT_EQ(round_scale(0), 10u);
  EXPECT_EQ(round_scale(10), 10u);
  EXPECT_EQ(round_scale(11), 12u);
  EXPECT_EQ(round_scale(61), 80u);
  EXPECT_EQ(round_scale(81), 100u);
  EXPECT_EQ(round_scale(1201), 1500u);
  EXPECT_EQ(round_scale(4294967295u), 4294967295u);
}

TEST(Views, SummariesCount) {
  std::vector<uint32_t> steps(400, 2);
  steps[7] = 100;
  steps[8] = 50;
  const StepSummary summary = summarize_steps(steps);
  EXPECT_EQ(summary.largest, 100u);
  EXPECT_EQ(summary.high, 2u);
  EXPECT_DOUBLE_EQ(summary.mean, (398 * 2 + 150) / 400.0);
  EXPECT_EQ(summarize_steps({}).largest, 0u);
}

TEST(Views, PixelsShowTheirLayer) {
  FrameLayers layers;
  layers.width = 2;
  layers.height = 1;
  layers.traversal = {0, 30};
  layers.normal = {vec3(0), vec3(1, 0, -1)};
  layers.depth = {std::numeric_limits<float>::infinity(), 4.0f};
  layers.object = {kNoObject, 3};
  Image8 image;
  const auto at = [&](uint32_t x) {
    return Color8{image.at(x, 0)[0], image.at(x, 0)[1], image.at(x, 0)[2]};
  };
  draw_heatmap(layers, 60, image);
  EXPECT_EQ(at(0), heat_color(0.0f));
  EXPECT_EQ(at(1), heat_color(0.5f));
  draw_normals(layers, image);
  EXPECT_EQ(at(0), (Color8{0, 0, 0}));
  EXPECT_EQ(at(1), (Color8{255, 128, 0}));
  draw_depth(layers, image);
  EXPECT_EQ(at(0), (Color8{0, 0, 0}));
  EXPECT_EQ(at(1), (Color8{255, 255, 255}));
  layers.normal[1] = vec3(0, 0, 1);
  draw_objects(layers, CameraView{}, image);
  EXPECT_EQ(at(0), (Color8{0, 0, 0}));
  EXPECT_EQ(at(1), index_color(3));
}

// The edges of a unit square's box, seen from the front, are where they belong; half of one is
// hidden.
TEST(BoxLines, EdgesStandWhereTheyProject) {
  test::TestScene t;
  t.camera.ymag = 2.0f;  // 8 pixels a unit
  t.place(t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), t.add_material(vec3(0.5f))));
  const World world = t.prepare_world();
  Image8 image{32, 32, std::vector<uint8_t>(4 * 32 * 32, 255)};
  std::vector<float> depth(32 * 32, std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < 16 * 32; ++i) depth[i] = 5.0f;  // the upper half is hidden
  EXPECT_EQ(draw_boxes(world, 0, t.camera, depth, image), 1u);
  const auto darkness = [&](uint32_t x, uint32_t y) {
    return 3 * 255 - image.at(x, y)[0] - image.at(x, y)[1] - image.at(x, y)[2];
  };
  // Edges at x and y = 8 and 24 lie between two pixels, which share them.
  for (const uint32_t x : {7u, 8u, 23u, 24u}) {
    EXPECT_GT(darkness(x, 20), 3 * darkness(x, 12)) << x;
    EXPECT_GT(darkness(x, 12), 0) << x;
  }
  EXPECT_GT(darkness(12, 24), 0);
  EXPECT_EQ(darkness(16, 16), 0);
  EXPECT_EQ(darkness(3, 16), 0);
  EXPECT_EQ(darkness(16, 29), 0);
}

TEST(BoxLines, EyesInsideABoxAndFarCornersAreNoProblem) {
  test::TestScene t;
  const float far = 1e18f;
  t.place(t.add_quad(vec3(-far, -far, -1), vec3(2 * far, 0, 0), vec3(0, 2 * far, 2 * far),
                     t.add_material(vec3(0.5f))));
  t.camera = look_at(vec3(0, 0, 3), vec3(1, 0, 0), vec3(0, 1, 0), 1.0f);
  const World world = t.prepare_world();
  Image8 image{16, 16, std::vector<uint8_t>(4 * 16 * 16, 0)};
  const std::vector<float> depth(16 * 16, 1.0f);
  for (const uint32_t level : {0u, 1u, 2u}) {
    EXPECT_GE(draw_boxes(world, level, t.camera, depth, image), 1u);
  }
}

}  // namespace
}  // namespace sinew
