// The display transform of many pixels. Internal to tonemap.cpp.
// Based on: Khronos PBR Neutral tone mapper (2024) for the shoulder and the fade; without its
// subtraction of the Fresnel reflex, so blacks and mid tones are untouched.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sinew/math/srgb.h"
#include "sinew/math/vec.h"

namespace sinew {

inline constexpr float kShoulder = 0.6f;       // linear value at which compression begins
inline constexpr float kDesaturation = 0.15f;  // how fast colours beyond it fade to white
inline constexpr float kLargestRadiance = 1e30f;

// in: premultiplied linear radiance; out: 4 bytes a pixel, not premultiplied. Negative values and
// NaN count as 0.
void tonemap_pixels(const vec4* in, size_t pixels, float gain, uint8_t* out);

}  // namespace sinew
