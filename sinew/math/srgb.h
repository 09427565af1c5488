// The sRGB transfer function, IEC 61966-2-1: for values, and by table for 8-bit codes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sinew {

inline float srgb_to_linear(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

namespace srgb_detail {

inline double to_linear(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// Linear to codes, rounded to nearest: a cell of the table is narrower than any code, so at most
// one threshold lies within it.
struct Encoder {
  static constexpr int kCells = 4096;
  std::array<int32_t, kCells + 1> low{};  // code at the cell's lower end
  std::array<float, 257> threshold{};     // least linear value of each code

  Encoder() {
    for (size_t code = 1; code <= 255; ++code) {
      threshold[code] = static_cast<float>(to_linear((static_cast<double>(code) - 0.5) / 255.0));
    }
    threshold[256] = 2.0f;
    size_t code = 0;
    for (size_t i = 0; i <= kCells; ++i) {
      while (threshold[code + 1] <= static_cast<float>(i) / kCells) ++code;
      low[i] = static_cast<int32_t>(code);
    }
  }
};

inline const Encoder& encoder() {
  static const Encoder encoder;
  return encoder;
}

inline std::array<float, 256> decoder() {
  std::array<float, 256> table{};
  for (size_t i = 0; i < 256; ++i) {
    table[i] = static_cast<float>(to_linear(static_cast<double>(i) / 255.0));
  }
  return table;
}

}  // namespace srgb_detail

// The linear value of each 8-bit code.
inline const std::array<float, 256>& srgb_codes_to_linear() {
  static const std::array<float, 256> table = srgb_detail::decoder();
  return table;
}

// The nearest 8-bit code of a linear value, which is clamped to 0..1.
inline uint8_t linear_to_srgb_code(float linear) {
  const srgb_detail::Encoder& encoder = srgb_detail::encoder();
  const float x = std::clamp(linear, 0.0f, 1.0f);
  const int32_t code = encoder.low[static_cast<size_t>(x * encoder.kCells)];
  return static_cast<uint8_t>(code +
                              (x >= encoder.threshold[static_cast<size_t>(code) + 1] ? 1 : 0));
}

}  // namespace sinew
