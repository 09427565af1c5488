// Voxels for rays: an octree in a pose as a body of boxes, made where rays come (bvh/box_body.h).
//
//   part 0        the nodes of levels above blocks, with boxes from the pose alone
//   part 1 + b    block b: its corners are moved; boxes of its nodes and cells follow from them
//   detail c      cell c. Level 0: packets of its voxels, below one node; 1: of its 2^3 voxels;
//                 2: a packet of its bricks; 3: the cell's box
//
// The box of a voxel is that of its eight corners as the cell's trilinear map takes them, the voxel
// being kRayMargin larger on every side; that of a coarser one contains those of the finer ones in
// it. So no ray slips through between neighbours, and folds of the map do no harm.
//
//   nodes [ part 0 | part 1 | cells of block 0 | part 2 | cells of block 1 | ...
//   cell  [ level 2 | level 1: node, packets | level 0: node, packets ]
//
// The places are constant; memory is touched where something is made.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/buffer.h"
#include "sinew/base/error.h"
#include "sinew/bvh/box_body.h"
#include "sinew/svo/posed.h"

namespace sinew {

// Voxels: how far each reaches beyond itself, as RasterSettings::margin.
inline constexpr float kRayMargin = 0.05f;

// Hit::primitive of a voxel.
inline constexpr uint32_t kMostRayCells = 1u << 22;
inline constexpr uint32_t voxel_primitive(uint32_t cell, VoxelCode code) {
  return cell << 10 | code;
}
inline constexpr uint32_t cell_of_primitive(uint32_t primitive) {
  return primitive >> 10;
}
inline constexpr VoxelCode code_of_primitive(uint32_t primitive) {
  return primitive & 1023;
}

// What is the same in every pose. Blocks, cells, corners and nodes of the octree are read, not its
// voxels.
struct SvoLeafLayout {
  struct Part {
    uint32_t first_child = 0;  // in `children`: one a node of the part, parents before children
    uint32_t first_node = 0;
  };
  const Svo* svo = nullptr;                            // must outlive it
  uint32_t first_block = 0;                            // node of block 0
  std::vector<Part> parts;                             // and one more, for the end of its children
  std::vector<std::array<uint32_t, kWidth>> children;  // child words of nodes of parts
  std::vector<uint32_t> part_roots;                    // child words
  std::vector<uint32_t> first_node;                    // of every cell
  uint32_t node_count = 0;

  size_t bytes() const;
};
// Errors: more than kMostRayCells cells.
Result<SvoLeafLayout> make_leaf_layout(const Svo& svo);

class SvoLeaves {
 public:
  SvoLeaves() = default;
  SvoLeaves(const SvoLeaves&) = delete;  // body() refers to it
  SvoLeaves& operator=(const SvoLeaves&) = delete;

  // Starts a pose: that of `posed`, whose set_pose was called before. Both must outlive the pose.
  // `resident`: one a block; where it is 0, voxels and bricks are not there to be read, and rays
  // meet cells. Rays that would have more ask for the block (PagedSvo::request), and those that
  // have it say that they saw it. Empty: everything is there. Allocates nothing after the first
  // call with a layout, and touches no memory that grows with the octree.
  void set_pose(const SvoLeafLayout& layout, PosedSvo& posed,
                std::span<const uint8_t> resident = {});

  // For Instance::boxes. Valid until the next call of set_pose. Nothing if there are no voxels.
  const BoxBody& body() const { return body_; }

  // Contains every box.
  Box bounds() const;

  struct Counts {
    uint32_t blocks = 0;
    uint32_t cells[kCellLevel] = {};  // of levels 0 to 2
  };
  // Made in this pose; while nobody traces.
  Counts made() const;
  // Bytes of nodes that were made in this pose; while nobody traces.
  size_t bytes_made() const;

  // Makes everything of the level: for tests and figures.
  void make_all(uint32_t level);

 private:
  void make_upper();
  void make_block(uint32_t block);
  uint32_t make_cell(uint32_t cell, uint32_t level);
  uint32_t make_voxels(uint32_t cell, uint32_t level, uint32_t first);

  const SvoLeafLayout* layout_ = nullptr;
  PosedSvo* posed_ = nullptr;
  std::span<const uint8_t> resident_;
  BoxBody body_;
  std::vector<uint32_t> part_state_;
  Buffer<Node8> nodes_;
  Buffer<BoxDetail> cells_;
};

}  // namespace sinew
