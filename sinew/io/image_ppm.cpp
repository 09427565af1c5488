#include "sinew/io/image_ppm.h"

#include <algorithm>
#include <utility>

#include "sinew/io/image_buffer.h"

namespace sinew {
namespace {

struct Header {
  ImageSize size;
  uint32_t largest = 255;  // the value of full brightness
  size_t bytes = 0;        // where the pixels begin
};

tl::unexpected<Error> damaged(const std::string& name, std::string problem) {
  return fail({ErrorKind::bad_input, name, "", "is a damaged PPM: " + std::move(problem),
               "save the image again"});
}

bool is_blank(uint8_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// A number of the header, after blanks and comments; saturates.
bool take_number(std::span<const uint8_t> bytes, size_t& at, uint32_t& out) {
  while (at < bytes.size() && (is_blank(bytes[at]) || bytes[at] == '#')) {
    const bool comment = bytes[at] == '#';
    while (comment && at < bytes.size() && bytes[at] != '\n') ++at;
    if (!comment) ++at;
  }
  const size_t begin = at;
  for (out = 0; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9'; ++at) {
    out = std::min(out * 10 + (bytes[at] - '0'), uint32_t{1} << 24);
  }
  return at > begin;
}

Result<Header> read_header(std::span<const uint8_t> bytes, const std::string& name) {
  Header header;
  size_t at = 2;
  const bool complete = is_ppm(bytes) && take_number(bytes, at, header.size.width) &&
                        take_number(bytes, at, header.size.height) &&
                        take_number(bytes, at, header.largest) && at < bytes.size() &&
                        is_blank(bytes[at]);
  if (!complete) return damaged(name, "its header is not complete");
  header.bytes = at + 1;
  const auto [width, height] = header.size;
  if (width == 0 || height == 0 || width > kMaxImageSide || height > kMaxImageSide) {
    return damaged(
        name, "it claims " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
  }
  if (header.largest == 0 || header.largest > 65535) {
    return damaged(name, "its largest value is " + std::to_string(header.largest));
  }
  const uint64_t needed = uint64_t{3} * width * height * (header.largest > 255 ? 2 : 1);
  if (bytes.size() - header.bytes < needed) {
    return damaged(name, "it is too short for " + std::to_string(width) + " x " +
                             std::to_string(height) + " pixels");
  }
  return header;
}

}  // namespace

Result<ImageSize> ppm_size(std::span<const uint8_t> bytes, const std::string& name) {
  SINEW_TRY(const Header header, read_header(bytes, name));
  return header.size;
}

Result<Image8> decode_ppm(std::span<const uint8_t> bytes, const std::string& name) {
  SINEW_TRY(const Header header, read_header(bytes, name));
  SINEW_TRY(Image8 image, make_image(header.size, name));
  const bool wide = header.largest > 255;
  const uint8_t* in = bytes.data() + header.bytes;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    if (i % 4 == 3) {
      image.pixels[i] = 255;
      continue;
    }
    const uint32_t value = wide ? uint32_t{in[0]} << 8 | in[1] : in[0];
    in += wide ? 2 : 1;
    const uint32_t scaled = (value * 255 + header.largest / 2) / header.largest;
    image.pixels[i] = static_cast<uint8_t>(std::min(scaled, 255u));
  }
  return image;
}

}  // namespace sinew
