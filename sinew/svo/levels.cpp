// Means of attributes. The sums' order is that of the bits, so that they come out the same whoever
// asks for them.
#include "sinew/svo/levels.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/svo/brick.h"

namespace sinew {
namespace {

vec3 sum_of_normals(const uint16_t* normals, uint32_t count) {
  vec3 sum(0.0f);
  for (uint32_t v = 0; v < count; ++v) sum += unit_normal(normals[v]);
  return sum;
}

void set_mean(const AttributeSum& sum, SvoLevel& level, size_t i) {
  const PackedMean mean = mean_of(sum);
  level.normals[i] = mean.normal;
  level.colors[i] = mean.color;
  level.spreads[i] = mean.spread;
}

// The bricks of a cell.
AttributeSum filter_bricks(Svo& svo, size_t brick, size_t voxel, uint32_t bricks) {
  AttributeSum all;
  for (uint32_t i = 0; i < bricks; ++i, ++brick) {
    const auto count = static_cast<uint32_t>(std::popcount(svo.bricks[brick]));
    uint8_t selectors[64] = {};
    for (size_t v = 0; v < count && svo.colors.empty(); ++v) {
      const size_t at = voxel + v;
      selectors[v] = svo.color_selectors[at >> 4] >> (2 * (at & 15)) & 3;
    }
    const uint16_t* const normals = &svo.normals[voxel];
    const AttributeSum sum = svo.colors.empty()
                                 ? sum_of_brick(normals, svo.color_ends[brick], selectors, count)
                                 : sum_of_brick(normals, &svo.colors[voxel], count);
    set_mean(sum, svo.brick_level, brick);
    all.add(sum);
    voxel += count;
  }
  return all;
}

}  // namespace

PackedMean mean_of(const AttributeSum& sum) {
  const float scale = 1.0f / sum.voxels;
  const float spread = std::min(scale * length(sum.normal), 1.0f);
  return {pack_normal(sum.normal), pack_color(scale * sum.color),
          static_cast<uint8_t>(255.0f * spread + 0.5f)};
}

void append_mean(const AttributeSum& sum, SvoLevel& out) {
  const PackedMean mean = mean_of(sum);
  out.normals.push_back(mean.normal);
  out.colors.push_back(mean.color);
  out.spreads.push_back(mean.spread);
}

AttributeSum sum_of_brick(const uint16_t* normals, const uint16_t* colors, uint32_t count) {
  vec3 color(0.0f);
  for (uint32_t v = 0; v < count; ++v) color += unpack_color(colors[v]);
  return {sum_of_normals(normals, count), color, static_cast<float>(count)};
}

AttributeSum sum_of_brick(const uint16_t* normals, SvoColorEnds ends, const uint8_t* selectors,
                          uint32_t count) {
  uint32_t counts[4] = {};
  for (uint32_t v = 0; v < count; ++v) ++counts[selectors[v]];
  vec3 color(0.0f);
  for (uint32_t s = 0; s < 4; ++s) {
    if (counts[s] > 0) color += static_cast<float>(counts[s]) * selected_color(ends, s);
  }
  return {sum_of_normals(normals, count), color, static_cast<float>(count)};
}

namespace {

// Calls with each cell of the block and the sum over it, once its bricks' means are set.
template <class F>
void for_each_filtered(Svo& svo, uint32_t block, const F& call) {
  const SvoBlock& b = svo.blocks[block];
  for (uint32_t c = b.first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    const SvoCell& cell = svo.cells[c];
    const AttributeSum sum = filter_bricks(svo, size_t{b.first_brick} + cell.first_brick,
                                           size_t{b.first_voxel} + cell.first_voxel,
                                           static_cast<uint32_t>(std::popcount(cell.bricks)));
    call(c, sum);
  }
}

}  // namespace

void filter_levels(Svo& svo, uint32_t block) {
  for_each_filtered(svo, block, [&](uint32_t cell, const AttributeSum& sum) {
    set_mean(sum, svo.cell_level, cell);
  });
}

void filter_brick_level(Svo& svo, uint32_t block) {
  for_each_filtered(svo, block, [](uint32_t, const AttributeSum&) {});
}

}  // namespace sinew
