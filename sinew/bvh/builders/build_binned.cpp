// Binned SAH, top down. Based on: I. Wald, "On fast Construction of SAH-based Bounding Volume
// Hierarchies", 2007. Differs: all three axes are binned, leaf costs count blocks of primitives,
// and the primitives' boxes move with their indices.
#include "sinew/base/check.h"
#include "sinew/bvh/builders/build_bins.h"

namespace sinew {
namespace {

using build_detail::Binning;
using build_detail::Bins;
using build_detail::PrimitiveRef;
using build_detail::Rows;
using build_detail::Split;

// Splits ranges of primitives at the best plane between bins.
class BinnedSplit {
 public:
  BinnedSplit(std::vector<PrimitiveRef>& refs, const BuildConfig& config)
      : config_(config), refs_(refs) {}

  size_t operator()(size_t begin, size_t end, int depth) const {
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
    return build_detail::partition_at(refs_, begin, end, binning, best);
  }

 private:
  static constexpr size_t kChunk = 16384;  // primitives binned by one task

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

  const BuildConfig& config_;
  std::vector<PrimitiveRef>& refs_;
};

}  // namespace

Tree build_binned(std::span<const Box> primitive_boxes, const BuildConfig& config) {
  SINEW_CHECK(config.bins >= 2 && config.bins <= build_detail::kMaxBins);
  SINEW_CHECK(config.max_leaf >= 1 && config.leaf_block >= 1);
  std::vector<PrimitiveRef> refs = build_detail::make_refs(primitive_boxes);
  const BinnedSplit split(refs, config);
  return build_detail::TopDown(refs, split).run();
}

}  // namespace sinew
