// BoxBody: a body of boxes that are hit themselves, beside those of triangles. Its inner nodes are
// Node8, and so are its leaves, *packets* of eight boxes, whose child[] are primitive numbers
// (kNoChild: none). So one test serves both. A ray hits a box where it enters it, or where the ray
// begins if that is inside.
//
//   31 30 29 ............................ 0     child words, as in wide.h
//    0  index of an inner node
//    1  0  first packet << 3 | packets - 1      packets stand among the nodes
//    1  1  index of a treelet
//
// What a ray has not met yet is not made. Treelets [0, parts) are *parts*, made as a whole. Those
// after them are *details*, of which every level of detail is made by itself, and the finest that
// the ray's footprint tells apart is traced, of those that are there. Whoever finds a treelet being
// made waits for it: that takes microseconds. Every treelet has its own place among the nodes, so
// the bits do not depend on who makes it.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "sinew/bvh/wide.h"

namespace sinew {

inline constexpr uint32_t kBoxLevels = 4;  // of details; the last one is their box itself

// One line of the cache. Written by what makes the treelet that it hangs below.
struct alignas(64) BoxDetail {
  float low[3];
  float size;  // of a box of level 0, roughly; twice as much from level to level
  float high[3];
  uint32_t made;                  // bit l: level l is; bit 8 + l: somebody is at it. Atomic
  uint32_t root[kBoxLevels - 1];  // child words of levels that are made
  uint32_t whole;                 // primitive of the last level
  uint32_t finest;                // level that may be used
  uint32_t wish;                  // place in BoxBody::wishes
};
static_assert(sizeof(BoxDetail) == 64);

// Views only; constant while rays are traced, but for what the atomics guard.
struct BoxBody {
  const Node8* nodes = nullptr;
  uint32_t root = kNoChild;  // child word
  uint32_t parts = 0;
  uint32_t epoch = 0;                   // of the pose
  uint32_t* part_state = nullptr;       // 2 * epoch + 1: made; 2 * epoch: somebody is at it. Atomic
  const uint32_t* part_root = nullptr;  // child words
  BoxDetail* details = nullptr;
  void (*make_part)(void* context, uint32_t part) = nullptr;
  // Returns the child word.
  uint32_t (*make_detail)(void* context, uint32_t detail, uint32_t level) = nullptr;
  void* context = nullptr;
  // Where levels come and go: how large a box of level 0 is at most, in widths of the rays that
  // came to a detail and would have more than its box, whether that is there or not. Bits of a
  // float; 0: none came. Null: nobody wants to know.
  std::atomic<uint32_t>* wishes = nullptr;
};

// For a ray of this width at the detail. One without a width wants all there is, as if a box were
// kNarrow widths large; one that is content with the detail's box has no wish.
inline constexpr float kNarrow = 16.0f;
void raise_wish(std::atomic<uint32_t>& wish, uint32_t bits);
inline void wish_for(const BoxBody& body, const BoxDetail& detail, float width) {
  constexpr float kLeast = 0x1p-20f, kMost = 0x1p20f;
  constexpr uint32_t kCoarsest = 1u << (kBoxLevels - 2);
  if (kCoarsest * detail.size < width) return;
  const float boxes = width > 0.0f ? detail.size / width : kNarrow;
  const auto bits =
      std::bit_cast<uint32_t>(boxes > kLeast ? (boxes < kMost ? boxes : kMost) : kLeast);
  std::atomic<uint32_t>& wish = body.wishes[detail.wish];
  if (wish.load(std::memory_order_relaxed) < bits) raise_wish(wish, bits);
}

// Make what is not made, or wait for who does. True if they made it.
bool make_box_part(const BoxBody& body, uint32_t part);
bool make_box_detail(const BoxBody& body, uint32_t detail, uint32_t level);

// The child word below a treelet; `made` is set if this made it.
inline uint32_t visit_box_part(const BoxBody& body, uint32_t part, bool& made) {
  const uint32_t state = std::atomic_ref(body.part_state[part]).load(std::memory_order_acquire);
  if (state != 2 * body.epoch + 1) made = make_box_part(body, part);
  return body.part_root[part];
}
inline uint32_t visit_box_detail(const BoxBody& body, uint32_t detail, uint32_t level, bool& made) {
  BoxDetail& d = body.details[detail];
  if ((std::atomic_ref(d.made).load(std::memory_order_acquire) >> level & 1) == 0) {
    made = make_box_detail(body, detail, level);
  }
  return d.root[level];
}

}  // namespace sinew
