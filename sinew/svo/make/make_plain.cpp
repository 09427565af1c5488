// Octrees of plain voxels: one sheet, so that the copies of a cell, one for each material, share
// all corners. Colours are kept as they are: they may be all that such voxels have.
#include <algorithm>

#include "sinew/base/parallel.h"
#include "sinew/svo/make/block_part.h"
#include "sinew/svo/make/block_ranges.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {
namespace {

// Numbers the corners of a block as they are met.
class PlainCorners {
 public:
  PlainCorners() { std::ranges::fill(index_, kNone); }

  uint16_t at(uvec3 place, BlockPart& part) {
    const uint32_t key = place.x + 9 * place.y + 81 * place.z;
    if (index_[key] == kNone) {
      index_[key] = static_cast<uint16_t>(part.corners.size());
      part.corners.push_back({static_cast<uint16_t>(key)});
    }
    return index_[key];
  }

 private:
  static constexpr uint16_t kNone = 0xffff;
  uint16_t index_[729];
};

// The voxels of one cell, which are not empty.
void append_cells(std::span<const PlainVoxel> voxels, PlainCorners& corners, BlockPart& part) {
  const CellOrder& order = cell_order();
  const uint32_t cell = voxels.front().voxel >> 9 & 511;
  const uvec3 place = voxel_of(cell);
  uint16_t corner[8];
  for (uint32_t k = 0; k < 8; ++k) {
    corner[k] = corners.at(place + uvec3(k & 1, k >> 1 & 1, k >> 2), part);
  }
  std::vector<uint16_t> materials;
  for (const PlainVoxel& v : voxels) {
    if (materials.empty() || materials.back() != v.material) materials.push_back(v.material);
  }
  std::ranges::sort(materials);
  materials.erase(std::unique(materials.begin(), materials.end()), materials.end());
  for (const uint16_t material : materials) {
    CopyVoxels copy;
    for (const PlainVoxel& v : voxels) {
      if (v.material == material) copy.set(order.code[v.voxel & 511], v.normal, v.color);
    }
    append_cell(copy, order.place[cell], material, part);
    std::ranges::copy(corner, part.cells.back().corner);
  }
}

BlockPart make_part(std::span<const PlainVoxel> voxels) {
  BlockPart part;
  part.exact_colors = true;
  part.morton = voxels.front().voxel >> 18;
  PlainCorners corners;
  while (!voxels.empty()) {
    const size_t count = count_of_first(voxels, 9);
    append_cells(voxels.first(count), corners, part);
    voxels = voxels.subspan(count);
  }
  return part;
}

}  // namespace

Result<Svo> make_svo(const VoxelGrid& grid, std::span<const PlainVoxel> voxels) {
  SINEW_CHECKED(check_grid(grid));
  SINEW_CHECKED(check_voxels(grid, voxels, true));
  const std::vector<size_t> first = first_of_blocks(voxels);
  std::vector<BlockPart> parts(first.size() - 1);
  parallel_for(parts.size(), 1, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) {
      parts[b] = make_part(voxels.subspan(first[b], first[b + 1] - first[b]));
    }
  });
  SvoFrame frame;
  frame.grid = grid;
  return join_parts(frame, parts);
}

}  // namespace sinew
