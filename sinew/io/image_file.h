// PNG files, and the comparison of images.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/image.h"

namespace sinew {

using ImageMetadata = std::vector<std::pair<std::string, std::string>>;  // keyword, text

// Writes to a temporary file beside `path`, then renames: a reader never sees half a file. "-" is
// standard output.
Result<void> write_png(const std::string& path, const Image8& image,
                       const ImageMetadata& metadata = {});
// The same bytes in memory. `name` stands in error messages.
Result<std::vector<uint8_t>> encode_png(const Image8& image, const std::string& name,
                                        const ImageMetadata& metadata = {});
Result<Image8> read_png(const std::string& path);

// Larger images are refused, and so are files too short to hold the size they claim.
inline constexpr uint32_t kMaxImageSide = 16384;  // pixels

struct ImageSize {
  uint32_t width = 0;
  uint32_t height = 0;
};
// Whether the bytes begin as a PNG or JPEG does.
bool is_image(std::span<const uint8_t> bytes);

// What decode_image would give, from the header alone: ask before spending 4 bytes a pixel.
Result<ImageSize> image_size(std::span<const uint8_t> bytes, const std::string& name);

// PNG or JPEG in memory (textures). `name` stands in error messages.
Result<Image8> decode_image(std::span<const uint8_t> bytes, const std::string& name);

// An Error that says both sizes if they differ.
Result<void> check_same_size(const Image8& a, const Image8& b);

struct ImageDifference {
  double psnr = 0.0;         // dB over RGB; infinite for equal images
  double mean = 0.0;         // mean absolute difference of RGB, 0..1
  double largest = 0.0;      // largest absolute difference of any channel, 0..1
  uint64_t pixels_over = 0;  // pixels in which some channel differs by more than `tolerance`
};
// See check_same_size. FLIP, which says how large a difference looks, is in flip.h.
Result<ImageDifference> compare_images(const Image8& a, const Image8& b, int tolerance = 2);

}  // namespace sinew
