// Writes cells: topology, attributes, and the means over their voxels at levels 1 to 3.
#include "sinew/svo/make/block_part.h"

#include <bit>

#include "sinew/svo/brick.h"

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

// One brick: returns the sum over its voxels.
AttributeSum append_brick(const CopyVoxels& voxels, uint32_t brick, BlockPart& part) {
  uint16_t normals[64], colors[64];
  uint8_t selectors[64];
  uint32_t count = 0;
  for (uint64_t rest = voxels.masks[brick]; rest != 0; rest &= rest - 1) {
    const uint32_t code = 64 * brick + static_cast<uint32_t>(std::countr_zero(rest));
    normals[count] = voxels.normals[code];
    colors[count++] = voxels.colors[code];
  }
  part.bricks.push_back(voxels.masks[brick]);
  part.normals.insert(part.normals.end(), normals, normals + count);
  AttributeSum sum;
  if (part.exact_colors) {
    part.colors.insert(part.colors.end(), colors, colors + count);
    sum = sum_of_brick(normals, colors, count);
  } else {
    SvoColorEnds ends;
    fit_colors(colors, count, ends, selectors);
    part.color_ends.push_back(ends);
    part.selectors.insert(part.selectors.end(), selectors, selectors + count);
    sum = sum_of_brick(normals, ends, selectors, count);
  }
  append_mean(sum, part.brick_level);
  return sum;
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
  cell.first_voxel = static_cast<uint32_t>(part.normals.size());
  AttributeSum sum;
  for (uint32_t brick = 0; brick < 8; ++brick) {
    if (voxels.masks[brick] == 0) continue;
    cell.bricks = static_cast<uint8_t>(cell.bricks | 1u << brick);
    sum.add(append_brick(voxels, brick, part));
  }
  cell.voxels = static_cast<uint16_t>(part.normals.size() - cell.first_voxel);
  append_mean(sum, part.cell_level);
  part.sums.push_back(sum);
  part.cells.push_back(cell);
}

}  // namespace sinew
