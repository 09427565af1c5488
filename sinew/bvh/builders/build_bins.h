// The bins of binned SAH, and the best plane between them. Based on: I. Wald, "On fast Construction
// of SAH-based Bounding Volume Hierarchies", 2007.
#pragma once

#include <array>

#include "sinew/bvh/builders/build_common.h"

namespace sinew::build_detail {

inline constexpr uint32_t kMaxBins = 32;

// Where centroids lie, and how they map to bins.
struct Binning {
  Rows centers;  // of centroids, times two
  float scale[3] = {0, 0, 0};
  uint32_t bins = 0;

  void prepare(uint32_t bin_count) {
    bins = bin_count;
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centers.high[axis] - centers.low[axis];
      scale[axis] = extent > 0 ? static_cast<float>(bins) * 0.99999f / extent : 0.0f;
      if (!(scale[axis] < std::numeric_limits<float>::max())) scale[axis] = 0.0f;
    }
  }
  uint32_t bin(const PrimitiveRef& ref, int axis) const {
    if (scale[axis] == 0.0f) return 0;
    const float place = (ref.center2(axis) - centers.low[axis]) * scale[axis];
    return std::min(static_cast<uint32_t>(place), bins - 1);
  }
};

struct Bins {
  std::array<std::array<Rows, kMaxBins>, 3> box;
  std::array<std::array<uint32_t, kMaxBins>, 3> count = {};

  void add(const PrimitiveRef& ref, const Binning& binning, uint32_t primitives = 1) {
    for (int axis = 0; axis < 3; ++axis) {
      const uint32_t b = binning.bin(ref, axis);
      box[axis][b].extend(ref.box);
      count[axis][b] += primitives;
    }
  }
  void add(const Bins& other, uint32_t bins) {
    for (int axis = 0; axis < 3; ++axis) {
      for (uint32_t b = 0; b < bins; ++b) {
        box[axis][b].extend(other.box[axis][b]);
        count[axis][b] += other.count[axis][b];
      }
    }
  }
};

struct Split {
  int axis = -1;                                        // -1: no plane separates the centroids
  uint32_t bin = 0;                                     // bins below it go left
  float cost = std::numeric_limits<float>::infinity();  // sum of area * leaf cost
};

inline Split best_split(const Bins& bins, const Binning& binning, const BuildConfig& config) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (binning.scale[axis] == 0.0f) continue;
    std::array<float, kMaxBins> right_cost = {};
    Rows box;
    uint32_t count = 0;
    for (uint32_t b = binning.bins - 1; b > 0; --b) {
      box.extend(bins.box[axis][b]);
      count += bins.count[axis][b];
      right_cost[b] = count == 0 ? Rows::kInfinity : box.half_area() * leaf_cost(config, count);
    }
    box = Rows();
    count = 0;
    for (uint32_t b = 1; b < binning.bins; ++b) {
      box.extend(bins.box[axis][b - 1]);
      count += bins.count[axis][b - 1];
      if (count == 0) continue;
      const float cost = box.half_area() * leaf_cost(config, count) + right_cost[b];
      if (cost < best.cost) best = {axis, b, cost};
    }
  }
  return best;
}

// Puts what lies left of the plane first; returns where the right part begins.
inline size_t partition_at(std::vector<PrimitiveRef>& refs, size_t begin, size_t end,
                           const Binning& binning, const Split& split) {
  const auto middle = std::partition(
      refs.begin() + begin, refs.begin() + end,
      [&](const PrimitiveRef& ref) { return binning.bin(ref, split.axis) < split.bin; });
  return static_cast<size_t>(middle - refs.begin());
}

}  // namespace sinew::build_detail
