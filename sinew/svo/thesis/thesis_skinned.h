// Every voxel skinned by joints of its own, within our own rasteriser: the thesis's idea with the
// same queue, tiles, culling, levels of detail and SIMD as the skin lattice has. An opponent for
// benches: it answers what the lattice itself is worth. Only the middles of voxels are its own;
// cells, boxes and their sizes are those that the lattice gives.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/draw/rasterize.h"
#include "sinew/svo/thesis/thesis_voxels.h"

namespace sinew {

// Four joints and weights a voxel: 8 bytes, those of one voxel in a lane each. The last 16 entries
// of an array are there to be read only.
struct SkinnedLevel {
  std::vector<uint32_t> joints;         // four bytes: of the body's
  std::vector<uint32_t> palette_slots;  // four bytes: the same within the cell's palette
  std::vector<uint32_t> weights;        // four bytes: of 255, which is their sum
};

struct SkinnedVoxels {
  static constexpr uint32_t kPalette = 16;
  static constexpr uint32_t kMostJoints = 256;
  SkinnedLevel levels[3];                               // in the order of the octree's attributes
  std::vector<std::array<uint8_t, kPalette>> palettes;  // one a cell
  std::vector<uint8_t> palette_sizes;                   // 0: more joints than fit
  std::vector<std::array<uint32_t, 3>> first;           // of each cell: its first in each level
  uint32_t joints = 0;
};

// `voxels` are those that the octree was made from. Voxels of levels 1 and 2 have the mean weights
// of theirs. At most kMostJoints joints (checked).
SkinnedVoxels make_skinned_voxels(const Svo& svo, std::span<const ThesisVoxel> voxels);

enum class SkinnedLookup : uint8_t {
  gather,   // matrices of the body's joints are gathered, lane by lane
  palette,  // those of the cell's joints lie in registers, where they fit
};

// What place_voxels() reads: for each joint twelve numbers, and four more that are not used. Rows
// of (x, y, depth), of the middle of a voxel in voxels of the grid.
struct SkinnedTable {
  const SkinnedVoxels* voxels = nullptr;
  SkinnedLookup lookup = SkinnedLookup::palette;
  std::vector<float> rows;
};
void set_view(const VoxelInstance& instance, const RasterView& view, SkinnedTable& out);

// As rasterize(), for one instance whose octree `table.voxels` belong to. `table` is filled anew.
RasterStats rasterize_skinned(const VoxelInstance& instance, const RasterView& view,
                              const RasterSettings& settings, SkinnedTable& table,
                              RasterScratch& scratch, Visibility& out);

}  // namespace sinew
