// JPEG decoding for image_file.cpp; the one door to libjpeg.
#pragma once

#include <span>
#include <string>

#include "sinew/base/error.h"
#include "sinew/io/image_file.h"

namespace sinew {

inline bool is_jpeg(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}
Result<ImageSize> jpeg_size(std::span<const uint8_t> bytes, const std::string& name);
Result<Image8> decode_jpeg(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace sinew
