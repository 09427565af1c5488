// Colour maps made by formula in the perceptual space Oklab: lightness rises linearly, hue turns at
// a constant rate, and chroma is as large as a smooth limit and the display allow.
// Based on: B. Ottosson, "A perceptual color space for image processing", 2020.
#include "sinew/render/color_map.h"

#include <algorithm>
#include <cmath>

#include "sinew/math/srgb.h"
#include "sinew/math/vec.h"

namespace sinew {
namespace {

constexpr float kDegree = 0.0174532925f;

// Linear sRGB of a colour given by lightness 0..1, chroma and hue in degrees.
vec3 oklch(float lightness, float chroma, float hue) {
  const float a = chroma * std::cos(hue * kDegree), b = chroma * std::sin(hue * kDegree);
  const float l = lightness + 0.3963377774f * a + 0.2158037573f * b;
  const float m = lightness - 0.1055613458f * a - 0.0638541728f * b;
  const float s = lightness - 0.0894841775f * a - 1.2914855480f * b;
  const vec3 lms(l * l * l, m * m * m, s * s * s);
  return vec3(4.0767416621f * lms.x - 3.3077115913f * lms.y + 0.2309699292f * lms.z,
              -1.2684380046f * lms.x + 2.6097574011f * lms.y - 0.3413193965f * lms.z,
              -0.0041960863f * lms.x - 0.7034186147f * lms.y + 1.7076147010f * lms.z);
}

// The same with the chroma reduced until the display can show it, as 8-bit sRGB.
Color8 displayed(float lightness, float chroma, float hue) {
  const auto shown = [](vec3 c) {
    return std::min({c.x, c.y, c.z}) >= 0.0f && std::max({c.x, c.y, c.z}) <= 1.0f;
  };
  float low = 0.0f, high = chroma;
  if (shown(oklch(lightness, chroma, hue))) low = chroma;
  for (int i = 0; i < 20 && low < chroma; ++i) {
    const float middle = 0.5f * (low + high);
    (shown(oklch(lightness, middle, hue)) ? low : high) = middle;
  }
  const vec3 linear = clamp(oklch(lightness, low, hue), 0.0f, 1.0f);
  Color8 color;
  for (int i = 0; i < 3; ++i) {
    color[static_cast<size_t>(i)] = linear_to_srgb_code(linear[i]);
  }
  return color;
}

std::array<Color8, 256> make_heat_map() {
  std::array<Color8, 256> map{};
  for (size_t i = 0; i < map.size(); ++i) {
    const float x = static_cast<float>(i) / 255.0f;
    const float chroma = 0.22f * std::sqrt(std::sin(180.0f * kDegree * (0.02f + 0.94f * x)));
    map[i] = displayed(0.97f * x, x == 0.0f ? 0.0f : chroma, 280.0f + 190.0f * x);
  }
  return map;
}

}  // namespace

Color8 heat_color(float value) {
  static const std::array<Color8, 256> map = make_heat_map();
  const float x = value > 0.0f ? std::min(value, 1.0f) : 0.0f;
  return map[static_cast<size_t>(x * 255.0f + 0.5f)];
}

Color8 index_color(uint32_t index) {
  // Multiples of the golden ratio fill the circle evenly, whatever their number.
  constexpr double kGolden = 0.6180339887498949;
  const double turns = static_cast<double>(index) * kGolden;
  const float hue = static_cast<float>(360.0 * (turns - std::floor(turns)));
  return displayed(index % 2 == 0 ? 0.78f : 0.66f, 0.14f, hue);
}

}  // namespace sinew
