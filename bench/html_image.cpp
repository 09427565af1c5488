#include "bench/html_image.h"

#include <fmt/format.h>

#include <vector>

#include "bench/svg_plot.h"
#include "sinew/io/image_file.h"

namespace sinew::bench {

std::string base64(std::span<const uint8_t> bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) {
      out += k <= left ? kDigits[group >> (18 - 6 * k) & 63u] : '=';
    }
  }
  return out;
}

Result<std::string> html_image(const Image8& image, const std::string& words) {
  SINEW_TRY(const std::vector<uint8_t> png, encode_png(image, "picture"));
  return fmt::format(
      "<figure style=\"display:inline-block;margin:.5rem\"><img width=\"{}\" alt=\"\" "
      "src=\"data:image/png;base64,{}\"><figcaption class=\"note\">{}</figcaption></figure>\n",
      image.width / 2, base64(png), escape_markup(words));
}

}  // namespace sinew::bench
