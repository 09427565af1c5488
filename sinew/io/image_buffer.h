// Room for the pixels that an image file claims to have.
#pragma once

#include <new>
#include <string>

#include "sinew/base/error.h"
#include "sinew/io/image_file.h"

namespace sinew {

// A transparent black image. `name` stands in the error message if there is no memory for it.
inline Result<Image8> make_image(const ImageSize& size, const std::string& name) {
  Image8 image{size.width, size.height, {}};
  try {
    image.pixels.resize(size_t{4} * size.width * size.height);
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::bad_input, name, "", "is too large for this machine's memory", ""});
  }
  return image;
}

}  // namespace sinew
