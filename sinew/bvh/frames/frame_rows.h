// FrameRows: the boxes of primitives in all frames, as kernels read them: rows of one float a
// frame, relative to the root's box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/base/buffer.h"
#include "sinew/bvh/frames/frames.h"

namespace sinew {

// Rows of a box: -low x, -low y, -low z, high x, high y, high z, so that a union is a maximum
// throughout and an extent is a sum.
inline constexpr uint32_t kBoxRows = 6;

// Floats a row for so many frames.
inline uint32_t row_padding(uint32_t frames) {
  return frames <= 4 ? 4 : (frames + 7) / 8 * 8;
}

// How the coordinates of each frame become relative: after it the root's half area is 1, or it has
// none. So no sum of areas overflows, and a cost is a weighted sum of areas.
class RelativeFrames {
 public:
  explicit RelativeFrames(const FrameBoxes& frames);

  // Rows of the primitive, kBoxRows * row_padding(frames) floats; 0 where there are no frames.
  void write_rows(uint32_t primitive, float* out) const;

 private:
  struct Place {
    std::array<double, 3> center = {};
    double scale = 0.0;
  };
  const FrameBoxes& frames_;
  std::vector<Place> places_;
};

}  // namespace sinew
