#include "sinew/render/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/math/srgb.h"

namespace sinew {
namespace {

// As data, at a point.
vec4 read_data(const Image8& image, const TextureRef& texture, vec2 uv) {
  return sample_linear(make_mip_map(image, false), texture, {uv});
}

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
  return read_data(ramp(), texture, vec2(u, 0.5f)).x;
}

TEST(Texture, OriginIsUpperLeft) {
  const Image8 image = four_texels();
  EXPECT_EQ(read_data(image, nearest(), vec2(0.25f, 0.25f)), vec4(1, 0, 0, 1));
  EXPECT_EQ(read_data(image, nearest(), vec2(0.75f, 0.25f)), vec4(0, 1, 0, 1));
  EXPECT_EQ(read_data(image, nearest(), vec2(0.25f, 0.75f)), vec4(0, 0, 1, 1));
  EXPECT_EQ(read_data(image, nearest(), vec2(0.75f, 0.75f)), vec4(1, 1, 1, 0));
}

TEST(Texture, DecodesColourButNotAlpha) {
  EXPECT_EQ(srgb_codes_to_linear()[0], 0.0f);
  EXPECT_EQ(srgb_codes_to_linear()[255], 1.0f);
  EXPECT_NEAR(srgb_codes_to_linear()[188], 0.5029f, 1e-4f);
  EXPECT_NEAR(srgb_codes_to_linear()[10], 10.0f / 255.0f / 12.92f, 1e-7f);
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

TEST(Texture, CodesAndValuesAgree) {
  for (int code = 0; code < 256; ++code) {
    const float linear = srgb_codes_to_linear()[static_cast<size_t>(code)];
    EXPECT_NEAR(linear, srgb_to_linear(static_cast<float>(code) / 255.0f), 1e-6f);
    EXPECT_EQ(linear_to_srgb_code(linear), code);
  }
}

TEST(MipMap, LevelsAreMeansOfLightWithoutFringes) {
  // A chequerboard of black and white is half as bright as white, whatever its code is.
  Image8 board{5, 3, {}};
  for (int i = 0; i < 15; ++i) {
    const uint8_t v = i % 2 == 0 ? 255 : 0;
    board.pixels.insert(board.pixels.end(), {v, v, v, 255});
  }
  const MipMap map = make_mip_map(board, true);
  ASSERT_EQ(map.smaller.size(), 2u);
  EXPECT_EQ(map.smaller[0].width, 2u);
  EXPECT_EQ(map.smaller[0].height, 1u);
  EXPECT_EQ(map.smaller[1].width, 1u);
  EXPECT_NEAR(srgb_codes_to_linear()[map.smaller[1].pixels[0]], 8.0f / 15.0f, 0.01f);
  // Of data the plain mean.
  EXPECT_NEAR(make_mip_map(board, false).smaller[1].pixels[0], 136, 1);
  // What is transparent gives no colour: here green behind alpha 0.
  const Image8 leaf{2, 1, {255, 0, 0, 255, 0, 255, 0, 0}};
  const MipMap leaf_map = make_mip_map(leaf, true);
  EXPECT_EQ(leaf_map.smaller[0].pixels, (std::vector<uint8_t>{255, 0, 0, 128}));
}

TEST(MipMap, IsAveragedOverWhatTheRayCovers) {
  // Columns of black and white, 64 x 64.
  Image8 stripes{64, 64, {}};
  for (int i = 0; i < 64 * 64; ++i) {
    const uint8_t v = i % 2 == 0 ? 255 : 0;
    stripes.pixels.insert(stripes.pixels.end(), {v, v, v, 255});
  }
  const MipMap map = make_mip_map(stripes, false);
  const TextureRef texture = nearest();
  const auto read = [&](vec2 uv, vec2 major, vec2 minor) {
    return sample_linear(map, texture, {uv, major, minor}).x;
  };
  const float texel = 1.0f / 64.0f;
  // Less than a texel: the texel itself.
  EXPECT_EQ(read({0.5f * texel, 0.5f}, {0.2f * texel, 0}, {0, 0.2f * texel}), 1.0f);
  EXPECT_EQ(read({1.5f * texel, 0.5f}, {0.2f * texel, 0}, {0, 0.2f * texel}), 0.0f);
  // Many texels: grey.
  EXPECT_NEAR(read({0.3f, 0.4f}, {8 * texel, 0}, {0, 8 * texel}), 0.5f, 0.01f);
  // Long and thin along the stripes: they stay; the texture is read several times.
  EXPECT_GT(read({0.5f * texel, 0.5f}, {0, 4 * texel}, {0.5f * texel, 0}), 0.99f);
  EXPECT_LT(read({1.5f * texel, 0.5f}, {0, 4 * texel}, {0.5f * texel, 0}), 0.01f);
  // Across them they do not.
  EXPECT_NEAR(read({0.5f * texel, 0.5f}, {8 * texel, 0}, {0, 0.5f * texel}), 0.5f, 0.05f);
  // Nonsense reads the image.
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(read({0.5f * texel, 0.5f}, {nan, 0}, {0, nan}), 1.0f);
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
