// The parts of an octree while it is made: each block on its own, in parallel. Cells are written
// one after another, their coarser levels are filtered on the way; then the parts become one Svo.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/svo/format.h"
#include "sinew/svo/levels.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {

// Voxel of a cell (level 0) <-> the last nine bits of its Morton code.
struct CellOrder {
  std::array<uint16_t, 512> code;      // by Morton code: a VoxelCode
  std::array<uint16_t, 512> morton;    // by VoxelCode
  std::array<uint16_t, 512> place;     // by Morton code: x + 8 y + 64 z
  std::array<uint16_t, 512> of_place;  // the Morton code of x + 8 y + 64 z
};
const CellOrder& cell_order();

// The voxels of one copy of a cell, by VoxelCode of level 0. Attributes count where bits are set.
struct CopyVoxels {
  uint64_t masks[8] = {};
  uint16_t normals[512];
  uint16_t colors[512];

  bool has(uint32_t code) const { return masks[code >> 6] >> (code & 63) & 1; }
  void set(uint32_t code, uint16_t normal, uint16_t color) {
    masks[code >> 6] |= uint64_t{1} << (code & 63);
    normals[code] = normal;
    colors[code] = color;
  }
};

// A corner of a block before joints are numbered within it.
struct PartCorner {
  uint16_t place = 0;  // see Svo::corner_places
  std::array<uint16_t, kSvoInfluences> joints = {};
  std::array<uint16_t, kSvoInfluences> weights = {65535, 0, 0, 0};
};

struct BlockPart {
  uint64_t morton = 0;  // of the block
  std::vector<SvoCell> cells;
  std::vector<uint64_t> bricks;
  std::vector<uint16_t> normals;  // one a voxel
  bool exact_colors = false;      // then one a voxel, else ends and selectors
  std::vector<uint16_t> colors;
  std::vector<SvoColorEnds> color_ends;
  std::vector<uint8_t> selectors;  // one a voxel
  SvoLevel brick_level;
  SvoLevel cell_level;
  std::vector<AttributeSum> sums;  // one a cell
  std::vector<PartCorner> corners;
  // Morph targets that move the block, rising, with one delta a corner each.
  std::vector<uint32_t> targets;
  std::vector<std::array<int16_t, 3>> deltas;
};

// Appends a cell with its bricks and levels; its corners are left to the caller.
void append_cell(const CopyVoxels& voxels, uint16_t place, uint16_t material, BlockPart& part);

// What all blocks have in common.
struct SvoFrame {
  VoxelGrid grid;
  uint32_t joints = 0;
  uint32_t morph_targets = 0;
  std::span<const float> units;  // of deltas, one a target
};

// Parts in Morton order, none without cells. An error if the octree is too large for the format.
Result<Svo> join_parts(const SvoFrame& frame, std::span<const BlockPart> parts);

// What such an error says.
tl::unexpected<Error> too_large(const char* what, const char* remedy);

}  // namespace sinew
