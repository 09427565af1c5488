// The kernels behind optimize(): boxes of many frames at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/bvh/cost.h"
#include "sinew/bvh/frames/frame_rows.h"

namespace sinew {

inline constexpr uint32_t kNoSlot = 0xffffffffu;
inline constexpr uint32_t kPrimitiveBit = 0x80000000u;
inline bool is_primitive(uint32_t child) {
  return (child & kPrimitiveBit) != 0;
}

// Views of a FrameTree (frame_tree.h).
struct FrameView {
  float* boxes = nullptr;      // [slot][row][padding]
  float* areas = nullptr;      // [slot]: sum_i g_i * half area in frame i
  uint32_t* child = nullptr;   // [slot]: record, or kPrimitiveBit | primitive
  uint32_t* parent = nullptr;  // [record]: the slot that holds it
  uint8_t* changed = nullptr;  // [record]: set where moves change boxes
  const float* g = nullptr;    // [padding], 0 for frames that are none
  uint32_t padding = 0;        // floats a row
  uint32_t frames = 0;

  float* box(uint32_t slot) const { return boxes + size_t{slot} * kBoxRows * padding; }
};

// Where a subtree would better be: beside what the slot `to` holds, under a new parent.
struct Reinsertion {
  float gain = 0.0f;      // what the areas of all inner nodes become less by, in sum
  uint32_t to = kNoSlot;  // kNoSlot: it is best where it is
};

// Smaller gains, relative to the area of the subtree's parent, are rounding.
inline constexpr float kLeastGain = 1e-5f;

// The best place for each of the subtrees in `slots` (2 or more), by branch and bound over the
// tree without it. After looking below `most` records a search takes the best that it has seen.
void find_reinsertions(const FrameView& tree, std::span<const uint32_t> slots, uint32_t most,
                       Reinsertion* out);

// What the half areas of all inner nodes become less by, in every frame, when the subtree in `slot`
// moves beside `to`: saved [padding]. False if it is there, or `to` lies below it. rest: memory for
// one box.
bool move_savings(const FrameView& tree, uint32_t slot, uint32_t to, float* rest, float* saved);

// Boxes of the slots that hold the records [first, last), of which parents stand before children.
void combine_records(const FrameView& tree, uint32_t first, uint32_t last);

// Boxes and areas of the slots that hold the record and its ancestors, up to where nothing changes.
void combine_upwards(const FrameView& tree, uint32_t record);

// Areas of the slots [begin, end) from their boxes.
void weigh_slots(const FrameView& tree, uint32_t begin, uint32_t end);

// Adds what the slots [begin, end) contribute to the cost of every frame to sums[frame].
void add_costs(const FrameView& tree, uint32_t begin, uint32_t end, const CostModel& model,
               double* sums);

}  // namespace sinew
