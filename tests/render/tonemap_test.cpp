#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "sinew/math/srgb.h"
#include "sinew/render/frame.h"

namespace sinew {
namespace {

Image8 show(const std::vector<vec4>& pixels, float exposure = 0.0f) {
  Image8 out;
  tonemap({static_cast<uint32_t>(pixels.size()), 1, pixels}, exposure, out);
  return out;
}

// One pixel, plainly.
struct PlainPixel {
  uint8_t code[4];
};

PlainPixel show_plainly(const vec4& pixel, float exposure) {
  const auto tame = [](float x) { return std::isnan(x) ? 0.0f : std::clamp(x, 0.0f, 1e30f); };
  const float alpha = std::clamp(tame(pixel.w), 0.0f, 1.0f);
  const float scale = std::exp2(exposure) / (alpha > 0.0f ? alpha : 1.0f);
  vec3 color(tame(pixel.x * scale), tame(pixel.y * scale), tame(pixel.z * scale));
  const float peak = std::max({color.x, color.y, color.z});
  if (peak > 0.6f) {
    const float new_peak = 1.0f - 0.4f * 0.4f / (peak + 0.4f - 0.6f);
    const float keep = 1.0f / (0.15f * (peak - new_peak) + 1.0f);
    color = mix(vec3(new_peak), color * (new_peak / peak), keep);
  }
  PlainPixel out{};
  for (int c = 0; c < 3; ++c) out.code[c] = linear_to_srgb_code(color[c]);
  out.code[3] = static_cast<uint8_t>(alpha * 255.0f + 0.5f);
  return out;
}

TEST(Tonemap, IsAsPixelByPixel) {
  constexpr uint32_t kSeed = 20261123;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> stops(-14.0f, 8.0f), alpha(-0.2f, 1.2f);
  for (const size_t count : {1, 2, 3, 5, 7, 15, 17, 31, 33, 20011}) {
    std::vector<vec4> pixels(count);
    for (vec4& p : pixels) {
      for (int c = 0; c < 3; ++c) p[c] = std::exp2(stops(random));
      p.w = alpha(random);
    }
    const Image8 out = show(pixels, 0.5f);
    size_t off = 0;
    for (size_t i = 0; i < count; ++i) {
      const PlainPixel plain = show_plainly(pixels[i], 0.5f);
      for (size_t c = 0; c < 4; ++c) {
        const int step = std::abs(out.pixels[4 * i + c] - plain.code[c]);
        EXPECT_LE(step, 1) << "pixel " << i << " of " << count;
        if (step != 0) ++off;
      }
    }
    EXPECT_LE(off, count / 1000);
  }
}

TEST(Tonemap, EveryCodeSurvivesBelowTheShoulder) {
  for (int code = 0; code < 203; ++code) {  // 0.591 linear
    const float x = srgb_codes_to_linear()[static_cast<size_t>(code)];
    EXPECT_EQ(show({vec4(x, x, x, 1.0f)}).pixels[0], code);
  }
}

TEST(Tonemap, RoundsToTheNearestCode) {
  const auto decode = [](double s) {
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  };
  for (int code = 0; code < 203; ++code) {
    const auto below = static_cast<float>(decode((code + 0.499) / 255.0));
    const auto above = static_cast<float>(decode((code + 0.501) / 255.0));
    EXPECT_EQ(show({vec4(below, 0.0f, 0.0f, 1.0f)}).pixels[0], code);
    EXPECT_EQ(show({vec4(above, 0.0f, 0.0f, 1.0f)}).pixels[0], code + 1);
  }
}

TEST(Tonemap, IsMonotoneAndEndsAtWhite) {
  const vec3 tint(1.0f, 0.6f, 0.3f);
  int last[3] = {0, 0, 0};
  for (float x = 0.001f; x < 1e4f; x *= 1.02f) {
    const Image8 out = show({vec4(tint * x, 1.0f)});
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(out.pixels[c], last[c]) << "at " << x;
      last[c] = out.pixels[c];
    }
    EXPECT_GE(out.pixels[0], out.pixels[1]);  // the order of channels, and so the hue, stays
    EXPECT_GE(out.pixels[1], out.pixels[2]);
  }
  for (int c = 0; c < 3; ++c) EXPECT_GE(last[c], 250);
}

TEST(Tonemap, ExposureCountsInStops) {
  EXPECT_EQ(show({vec4(0.1f, 0.05f, 0.02f, 1.0f)}, 2.0f).pixels,
            show({vec4(0.4f, 0.2f, 0.08f, 1.0f)}).pixels);
}

TEST(Tonemap, TransparentPixelsAreNotPremultiplied) {
  const Image8 out = show({vec4(0.1f, 0.2f, 0.3f, 0.5f), vec4(0.0f)});
  const Image8 solid = show({vec4(0.2f, 0.4f, 0.6f, 1.0f)});
  for (int c = 0; c < 3; ++c) EXPECT_EQ(out.pixels[c], solid.pixels[c]);
  EXPECT_EQ(out.pixels[3], 128);
  EXPECT_EQ(out.pixels[7], 0);
}

TEST(Tonemap, BadNumbersDoNoHarm) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  const Image8 out = show({vec4(nan, nan, nan, 1.0f), vec4(inf, inf, inf, 1.0f),
                           vec4(-1.0f, -inf, 0.0f, 1.0f), vec4(1e38f, 0.0f, 0.0f, nan)});
  EXPECT_EQ(out.pixels[0], 0);
  EXPECT_EQ(out.pixels[4], 255);
  EXPECT_EQ(out.pixels[8], 0);
  EXPECT_EQ(out.pixels[15], 0);
}

}  // namespace
}  // namespace sinew
