#include "app/contact_sheet.h"
#include "sinew/math/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew::app {
namespace {

constexpr uint32_t kMaxCell = 320;  // pixels, the larger side
constexpr uint32_t kGap = 6;        // pixels
constexpr std::array<uint8_t, 4> kPaper = {28, 28, 32, 255};

// The mean of a square of pixels, over the paper.
void shrink_pixel(const Image8& frame, uint32_t x0, uint32_t y0, uint32_t side, uint8_t* out) {
  const std::array<float, 256>& linear = srgb_codes_to_linear();
  std::array<float, 3> sum{};
  for (uint32_t y = y0; y < y0 + side; ++y) {
    for (uint32_t x = x0; x < x0 + side; ++x) {
      const uint8_t* pixel = frame.at(x, y);
      const float alpha = static_cast<float>(pixel[3]) / 255.0f;
      for (size_t c = 0; c < 3; ++c) {
        sum[c] += alpha * linear[pixel[c]] + (1.0f - alpha) * linear[kPaper[c]];
      }
    }
  }
  for (size_t c = 0; c < 3; ++c)
    out[c] = linear_to_srgb_code(sum[c] / static_cast<float>(side * side));
  out[3] = 255;
}

}  // namespace

ContactSheet::ContactSheet(ImageSize frame_size, size_t frames) : frames_(frames) {
  pictures_ = std::clamp<size_t>(frames, 1, kMaxPictures);
  const uint32_t larger = std::max(frame_size.width, frame_size.height);
  shrink_ =
      std::min((larger + kMaxCell - 1) / kMaxCell, std::min(frame_size.width, frame_size.height));
  cell_ = {frame_size.width / shrink_, frame_size.height / shrink_};
  columns_ = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(pictures_))));
  const auto rows = static_cast<uint32_t>((pictures_ + columns_ - 1) / columns_);
  sheet_.width = columns_ * (cell_.width + kGap) + kGap;
  sheet_.height = rows * (cell_.height + kGap) + kGap;
  sheet_.pixels.resize(4 * size_t{sheet_.width} * sheet_.height);
  for (size_t i = 0; i < sheet_.pixels.size(); ++i) sheet_.pixels[i] = kPaper[i % 4];
}

void ContactSheet::add(size_t index, const Image8& frame) {
  // Picture k shows frame k * frames / pictures.
  if (added_ == pictures_ || index != added_ * frames_ / pictures_) return;
  const auto column = static_cast<uint32_t>(added_ % columns_);
  const auto row = static_cast<uint32_t>(added_ / columns_);
  const uint32_t left = kGap + column * (cell_.width + kGap);
  const uint32_t top = kGap + row * (cell_.height + kGap);
  for (uint32_t y = 0; y < cell_.height; ++y) {
    for (uint32_t x = 0; x < cell_.width; ++x) {
      shrink_pixel(frame, x * shrink_, y * shrink_, shrink_, sheet_.at(left + x, top + y));
    }
  }
  ++added_;
}

}  // namespace sinew::app
