// What a shell of voxels encloses: flooded from outside, block by block. Internal to the voxeliser.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/format.h"

namespace sinew {

// One bit a voxel of a block: bit x of row y + 64 z.
using BlockBits = std::array<uint64_t, kBlockSide * kBlockSide>;

// Blocks along each axis; block (x, y, z) has index x + count.x * (y + count.y * z).
struct BlockGrid {
  uvec3 count{0};

  uint32_t index(uvec3 block) const { return block.x + count.x * (block.y + count.y * block.z); }
  size_t size() const { return size_t{count.x} * count.y * count.z; }
};

inline constexpr int32_t kNoShell = -1;

// The voxels that a path over faces of voxels reaches from beyond the grid without a shell voxel.
struct Outside {
  std::vector<uint8_t> whole;    // one a block without shell voxels: all of it is outside, or none
  std::vector<BlockBits> parts;  // of blocks with shell voxels, by their slots
};

// `slot` has one entry a block: where its bits are in `shell`, or kNoShell.
Outside flood_from_outside(const BlockGrid& grid, std::span<const int32_t> slot,
                           std::span<const BlockBits> shell);

}  // namespace sinew
