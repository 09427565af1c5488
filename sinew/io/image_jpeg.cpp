// JPEG (baseline and progressive) by stb_image, behind guards that it lacks: the file must be able
// to hold the size it claims, and may not make the decoder pass over the image again and again.
#include "sinew/io/image_jpeg.h"

#include <algorithm>
#include <climits>
#include <new>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 16384
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace sinew {
namespace {

static_assert(STBI_MAX_DIMENSIONS == kMaxImageSide);

tl::unexpected<Error> jpeg_error(const std::string& name, std::string problem) {
  return fail({ErrorKind::bad_input, name, "", std::move(problem), "save the image again"});
}

// A block of 8 x 8 pixels takes at least one bit, of its DC coefficient.
constexpr uint64_t kMostPixelsPerByte = 8 * 64;
// Progressive files have about ten; each costs a pass over the image however short it is.
constexpr int kMostScans = 200;

int count_scans(std::span<const uint8_t> bytes) {
  int scans = 0;
  for (size_t i = 0; i + 1 < bytes.size(); ++i) scans += bytes[i] == 0xff && bytes[i + 1] == 0xda;
  return scans;
}

}  // namespace

Result<ImageSize> jpeg_size(std::span<const uint8_t> bytes, const std::string& name) {
  if (bytes.size() > INT_MAX) return jpeg_error(name, "is larger than 2 GiB");
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytes.data(), static_cast<int>(bytes.size()), &width, &height,
                             &channels)) {
    return jpeg_error(name, std::string("is a damaged JPEG: ") + stbi_failure_reason());
  }
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) >
      bytes.size() * kMostPixelsPerByte) {
    return jpeg_error(name, "is a damaged JPEG: it is too short for " + std::to_string(width) +
                                " x " + std::to_string(height) + " pixels");
  }
  return ImageSize{static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

Result<Image8> decode_jpeg(std::span<const uint8_t> bytes, const std::string& name) {
  SINEW_TRY(const ImageSize size, jpeg_size(bytes, name));
  if (count_scans(bytes) > kMostScans) return jpeg_error(name, "is a JPEG of absurdly many scans");
  int width = 0, height = 0, channels = 0;
  stbi_uc* decoded = stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &width,
                                           &height, &channels, 4);
  if (!decoded) {
    return jpeg_error(name, std::string("is a damaged JPEG: ") + stbi_failure_reason());
  }
  Image8 image{size.width, size.height, {}};
  const size_t count = size_t{4} * size.width * size.height;
  try {
    image.pixels.assign(decoded, decoded + count);
  } catch (const std::bad_alloc&) {
    stbi_image_free(decoded);
    return jpeg_error(name, "is too large for this machine's memory");
  }
  stbi_image_free(decoded);
  return image;
}

}  // namespace sinew
