// What the top-down builders share: primitive references, slots for nodes that make the result
// independent of the order in which subtrees finish, and leaf costs.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/tree.h"

namespace sinew::build_detail {

// A box in two four-float rows, which compilers keep in one SIMD register each.
struct Rows {
  float low[4] = {kInfinity, kInfinity, kInfinity, 0};
  float high[4] = {-kInfinity, -kInfinity, -kInfinity, 0};
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  void extend(const Rows& b) {
    for (int i = 0; i < 4; ++i) low[i] = b.low[i] < low[i] ? b.low[i] : low[i];
    for (int i = 0; i < 4; ++i) high[i] = b.high[i] > high[i] ? b.high[i] : high[i];
  }
  float half_area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x < 0 ? 0.0f : x * y + y * z + z * x;
  }
};

struct PrimitiveRef {
  Rows box;
  uint32_t index = 0;

  // Twice the centre: saves a multiplication and keeps order.
  float center2(int axis) const { return box.low[axis] + box.high[axis]; }
};

inline std::vector<PrimitiveRef> make_refs(std::span<const Box> boxes) {
  std::vector<PrimitiveRef> refs(boxes.size());
  for (size_t i = 0; i < boxes.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      refs[i].box.low[axis] = boxes[i].min[axis];
      refs[i].box.high[axis] = boxes[i].max[axis];
    }
    refs[i].index = static_cast<uint32_t>(i);
  }
  return refs;
}

inline float leaf_cost(const BuildConfig& config, size_t count) {
  return config.intersection_cost *
         static_cast<float>((count + config.leaf_block - 1) / config.leaf_block);
}

// Beyond this depth builders halve ranges blindly, so no tree of 2^28 primitives is deeper than
// kMaxDepth of wide.h.
inline constexpr int kBalanceDepth = 48;

// Ranges larger than this are built by a task of their own.
inline constexpr size_t kTaskSize = 4096;

// A subtree over n primitives gets 2n - 1 consecutive slots: its root, then its left subtree's,
// then its right subtree's. So indices do not depend on which thread is faster. compact() removes
// the slots that leaves of several primitives left unused.
inline uint32_t left_slot(uint32_t slot) {
  return slot + 1;
}
inline uint32_t right_slot(uint32_t slot, size_t left_count) {
  return slot + 2 * static_cast<uint32_t>(left_count);
}

inline Tree compact(const std::vector<TreeNode>& slots, const std::vector<PrimitiveRef>& refs) {
  Tree tree;
  tree.primitives.reserve(refs.size());
  for (const PrimitiveRef& ref : refs) tree.primitives.push_back(ref.index);
  if (slots.empty()) return tree;

  struct Pending {
    uint32_t slot, parent;
    bool right;
  };
  std::vector<Pending> stack = {{0, 0, false}};
  while (!stack.empty()) {
    const Pending item = stack.back();
    stack.pop_back();
    const auto node = static_cast<uint32_t>(tree.nodes.size());
    tree.nodes.push_back(slots[item.slot]);
    if (node > 0) (item.right ? tree.nodes[item.parent].b : tree.nodes[item.parent].a) = node;
    if (slots[item.slot].is_leaf()) continue;
    stack.push_back({slots[item.slot].right(), node, true});
    stack.push_back({slots[item.slot].left(), node, false});
  }
  return tree;
}

// Builds a tree over refs from the root down. split(begin, end, depth) reorders the references of
// its range and returns where the right subtree begins, or `begin` to make the range a leaf; ranges
// of one are leaves without asking. Disjoint ranges are split by different threads at once.
template <class Split>
class TopDown {
 public:
  TopDown(std::vector<PrimitiveRef>& refs, const Split& split) : refs_(refs), split_(split) {}

  Tree run() {
    if (refs_.empty()) return {};
    slots_.resize(2 * refs_.size() - 1);
    build(0, 0, refs_.size(), 0);
    return compact(slots_, refs_);
  }

 private:
  void build(uint32_t slot, size_t begin, size_t end, int depth) {
    const size_t count = end - begin;
    const size_t middle = count == 1 ? begin : split_(begin, end, depth);
    if (middle == begin) {
      slots_[slot] = TreeNode::leaf(static_cast<uint32_t>(begin), static_cast<uint32_t>(count));
      return;
    }
    const uint32_t left = left_slot(slot);
    const uint32_t right = right_slot(slot, middle - begin);
    slots_[slot] = TreeNode::inner(left, right);
    const auto build_left = [&] { build(left, begin, middle, depth + 1); };
    const auto build_right = [&] { build(right, middle, end, depth + 1); };
    if (count > kTaskSize) {
      parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
  }

  std::vector<PrimitiveRef>& refs_;
  const Split& split_;
  std::vector<TreeNode> slots_;
};

}  // namespace sinew::build_detail
