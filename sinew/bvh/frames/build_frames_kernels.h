// The kernels behind build_over_frames(): bins of primitives with their boxes in all frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/bvh/frames/frame_rows.h"

namespace sinew {

inline constexpr uint32_t kMaxFrameBins = 16;

// A way to sort primitives into bins: by their centres on one axis in one frame.
struct BinAxis {
  uint32_t row = 0;    // axis * padding + frame
  float low = 0.0f;    // the least centre, times two
  float scale = 0.0f;  // bins per unit

  uint32_t bin(const float* rows, uint32_t padding, uint32_t bins) const {
    const float center = rows[3 * padding + row] - rows[row];
    const auto b = static_cast<uint32_t>((center - low) * scale);
    return b < bins ? b : bins - 1;
  }
};

// Primitives' rows, weights of areas, and which primitives.
struct BinJob {
  const float* rows = nullptr;  // [primitive][row][padding]
  const float* g = nullptr;     // [padding]
  uint32_t padding = 0;
  std::span<const uint32_t> primitives;

  const float* box(uint32_t primitive) const {
    return rows + size_t{primitive} * kBoxRows * padding;
  }
  // Floats that the boxes and counts of so many bins take: [axis][bin][row][padding], and after
  // them uint32_t [axis][bin].
  size_t bin_floats(size_t axes, uint32_t bins) const {
    return axes * bins * (size_t{kBoxRows} * padding + 1);
  }
};

// Least and greatest centres (times two) of the primitives: extends -low [3][padding] and high
// [3][padding].
void measure_centers(const BinJob& job, float* range);

// Clears the bins and adds the primitives to them.
void fill_bins(const BinJob& job, std::span<const BinAxis> axes, uint32_t bins, float* out);

// Adds other bins.
void merge_bins(const BinJob& job, size_t axes, uint32_t bins, const float* other, float* out);

struct FrameSplit {
  uint32_t axis = 0xffffffffu;  // into axes; none: no plane separates the centres
  uint32_t bin = 0;             // bins below it go left
};

// The plane that minimises the sum over both sides of weighted area times number of primitives.
// swept: memory for one box.
FrameSplit best_frame_split(const BinJob& job, size_t axes, uint32_t bins, float* filled,
                            float* swept);

}  // namespace sinew
