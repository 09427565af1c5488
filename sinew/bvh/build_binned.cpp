// Binned SAH, top down. Based on: I. Wald, "On fast Construction of SAH-based Bounding Volume
// Hierarchies", 2007. Differs: all three axes are binned, leaf costs count blocks of primitives,
// and the primitives' boxes move with their indices.
#include <array>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/build_common.h"

namespace sinew {
namespace {

using build_detail::PrimitiveRef;
using build_detail::Rows;

constexpr uint32_t kMaxBins = 32;

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

  void add(const PrimitiveRef& ref, const Binning& binning) {
    for (int axis = 0; axis < 3; ++axis) {
      const uint32_t b = binning.bin(ref, axis);
      box[axis][b].extend(ref.box);
      ++count[axis][b];
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

Split best_split(const Bins& bins, const Binning& binning, const BuildConfig& config) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    if (binning.scale[axis] == 0.0f) continue;
    std::array<float, kMaxBins> right_cost = {};
    Rows box;
    uint32_t count = 0;
    for (uint32_t b = binning.bins - 1; b > 0; --b) {
      box.extend(bins.box[axis][b]);
      count += bins.count[axis][b];
      right_cost[b] =
          count == 0 ? Rows::kInfinity : box.half_area() * build_detail::leaf_cost(config, count);
    }
    box = Rows();
    count = 0;
    for (uint32_t b = 1; b < binning.bins; ++b) {
      box.extend(bins.box[axis][b - 1]);
      count += bins.count[axis][b - 1];
      if (count == 0) continue;
      const float cost = box.half_area() * build_detail::leaf_cost(config, count) + right_cost[b];
      if (cost < best.cost) best = {axis, b, cost};
    }
  }
  return best;
}

class BinnedBuilder {
 public:
  BinnedBuilder(std::span<const Box> boxes, const BuildConfig& config)
      : config_(config), refs_(build_detail::make_refs(boxes)) {
    if (!refs_.empty()) slots_.resize(2 * refs_.size() - 1);
  }

  Tree run() {
    if (refs_.empty()) return {};
    build(0, 0, refs_.size(), 0);
    return build_detail::compact(slots_, refs_);
  }

 private:
  static constexpr size_t kChunk = 16384;  // primitives binned by one task

  void build(uint32_t slot, size_t begin, size_t end, int depth) {
    const size_t count = end - begin;
    const size_t middle = count == 1 ? begin : split(begin, end, depth);
    if (middle == begin) {
      slots_[slot] = TreeNode::leaf(static_cast<uint32_t>(begin), static_cast<uint32_t>(count));
      return;
    }
    const uint32_t left = build_detail::left_slot(slot);
    const uint32_t right = build_detail::right_slot(slot, middle - begin);
    slots_[slot] = TreeNode::inner(left, right);
    const auto build_left = [&] { build(left, begin, middle, depth + 1); };
    const auto build_right = [&] { build(right, middle, end, depth + 1); };
    if (count > build_detail::kTaskSize) {
      parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
  }

  // Partitions the range and returns its middle, or `begin` to make it a leaf.
  size_t split(size_t begin, size_t end, int depth) {
    const size_t count = end - begin;
    const size_t halves = begin + count / 2;
    if (depth >= build_detail::kBalanceDepth) return count <= config_.max_leaf ? begin : halves;

    Binning binning;
    Rows box;
    measure(begin, end, binning.centers, box);
    binning.prepare(config_.bins);
    const Split best = best_split(gather(begin, end, binning), binning, config_);

    const float area = box.half_area();
    const float split_cost = config_.traversal_cost * area + best.cost;
    const bool leaf_is_cheaper = build_detail::leaf_cost(config_, count) * area <= split_cost;
    if (count <= config_.max_leaf && (best.axis < 0 || leaf_is_cheaper)) return begin;
    if (best.axis < 0) return halves;
    const auto middle = std::partition(
        refs_.begin() + begin, refs_.begin() + end,
        [&](const PrimitiveRef& ref) { return binning.bin(ref, best.axis) < best.bin; });
    return static_cast<size_t>(middle - refs_.begin());
  }

  void measure(size_t begin, size_t end, Rows& centers, Rows& box) const {
    const auto add = [&](size_t first, size_t last, Rows& c, Rows& b) {
      for (size_t i = first; i < last; ++i) {
        Rows center;
        for (int k = 0; k < 4; ++k) center.low[k] = refs_[i].box.low[k] + refs_[i].box.high[k];
        for (int k = 0; k < 4; ++k) center.high[k] = center.low[k];
        c.extend(center);
        b.extend(refs_[i].box);
      }
    };
    if (end - begin <= kChunk) return add(begin, end, centers, box);
    std::vector<std::pair<Rows, Rows>> parts((end - begin + kChunk - 1) / kChunk);
    parallel_for(end - begin, kChunk, [&](size_t first, size_t last) {
      std::pair<Rows, Rows>& part = parts[first / kChunk];
      add(begin + first, begin + last, part.first, part.second);
    });
    for (const auto& part : parts) {
      centers.extend(part.first);
      box.extend(part.second);
    }
  }

  Bins gather(size_t begin, size_t end, const Binning& binning) const {
    Bins bins;
    if (end - begin <= kChunk) {
      for (size_t i = begin; i < end; ++i) bins.add(refs_[i], binning);
      return bins;
    }
    std::vector<Bins> parts((end - begin + kChunk - 1) / kChunk);
    parallel_for(end - begin, kChunk, [&](size_t first, size_t last) {
      Bins& part = parts[first / kChunk];
      for (size_t i = first; i < last; ++i) part.add(refs_[begin + i], binning);
    });
    for (const Bins& part : parts) bins.add(part, binning.bins);
    return bins;
  }

  BuildConfig config_;
  std::vector<PrimitiveRef> refs_;
  std::vector<TreeNode> slots_;
};

}  // namespace

Tree build_binned(std::span<const Box> primitive_boxes, const BuildConfig& config) {
  SINEW_CHECK(config.bins >= 2 && config.bins <= kMaxBins);
  SINEW_CHECK(config.max_leaf >= 1 && config.leaf_block >= 1);
  return BinnedBuilder(primitive_boxes, config).run();
}

}  // namespace sinew
