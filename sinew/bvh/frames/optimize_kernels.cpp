// Boxes of many frames at once: the search for better places of subtrees, unions, areas.
// The search is that of D. Meister, J. Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy
// Optimization", 2018, section 3: from the subtree upwards, and down into every subtree passed.
// Differs: areas are sums over frames (T's cost vectors), places beside ancestors are tried too,
// and the way up ends where the subtree no longer reaches out of the rest.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/frames/optimize_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/bvh/frames/optimize_kernels.h"
#include "sinew/base/buffer.h"
#include "sinew/bvh/frames/frame_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Searches for one subtree after another. A place saves the area of the subtree's parent, which
// goes, and what its ancestors shrink by, less the area of the new parent, and what its ancestors
// grow by.
template <uint32_t kRow>
class Search {
 public:
  Search(const FrameView& tree, uint32_t most, float* rest)
      : tree_(tree), ops_(tree.g, tree.padding), most_(most), rest_(rest) {}

  Reinsertion run(uint32_t slot) {
    subject_ = box(slot);
    area_ = tree_.areas[slot];
    looked_ = 0;
    uint32_t at = tree_.parent[slot >> 1];  // an ancestor; first the one that goes
    float saved = tree_.areas[at];          // when the subtree is taken out of `at`
    best_ = {kLeastGain * saved, kNoSlot};
    ops_.join(box(slot ^ 1), box(slot ^ 1), rest_);
    bool inside = ops_.contains(rest_, subject_);
    search_below(slot ^ 1, tree_.areas[slot ^ 1]);
    while (at > 1 && !(inside && saved - area_ <= best_.gain)) {
      const uint32_t beside = at ^ 1;
      const float both = ops_.union_area(box(beside), subject_);
      consider(beside, saved - both);
      search_below(beside, saved - (both - tree_.areas[beside]));
      at = tree_.parent[at >> 1];
      if (!inside) {
        ops_.join(rest_, box(beside), rest_);
        inside = ops_.contains(rest_, subject_);
        saved += tree_.areas[at] - ops_.area(rest_);
      }
      consider(at, saved - tree_.areas[at]);
    }
    if (best_.to == kNoSlot) best_.gain = 0.0f;
    return best_;
  }

 private:
  struct Pending {
    uint32_t record;
    float saved;  // after this record and those above have grown
  };
  static constexpr uint32_t kStack = 256;

  HWY_INLINE const float* box(uint32_t slot) const {
    return tree_.boxes + size_t{slot} * ops_.box_floats();
  }

  HWY_INLINE void consider(uint32_t slot, float gain) {
    if (gain > best_.gain) best_ = {gain, slot};
  }

  // Tries the places below what `slot` holds. saved: after its box has grown.
  void search_below(uint32_t slot, float saved) {
    uint32_t count = 0;
    push(slot, saved, count);
    while (count > 0 && looked_ < most_) {
      const Pending next = stack_[--count];
      if (next.saved - area_ <= best_.gain) continue;
      ++looked_;
      const uint32_t left = 2 * next.record, right = left + 1;
      const float with_left = ops_.union_area(box(left), subject_);
      const float with_right = ops_.union_area(box(right), subject_);
      consider(left, next.saved - with_left);
      consider(right, next.saved - with_right);
      const float saved_left = next.saved - (with_left - tree_.areas[left]);
      const float saved_right = next.saved - (with_right - tree_.areas[right]);
      if (saved_left > saved_right) {  // the more promising one is popped first
        push(right, saved_right, count);
        push(left, saved_left, count);
      } else {
        push(left, saved_left, count);
        push(right, saved_right, count);
      }
    }
  }

  HWY_INLINE void push(uint32_t slot, float saved, uint32_t& count) {
    const uint32_t child = tree_.child[slot];
    if (is_primitive(child) || saved - area_ <= best_.gain || count == kStack) return;
    stack_[count++] = {child, saved};
  }

  const FrameView& tree_;
  FrameBoxOps<kRow> ops_;
  uint32_t most_;
  float* rest_;  // the box of `at` without the subtree
  const float* subject_ = nullptr;
  float area_ = 0.0f;
  uint32_t looked_ = 0;
  Reinsertion best_;
  Pending stack_[kStack];
};

template <uint32_t kRow>
void find(const FrameView& tree, std::span<const uint32_t> slots, uint32_t most, Reinsertion* out) {
  Buffer<float> rest(kBoxRows * tree.padding);
  Search<kRow> search(tree, most, rest.data());
  for (size_t i = 0; i < slots.size(); ++i) out[i] = search.run(slots[i]);
}

// The slot nearest to both on their ways to the root, or kNoSlot if `to` lies below `slot`.
inline uint32_t meeting_slot(const FrameView& tree, uint32_t slot, uint32_t from, uint32_t to) {
  uint32_t a = from, b = to, depth_a = 0, depth_b = 0;
  for (uint32_t at = a; at > 1; at = tree.parent[at >> 1]) ++depth_a;
  for (uint32_t at = b; at > 1; at = tree.parent[at >> 1]) {
    if (at == slot) return kNoSlot;
    ++depth_b;
  }
  for (; depth_a > depth_b; --depth_a) a = tree.parent[a >> 1];
  for (; depth_b > depth_a; --depth_b) b = tree.parent[b >> 1];
  while (a != b) {
    a = tree.parent[a >> 1];
    b = tree.parent[b >> 1];
  }
  return a;
}

template <uint32_t kRow>
bool savings(const FrameView& tree, uint32_t slot, uint32_t to, float* rest, float* saved) {
  const FrameBoxOps<kRow> ops(tree.g, tree.padding);
  const float* const subject = tree.box(slot);
  const uint32_t from = tree.parent[slot >> 1];
  if (to == slot || to == (slot ^ 1) || to == from) return false;
  const uint32_t meeting = meeting_slot(tree, slot, from, to);
  if (meeting == kNoSlot) return false;

  // Taking it out, below the meeting slot; if that is `to`, it shrinks as well.
  ops.clear_row(saved);
  ops.add_areas(tree.box(from), saved);
  ops.join(tree.box(slot ^ 1), tree.box(slot ^ 1), rest);
  for (uint32_t at = from; at != meeting && !ops.contains(rest, subject);) {
    ops.join(rest, tree.box(at ^ 1), rest);
    at = tree.parent[at >> 1];
    if (at == meeting && at != to) break;
    ops.add_areas(tree.box(at), saved);
    ops.subtract_union_areas(rest, rest, saved);
  }
  // Putting it in: the new parent, and what grows above it.
  ops.subtract_union_areas(tree.box(to), subject, saved);
  if (to == meeting) return true;
  for (uint32_t at = tree.parent[to >> 1]; at != meeting && !ops.contains(tree.box(at), subject);
       at = tree.parent[at >> 1]) {
    ops.add_areas(tree.box(at), saved);
    ops.subtract_union_areas(tree.box(at), subject, saved);
  }
  return true;
}

template <uint32_t kRow>
void combine(const FrameView& tree, uint32_t first, uint32_t last) {
  const FrameBoxOps<kRow> ops(tree.g, tree.padding);
  for (uint32_t record = last; record-- > first;) {
    const uint32_t slot = tree.parent[record];
    ops.join(tree.box(2 * record), tree.box(2 * record + 1), tree.box(slot));
  }
}

template <uint32_t kRow>
void combine_up(const FrameView& tree, uint32_t record) {
  const FrameBoxOps<kRow> ops(tree.g, tree.padding);
  while (record != 0) {
    tree.changed[record] = 1;
    const uint32_t slot = tree.parent[record];
    if (ops.join(tree.box(2 * record), tree.box(2 * record + 1), tree.box(slot))) break;
    tree.areas[slot] = ops.area(tree.box(slot));
    record = slot >> 1;
  }
}

template <uint32_t kRow>
void weigh(const FrameView& tree, uint32_t begin, uint32_t end) {
  const FrameBoxOps<kRow> ops(tree.g, tree.padding);
  for (uint32_t slot = begin; slot < end; ++slot) tree.areas[slot] = ops.area(tree.box(slot));
}

template <uint32_t kRow>
void add(const FrameView& tree, uint32_t begin, uint32_t end, const CostModel& model,
         double* sums) {
  using Ops = FrameBoxOps<kRow>;
  const Ops ops(tree.g, tree.padding);
  HWY_ALIGN float areas[8];
  for (uint32_t slot = begin; slot < end; ++slot) {
    const double cost = is_primitive(tree.child[slot]) ? model.intersection : model.traversal;
    const float* const box = tree.box(slot);
    for (uint32_t f = 0; f < tree.frames; f += Ops::lanes()) {
      hn::Store(ops.half_areas(box, box, f), typename Ops::D(), areas);
      for (uint32_t i = 0; i < Ops::lanes() && f + i < tree.frames; ++i) {
        sums[f + i] += cost * double(areas[i]);
      }
    }
  }
}

void find_kernel(const FrameView& tree, std::span<const uint32_t> slots, uint32_t most,
                 Reinsertion* out) {
  SINEW_FOR_ROW(tree.padding, find, (tree, slots, most, out));
}

bool savings_kernel(const FrameView& tree, uint32_t slot, uint32_t to, float* rest, float* saved) {
  SINEW_FOR_ROW(tree.padding, savings, (tree, slot, to, rest, saved));
}

void combine_kernel(const FrameView& tree, uint32_t first, uint32_t last) {
  SINEW_FOR_ROW(tree.padding, combine, (tree, first, last));
}

void combine_up_kernel(const FrameView& tree, uint32_t record) {
  SINEW_FOR_ROW(tree.padding, combine_up, (tree, record));
}

void weigh_kernel(const FrameView& tree, uint32_t begin, uint32_t end) {
  SINEW_FOR_ROW(tree.padding, weigh, (tree, begin, end));
}

void add_kernel(const FrameView& tree, uint32_t begin, uint32_t end, const CostModel& model,
                double* sums) {
  SINEW_FOR_ROW(tree.padding, add, (tree, begin, end, model, sums));
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(find_kernel);
HWY_EXPORT(savings_kernel);
HWY_EXPORT(combine_kernel);
HWY_EXPORT(combine_up_kernel);
HWY_EXPORT(weigh_kernel);
HWY_EXPORT(add_kernel);

void find_reinsertions(const FrameView& tree, std::span<const uint32_t> slots, uint32_t most,
                       Reinsertion* out) {
  HWY_DYNAMIC_DISPATCH(find_kernel)(tree, slots, most, out);
}

bool move_savings(const FrameView& tree, uint32_t slot, uint32_t to, float* rest, float* saved) {
  return HWY_DYNAMIC_DISPATCH(savings_kernel)(tree, slot, to, rest, saved);
}

void combine_records(const FrameView& tree, uint32_t first, uint32_t last) {
  HWY_DYNAMIC_DISPATCH(combine_kernel)(tree, first, last);
}

void combine_upwards(const FrameView& tree, uint32_t record) {
  HWY_DYNAMIC_DISPATCH(combine_up_kernel)(tree, record);
}

void weigh_slots(const FrameView& tree, uint32_t begin, uint32_t end) {
  HWY_DYNAMIC_DISPATCH(weigh_kernel)(tree, begin, end);
}

void add_costs(const FrameView& tree, uint32_t begin, uint32_t end, const CostModel& model,
               double* sums) {
  HWY_DYNAMIC_DISPATCH(add_kernel)(tree, begin, end, model, sums);
}

}  // namespace sinew
#endif
