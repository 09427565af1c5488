// Full-sweep SAH, top down: every plane between two neighbouring centroids on every axis is tried.
// Based on: V. Havran, "Heuristic Ray Shooting Algorithms", 2000; J. Goldsmith, J. Salmon,
// "Automatic Creation of Object Hierarchies for Ray Tracing", 1987 (the cost).
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/build_common.h"

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

class SweepBuilder {
 public:
  SweepBuilder(std::span<const Box> boxes, const BuildConfig& config)
      : config_(config), refs_(build_detail::make_refs(boxes)) {
    if (refs_.empty()) return;
    slots_.resize(2 * refs_.size() - 1);
    right_cost_.resize(refs_.size());
  }

  Tree run() {
    if (refs_.empty()) return {};
    build(0, 0, refs_.size(), 0);
    return build_detail::compact(slots_, refs_);
  }

 private:
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

  size_t split(size_t begin, size_t end, int depth) {
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

  void sweep(std::span<const PrimitiveRef> refs, size_t begin, int axis, Split& best) {
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

  BuildConfig config_;
  std::vector<PrimitiveRef> refs_;
  std::vector<TreeNode> slots_;
  std::vector<float> right_cost_;  // scratch: every task uses its own range
};

}  // namespace

Tree build_sweep(std::span<const Box> primitive_boxes, const BuildConfig& config) {
  SINEW_CHECK(config.max_leaf >= 1 && config.leaf_block >= 1);
  return SweepBuilder(primitive_boxes, config).run();
}

}  // namespace sinew
