// The display transform: exposure, a shoulder that compresses the brightest channel and carries the
// others along (hue stays), then lets very bright colours fade to white; sRGB with exact rounding.
// Based on: Khronos PBR Neutral tone mapper (2024) for the shoulder and the fade; without its
// subtraction of the Fresnel reflex, so blacks and mid tones are untouched.
#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/srgb.h"
#include "sinew/render/frame.h"

namespace sinew {
namespace {

constexpr float kShoulder = 0.6f;       // linear value at which compression begins
constexpr float kDesaturation = 0.15f;  // how fast colours beyond the shoulder fade to white

vec3 compress(vec3 color) {
  const float peak = std::max({color.x, color.y, color.z});
  if (!(peak > kShoulder)) return color;
  constexpr float kRoom = 1.0f - kShoulder;
  const float new_peak = 1.0f - kRoom * kRoom / (peak + kRoom - kShoulder);
  const float keep = 1.0f / (kDesaturation * (peak - new_peak) + 1.0f);
  return mix(vec3(new_peak), color * (new_peak / peak), keep);
}

float tame(float x) {
  return std::isnan(x) ? 0.0f : std::clamp(x, 0.0f, 1e30f);
}

}  // namespace

void tonemap(const Image& image, float exposure, Image8& out) {
  const float gain = std::exp2(exposure);
  out.width = image.width;
  out.height = image.height;
  out.pixels.resize(4 * image.pixels.size());
  parallel_for(image.pixels.size(), 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const vec4& pixel = image.pixels[i];
      const float alpha = std::clamp(tame(pixel.w), 0.0f, 1.0f);
      const float scale = alpha > 0.0f ? gain / alpha : gain;
      const vec3 color =
          compress(vec3(tame(pixel.x * scale), tame(pixel.y * scale), tame(pixel.z * scale)));
      uint8_t* p = &out.pixels[4 * i];
      p[0] = linear_to_srgb_code(color.x);
      p[1] = linear_to_srgb_code(color.y);
      p[2] = linear_to_srgb_code(color.z);
      p[3] = static_cast<uint8_t>(alpha * 255.0f + 0.5f);
    }
  });
}

}  // namespace sinew
