#include "sinew/render/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew {
namespace {

// Red, green / blue, white: (0, 0) is the red texel, upper left.
Image8 four_texels() {
  return {2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0}};
}

// 4 x 1 with values 0, 1/3, 2/3, 1 in red.
Image8 ramp() {
  return {4, 1, {0, 0, 0, 255, 85, 0, 0, 255, 170, 0, 0, 255, 255, 0, 0, 255}};
}

TextureRef nearest(Wrap wrap = Wrap::repeat) {
  TextureRef texture;
  texture.image = 0;
  texture.nearest = true;
  texture.wrap_s = texture.wrap_t = wrap;
  return texture;
}

float red_at(float u, Wrap wrap, bool is_nearest) {
  TextureRef texture = nearest(wrap);
  texture.nearest = is_nearest;
  return sample_linear(ramp(), texture, vec2(u, 0.5f)).x;
}

TEST(Texture, OriginIsUpperLeft) {
  const Image8 image = four_texels();
  EXPECT_EQ(sample_linear(image, nearest(), vec2(0.25f, 0.25f)), vec4(1, 0, 0, 1));
  EXPECT_EQ(sample_linear(image, nearest(), vec2(0.75f, 0.25f)), vec4(0, 1, 0, 1));
  EXPECT_EQ(sample_linear(image, nearest(), vec2(0.25f, 0.75f)), vec4(0, 0, 1, 1));
  EXPECT_EQ(sample_linear(image, nearest(), vec2(0.75f, 0.75f)), vec4(1, 1, 1, 0));
}

TEST(Texture, DecodesColourButNotAlpha) {
  EXPECT_EQ(srgb_to_linear(0), 0.0f);
  EXPECT_EQ(srgb_to_linear(255), 1.0f);
  EXPECT_NEAR(srgb_to_linear(188), 0.5029f, 1e-4f);
  EXPECT_NEAR(srgb_to_linear(10), 10.0f / 255.0f / 12.92f, 1e-7f);
  const Image8 grey{1, 1, {188, 188, 188, 188}};
  const vec4 texel = sample_srgb(grey, nearest(), vec2(0.5f));
  EXPECT_NEAR(texel.x, 0.5029f, 1e-4f);
  EXPECT_NEAR(texel.w, 188.0f / 255.0f, 1e-6f);
}

TEST(Texture, WrapModes) {
  EXPECT_NEAR(red_at(1.125f, Wrap::repeat, true), 0.0f, 1e-6f);
  EXPECT_NEAR(red_at(-0.125f, Wrap::repeat, true), 1.0f, 1e-6f);
  EXPECT_NEAR(red_at(1.125f, Wrap::mirror, true), 1.0f, 1e-6f);
  EXPECT_NEAR(red_at(-0.375f, Wrap::mirror, true), 1.0f / 3.0f, 1e-6f);
  EXPECT_NEAR(red_at(2.125f, Wrap::mirror, true), 0.0f, 1e-6f);
  EXPECT_NEAR(red_at(7.0f, Wrap::clamp, true), 1.0f, 1e-6f);
  EXPECT_NEAR(red_at(-7.0f, Wrap::clamp, true), 0.0f, 1e-6f);
}

TEST(Texture, BilinearBlendsAcrossTheSeamAsWrapSays) {
  EXPECT_NEAR(red_at(0.25f, Wrap::repeat, false), 0.5f / 3.0f, 1e-6f);
  EXPECT_NEAR(red_at(0.0f, Wrap::repeat, false), 0.5f, 1e-6f);  // first with last
  EXPECT_NEAR(red_at(0.0f, Wrap::clamp, false), 0.0f, 1e-6f);
  EXPECT_NEAR(red_at(1.0f, Wrap::mirror, false), 1.0f, 1e-6f);
  EXPECT_NEAR(red_at(2.0f, Wrap::mirror, false), 0.0f, 1e-6f);
}

TEST(Texture, OddCoordinatesStayInTheImage) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
    for (bool is_nearest : {false, true}) {
      for (float u : {-1e30f, -1e-30f, -1.0f, 1.0f, 0.99999997f, 1.9999999f, 1e9f, 1e30f, kInf,
                      -kInf, std::nanf("")}) {
        const float red = red_at(u, wrap, is_nearest);
        EXPECT_TRUE(red >= 0.0f && red <= 1.0f) << u;
      }
    }
  }
}

TEST(Texture, TransformScalesThenRotatesThenMoves) {
  TextureRef texture;
  texture.scale = vec2(2.0f, 3.0f);
  texture.rotation = 1.57079633f;  // counter-clockwise, v down: +u goes to -v
  texture.offset = vec2(0.5f, 0.25f);
  const vec2 a = transform_texcoord(texture, vec2(1.0f, 0.0f));
  EXPECT_NEAR(a.x, 0.5f, 1e-6f);
  EXPECT_NEAR(a.y, 0.25f - 2.0f, 1e-6f);
  const vec2 b = transform_texcoord(texture, vec2(0.0f, 1.0f));
  EXPECT_NEAR(b.x, 3.5f, 1e-6f);
  EXPECT_NEAR(b.y, 0.25f, 1e-6f);
}

TEST(Texture, EmptyAndMissingImagesAreNone) {
  const std::vector<Image8> images(1);
  TextureRef texture;
  EXPECT_EQ(texture_image(images, texture), nullptr);
  texture.image = 0;
  EXPECT_EQ(texture_image(images, texture), nullptr);
  texture.image = 5;
  EXPECT_EQ(texture_image(images, texture), nullptr);
}

}  // namespace
}  // namespace sinew
