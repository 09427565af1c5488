// Images in memory. Rows go from top to bottom, pixels from left to right.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

// 8 bits a channel, RGBA, not premultiplied. Colours are sRGB unless the user says otherwise
// (normal and metallic-roughness textures are linear).
struct Image8 {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<uint8_t> pixels;  // 4 * width * height

  const uint8_t* at(uint32_t x, uint32_t y) const { return &pixels[4 * (size_t{y} * width + x)]; }
  uint8_t* at(uint32_t x, uint32_t y) { return &pixels[4 * (size_t{y} * width + x)]; }
};

// Linear radiance and coverage; what rendering accumulates before tone mapping.
struct Image {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<vec4> pixels;  // width * height; premultiplied by alpha
};

}  // namespace sinew
