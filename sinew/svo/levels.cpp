// Means of attributes. The sums' order is that of the bits, so that they come out the same whoever
// asks for them.
#include "sinew/svo/levels.h"

#include <algorithm>
#include <bit>

namespace sinew {
namespace {

// The bit of SvoCell::coarse above bit `bit` of brick `brick`.
uint32_t coarse_bit(uint32_t brick, uint32_t bit) {
  const uint32_t x = 2 * (brick & 1) + (bit >> 1 & 1);
  const uint32_t y = 2 * (brick >> 1 & 1) + (bit >> 3 & 1);
  const uint32_t z = 2 * (brick >> 2) + (bit >> 5);
  return x + 4 * y + 16 * z;
}
// The brick that holds a bit of SvoCell::coarse.
uint32_t brick_of(uint32_t bit) {
  return (bit >> 1 & 1) + (bit >> 2 & 2) + (bit >> 3 & 4);
}

// Calls take(bit) for each set bit, rising.
template <class Take>
void for_each_bit(uint64_t mask, const Take& take) {
  for (; mask != 0; mask &= mask - 1) take(static_cast<uint32_t>(std::countr_zero(mask)));
}

}  // namespace

PackedMean mean_of(const AttributeSum& sum) {
  const float scale = 1.0f / sum.voxels;
  const float spread = std::min(scale * length(sum.normal), 1.0f);
  return {pack_normal(sum.normal), pack_color(scale * sum.color),
          static_cast<uint8_t>(255.0f * spread + 0.5f)};
}

AttributeSum filter_cell(const SvoCell& cell, const uint64_t* bricks, const CellAttributes& at) {
  AttributeSum coarse[64], brick_sums[8], all;
  uint32_t voxel = 0, written[3] = {};
  for_each_bit(cell.bricks, [&](uint32_t brick) {
    for_each_bit(*bricks++, [&](uint32_t bit) {
      coarse[coarse_bit(brick, bit)].add(
          {unpack_normal(at.normals[0][voxel]), unpack_color(at.colors[0][voxel]), 1.0f});
      ++voxel;
    });
  });
  const auto write = [&](int level, const AttributeSum& sum) {
    const PackedMean mean = mean_of(sum);
    const uint32_t i = written[level - 1]++;
    at.normals[level][i] = mean.normal;
    at.colors[level][i] = mean.color;
    at.spreads[level][i] = mean.spread;
  };
  for_each_bit(cell.coarse, [&](uint32_t bit) {
    write(1, coarse[bit]);
    brick_sums[brick_of(bit)].add(coarse[bit]);
  });
  for_each_bit(cell.bricks, [&](uint32_t brick) {
    write(2, brick_sums[brick]);
    all.add(brick_sums[brick]);
  });
  write(3, all);
  return all;
}

void filter_levels(Svo& svo, uint32_t block) {
  const SvoBlock& b = svo.blocks[block];
  for (uint32_t c = b.first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    const SvoCell& cell = svo.cells[c];
    CellAttributes at{};
    for (int level = 0; level < 3; ++level) {
      const size_t first = size_t{b.first_voxel[level]} + cell.first_voxel[level];
      at.normals[level] = svo.levels[level].normals.data() + first;
      at.colors[level] = svo.levels[level].colors.data() + first;
      at.spreads[level] = svo.levels[level].spreads.data() + (level > 0 ? first : 0);
    }
    at.normals[3] = &svo.cell_level.normals[c];
    at.colors[3] = &svo.cell_level.colors[c];
    at.spreads[3] = &svo.cell_level.spreads[c];
    filter_cell(cell, &svo.bricks[b.first_brick + cell.first_brick], at);
  }
}

}  // namespace sinew
