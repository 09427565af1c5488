#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sinew/math/srgb.h"
#include "sinew/render/frame.h"

namespace sinew {
namespace {

Image8 show(const std::vector<vec4>& pixels, float exposure = 0.0f) {
  Image8 out;
  tonemap({static_cast<uint32_t>(pixels.size()), 1, pixels}, exposure, out);
  return out;
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
