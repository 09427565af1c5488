// Binary PPM images (netpbm's P6), the textures of AFF scenes.
// Based on: J. Poskanzer, "PPM Format Specification", netpbm.
#pragma once

#include <span>
#include <string>

#include "sinew/base/error.h"
#include "sinew/io/image_file.h"

namespace sinew {

inline bool is_ppm(std::span<const uint8_t> bytes) {
  return bytes.size() >= 2 && bytes[0] == 'P' && bytes[1] == '6';
}
// 8 or 16 bits a channel. `name` stands in error messages.
Result<ImageSize> ppm_size(std::span<const uint8_t> bytes, const std::string& name);
Result<Image8> decode_ppm(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace sinew
