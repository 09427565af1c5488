// The sRGB curve (IEC 61966-2-1:1999) between stored values and linear light, both from 0 to 1.
#pragma once

#include <cmath>

namespace sinew {

inline float linear_from_srgb(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

inline float srgb_from_linear(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

}  // namespace sinew
