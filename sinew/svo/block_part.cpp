// Writes cells: topology, attributes, and the means over their voxels at levels 1 to 3.
#include "sinew/svo/block_part.h"

#include <bit>

namespace sinew {
namespace {

CellOrder make_cell_order() {
  CellOrder order{};
  for (uint32_t morton = 0; morton < 512; ++morton) {
    const uvec3 v = voxel_of(morton), brick = v / 4u, bit = v % 4u;
    const uint32_t code =
        64 * (brick.x + 2 * brick.y + 4 * brick.z) + bit.x + 4 * bit.y + 16 * bit.z;
    const uint32_t place = v.x + 8 * v.y + 64 * v.z;
    order.code[morton] = static_cast<uint16_t>(code);
    order.morton[code] = static_cast<uint16_t>(morton);
    order.place[morton] = static_cast<uint16_t>(place);
    order.of_place[place] = static_cast<uint16_t>(morton);
  }
  return order;
}

// The bits of SvoCell::coarse that the voxels of a brick are in.
uint64_t coarse_mask(uint32_t brick, uint64_t mask) {
  // To bit 0, 2, 8, 10 and those 32 above: the first of each 2^3 voxels.
  mask |= mask >> 1;
  mask |= mask >> 4;
  mask |= mask >> 16;
  uint64_t coarse = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t x = i & 1, y = i >> 1 & 1, z = i >> 2;
    const uint32_t to = x + 4 * y + 16 * z;
    coarse |= (mask >> (2 * x + 8 * y + 32 * z) & 1) << to;
  }
  return coarse << (2 * (brick & 1) + 8 * (brick >> 1 & 1) + 32 * (brick >> 2));
}

// Room for `count` more.
void grow(SvoLevel& level, size_t count) {
  level.normals.resize(level.normals.size() + count);
  level.colors.resize(level.colors.size() + count);
  level.spreads.resize(level.spreads.size() + count);
}

uint32_t size_of(const SvoLevel& level) {
  return static_cast<uint32_t>(level.normals.size());
}

}  // namespace

const CellOrder& cell_order() {
  static const CellOrder order = make_cell_order();
  return order;
}

void append_cell(const CopyVoxels& voxels, uint16_t place, uint16_t material, BlockPart& part) {
  SvoCell cell;
  cell.place = place;
  cell.material = material;
  cell.first_brick = static_cast<uint32_t>(part.bricks.size());
  for (int level = 0; level < 3; ++level) cell.first_voxel[level] = size_of(part.levels[level]);
  SvoLevel& leaves = part.levels[0];
  for (uint32_t brick = 0; brick < 8; ++brick) {
    const uint64_t mask = voxels.masks[brick];
    if (mask == 0) continue;
    cell.bricks = static_cast<uint8_t>(cell.bricks | 1u << brick);
    cell.coarse |= coarse_mask(brick, mask);
    part.bricks.push_back(mask);
    for (uint64_t rest = mask; rest != 0; rest &= rest - 1) {
      const uint32_t code = 64 * brick + static_cast<uint32_t>(std::countr_zero(rest));
      leaves.normals.push_back(voxels.normals[code]);
      leaves.colors.push_back(voxels.colors[code]);
    }
  }
  cell.voxels = static_cast<uint16_t>(size_of(leaves) - cell.first_voxel[0]);
  grow(part.levels[1], static_cast<size_t>(std::popcount(cell.coarse)));
  grow(part.levels[2], static_cast<size_t>(std::popcount(cell.bricks)));
  grow(part.cell_level, 1);
  CellAttributes at{};
  for (int level = 0; level < 4; ++level) {
    SvoLevel& row = level < 3 ? part.levels[level] : part.cell_level;
    const size_t first = level < 3 ? cell.first_voxel[level] : part.cells.size();
    at.normals[level] = row.normals.data() + first;
    at.colors[level] = row.colors.data() + first;
    at.spreads[level] = level == 0 ? nullptr : row.spreads.data() + first;
  }
  part.sums.push_back(filter_cell(cell, &part.bricks[cell.first_brick], at));
  part.cells.push_back(cell);
}

}  // namespace sinew
