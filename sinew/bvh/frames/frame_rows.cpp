#include "sinew/bvh/frames/frame_rows.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"

namespace sinew {
namespace {

// A root with a longer side than this, relative to the root of its area, is a line: its coordinates
// would leave what floats can tell apart.
constexpr double kLongestSide = 1e15;

}  // namespace

RelativeFrames::RelativeFrames(const FrameBoxes& frames)
    : frames_(frames), places_(frames.frame_count()) {
  parallel_for(places_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      Box root;
      for (const Box& box : frames.frames[f]) root.extend(box);
      const double side = std::sqrt(exact_half_area(root));
      const vec3 extent = 0.5f * root.max - 0.5f * root.min;
      const double longest = 2.0 * double(std::max({extent.x, extent.y, extent.z}));
      if (side > 0.0 && longest < kLongestSide * side) places_[f].scale = 1.0 / side;
      for (int axis = 0; axis < 3; ++axis) {
        places_[f].center[axis] = 0.5 * (double(root.min[axis]) + double(root.max[axis]));
      }
    }
  });
}

void RelativeFrames::write_rows(uint32_t primitive, float* out) const {
  const uint32_t padding = row_padding(frames_.frame_count());
  std::fill_n(out, kBoxRows * padding, 0.0f);
  for (uint32_t f = 0; f < places_.size(); ++f) {
    const Box& box = frames_.frames[f][primitive];
    const Place& place = places_[f];
    for (int axis = 0; axis < 3; ++axis) {
      const double low = (double(box.min[axis]) - place.center[axis]) * place.scale;
      const double high = (double(box.max[axis]) - place.center[axis]) * place.scale;
      out[axis * padding + f] = static_cast<float>(-low);
      out[(3 + axis) * padding + f] = static_cast<float>(high);
    }
  }
}

}  // namespace sinew
