// Full-sweep SAH, top down: every plane between two neighbouring centroids on every axis is tried.
// Based on: V. Havran, "Heuristic Ray Shooting Algorithms", 2000; J. Goldsmith, J. Salmon,
// "Automatic Creation of Object Hierarchies for Ray Tracing", 1987 (the cost).
#include "sinew/base/check.h"
#include "sinew/bvh/builders/build_common.h"

namespace sinew {
namespace {

using build_detail::PrimitiveRef;
using build_detail::Rows;

struct Split {
  int axis = -1;
  size_t left = 0;  // primitives on the left after sorting on the axis
  float cost = std::numeric_limits<float>::infinity();
};

void sort_on(std::span<PrimitiveRef> refs, int axis) {
  std::sort(refs.begin(), refs.end(), [axis](const PrimitiveRef& a, const PrimitiveRef& b) {
    const float x = a.center2(axis), y = b.center2(axis);
    return x < y || (x == y && a.index < b.index);
  });
}

// Splits ranges of primitives at the best plane between two centroids.
class SweepSplit {
 public:
  SweepSplit(std::vector<PrimitiveRef>& refs, const BuildConfig& config)
      : config_(config), refs_(refs), right_cost_(refs.size()) {}

  size_t operator()(size_t begin, size_t end, int depth) const {
    const size_t count = end - begin;
    const std::span<PrimitiveRef> refs(refs_.data() + begin, count);
    const bool may_be_leaf = count <= config_.max_leaf;
    if (depth >= build_detail::kBalanceDepth) return may_be_leaf ? begin : begin + count / 2;

    Split best;
    int sorted = -1;
    for (int axis = 0; axis < 3; ++axis) {
      sort_on(refs, axis);
      sorted = axis;
      sweep(refs, begin, axis, best);
    }
    Rows box;
    for (const PrimitiveRef& ref : refs) box.extend(ref.box);
    const float area = box.half_area();
    const float split_cost = config_.traversal_cost * area + best.cost;
    if (may_be_leaf && build_detail::leaf_cost(config_, count) * area <= split_cost) return begin;
    if (best.axis < 0) return begin + count / 2;
    if (sorted != best.axis) sort_on(refs, best.axis);
    return begin + best.left;
  }

 private:
  void sweep(std::span<const PrimitiveRef> refs, size_t begin, int axis, Split& best) const {
    Rows box;
    float* const right_cost = right_cost_.data() + begin;
    for (size_t i = refs.size() - 1; i > 0; --i) {
      box.extend(refs[i].box);
      right_cost[i] = box.half_area() * build_detail::leaf_cost(config_, refs.size() - i);
    }
    box = Rows();
    for (size_t i = 1; i < refs.size(); ++i) {
      box.extend(refs[i - 1].box);
      const float cost = box.half_area() * build_detail::leaf_cost(config_, i) + right_cost[i];
      if (cost < best.cost) best = {axis, i, cost};
    }
  }

  const BuildConfig& config_;
  std::vector<PrimitiveRef>& refs_;
  mutable std::vector<float> right_cost_;  // scratch: every task uses its own range
};

}  // namespace

Tree build_sweep(std::span<const Box> primitive_boxes, const BuildConfig& config) {
  SINEW_CHECK(config.max_leaf >= 1 && config.leaf_block >= 1);
  std::vector<PrimitiveRef> refs = build_detail::make_refs(primitive_boxes);
  const SweepSplit split(refs, config);
  return build_detail::TopDown(refs, split).run();
}

}  // namespace sinew
