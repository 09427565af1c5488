// PNG and JPEG images.
#include "fuzz.h"
#include "sinew/io/image_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr uint64_t kMostPixels = 1 << 20;  // larger ones only take time
  const auto claimed = sinew::image_size({data, size}, "image");
  sinew::fuzz::check_error(claimed);
  if (claimed && uint64_t{claimed->width} * claimed->height > kMostPixels) return 0;
  const auto image = sinew::decode_image({data, size}, "image");
  sinew::fuzz::check_error(image);
  if (!image) return 0;
  sinew::fuzz::require(
      claimed && image->width == claimed->width && image->height == claimed->height,
      "an image of another size than its header says");
  sinew::fuzz::require(image->pixels.size() == size_t{4} * image->width * image->height,
                       "an image without some of its pixels");
  return 0;
}
