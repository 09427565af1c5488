#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/render/frame.h"
#include "sinew/render/tonemap_kernels.h"

namespace sinew {

void tonemap(const Image& image, float exposure, Image8& out) {
  const float gain = std::exp2(exposure);
  out.width = image.width;
  out.height = image.height;
  out.pixels.resize(4 * image.pixels.size());
  parallel_for(image.pixels.size(), 8192, [&](size_t begin, size_t end) {
    tonemap_pixels(&image.pixels[begin], end - begin, gain, &out.pixels[4 * begin]);
  });
}

}  // namespace sinew
