// What groups of rays have still to visit. Included once per target.
#if defined(SINEW_BVH_GROUP_STACK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_GROUP_STACK_INL_H_
#undef SINEW_BVH_GROUP_STACK_INL_H_
#else
#define SINEW_BVH_GROUP_STACK_INL_H_
#endif

#include "sinew/bvh/trace/ray_group-inl.h"
#include "sinew/bvh/trace/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// Nodes are held back (see take_next) while no more entries than these wait, once in the top tree
// and once in a body, so that the stack is bounded as without it.
constexpr size_t kMostHeldOver = 128;
constexpr size_t kGroupStack = kStackSize + 2 * (kMostHeldOver + kWidth);

// A child word and the rays that go there.
struct GroupEntry {
  uint64_t rays;  // that meet the box
  float entry;    // where the first of them does
  uint32_t word;
};

// What is still to be visited. Any hit needs no order, so there entries are pushed many at a time.
template <bool kAny>
class GroupStack {
 public:
  void push(size_t& top, const GroupEntry& next) { entry_[top++] = next; }
  // Farthest first, from `first` on.
  void insert(size_t first, size_t& top, const GroupEntry& next) {
    size_t place = top++;
    for (; place > first && entry_[place - 1].entry < next.entry; --place) {
      entry_[place] = entry_[place - 1];
    }
    entry_[place] = next;
  }
  GroupEntry at(size_t i) const { return entry_[i]; }

 private:
  GroupEntry entry_[kGroupStack];
};
template <>
class GroupStack<true> {
 public:
  void push(size_t& top, const GroupEntry& next) {
    low_[top] = static_cast<uint32_t>(next.rays);
    high_[top] = static_cast<uint32_t>(next.rays >> 32);
    word_[top++] = next.word;
  }
  void insert(size_t, size_t& top, const GroupEntry& next) { push(top, next); }
  // The children that rays go to.
  HWY_INLINE void push_met(size_t& top, const Node8& node, const ChildRays& rays) {
    const D8u d;
    for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
      const auto low = hn::Load(d, rays.low + i), high = hn::Load(d, rays.high + i);
      const uint32_t bits = mask_bits(d, hn::Ne(hn::Or(low, high), hn::Zero(d)));
      store_lanes(d, low, bits, low_ + top);
      store_lanes(d, high, bits, high_ + top);
      store_lanes(d, hn::Load(d, node.child + i), bits, word_ + top);
      top += static_cast<uint32_t>(__builtin_popcount(bits));
    }
  }
  GroupEntry at(size_t i) const { return {uint64_t{high_[i]} << 32 | low_[i], 0.0f, word_[i]}; }

 private:
  uint32_t low_[kGroupStack], high_[kGroupStack];  // halves of GroupEntry::rays
  uint32_t word_[kGroupStack];
};

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
