// The small arithmetic of octrees: packed attributes, and where they stand.
#include "sinew/svo/format.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/svo/brick.h"

namespace sinew {
namespace {

template <class T>
size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

size_t bytes_of(const SvoLevel& level) {
  return bytes_of(level.normals) + bytes_of(level.colors) + bytes_of(level.spreads);
}

float sign_of(float x) {
  return x < 0.0f ? -1.0f : 1.0f;
}

uint32_t quantize(float unit, uint32_t steps) {
  return static_cast<uint32_t>(std::clamp(unit, 0.0f, 1.0f) * static_cast<float>(steps) + 0.5f);
}

// Means over the voxels of a voxel of level 1.
VoxelAttributes coarse_attributes(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
                                  uint32_t bit) {
  const uint32_t brick = brick_above(bit), first = first_below(bit);
  const int rank = std::popcount(cell.bricks & ((1u << brick) - 1));
  const uint64_t mask = svo.bricks[block.first_brick + cell.first_brick + rank];
  VoxelAttributes sum;
  float count = 0.0f;
  for (uint64_t rest = mask & kEight << first; rest != 0; rest &= rest - 1) {
    const uint32_t code = 64 * brick + static_cast<uint32_t>(std::countr_zero(rest));
    const VoxelIndex at = voxel_index(svo, block, cell, code);
    sum.normal += unpack_normal(svo.normals[at.voxel]);
    sum.color += voxel_color(svo, at);
    count += 1.0f;
  }
  const float size = length(sum.normal);
  const vec3 normal = size > 0.0f ? sum.normal / size : vec3(0.0f, 0.0f, 1.0f);
  return {normal, sum.color / count, mean_length(size, count)};
}

}  // namespace

PagedSvoPtr::PagedSvoPtr(const PagedSvoPtr& other) {
  SINEW_CHECK(!other);
}
PagedSvoPtr& PagedSvoPtr::operator=(const PagedSvoPtr& other) {
  SINEW_CHECK(!other);
  pages_.reset();
  return *this;
}

uint32_t Svo::first_block_node() const {
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [](const SvoNode& node) { return node.level == kBlockLevel; });
  return static_cast<uint32_t>(found - nodes.begin());
}

size_t Svo::bytes() const {
  size_t sum = bytes_of(nodes) + bytes_of(blocks) + bytes_of(cells) + bytes_of(bricks);
  sum += bytes_of(normals) + bytes_of(colors) + bytes_of(color_ends) + bytes_of(color_selectors);
  sum += bytes_of(brick_level) + bytes_of(cell_level) + bytes_of(node_level);
  sum += bytes_of(corner_places) + bytes_of(corner_joints) + bytes_of(corner_weights);
  return sum + bytes_of(joint_palette) + bytes_of(targets) + bytes_of(deltas);
}

uint16_t pack_normal(vec3 d) {
  const float sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  if (!(sum > 0.0f)) return pack_normal(vec3(0.0f, 0.0f, 1.0f));
  vec2 p = vec2(d.x, d.y) / sum;
  if (d.z < 0.0f) {
    p = vec2((1.0f - std::abs(p.y)) * sign_of(p.x), (1.0f - std::abs(p.x)) * sign_of(p.y));
  }
  return static_cast<uint16_t>(quantize(0.5f * p.x + 0.5f, 254) | quantize(0.5f * p.y + 0.5f, 254)
                                                                      << 8);
}

vec3 unpack_normal(uint16_t packed) {
  const vec2 p =
      vec2(static_cast<float>(packed & 255), static_cast<float>(packed >> 8)) / 127.0f - 1.0f;
  vec3 d(p, 1.0f - std::abs(p.x) - std::abs(p.y));
  if (d.z < 0.0f) {
    d = vec3((1.0f - std::abs(p.y)) * sign_of(p.x), (1.0f - std::abs(p.x)) * sign_of(p.y), d.z);
  }
  return normalize(d);
}

uint16_t pack_color(vec3 linear) {
  const vec3 c = glm::sqrt(glm::max(linear, vec3(0.0f)));
  return static_cast<uint16_t>(quantize(c.x, 31) << 11 | quantize(c.y, 63) << 5 |
                               quantize(c.z, 31));
}

vec3 unpack_color(uint16_t packed) {
  const vec3 c(static_cast<float>(packed >> 11) / 31.0f,
               static_cast<float>(packed >> 5 & 63) / 63.0f,
               static_cast<float>(packed & 31) / 31.0f);
  return c * c;
}

uint64_t coarse_voxels(const SvoCell& cell, const uint64_t* bricks) {
  uint64_t coarse = 0;
  for (uint32_t present = cell.bricks; present != 0; present &= present - 1) {
    const uint32_t brick = static_cast<uint32_t>(std::countr_zero(present));
    coarse |= coarse_of_brick(*bricks++) << coarse_shift(brick);
  }
  return coarse;
}

VoxelIndex voxel_index(const Svo& svo, const SvoBlock& block, const SvoCell& cell, VoxelCode code) {
  const auto before = [](uint64_t mask, uint32_t bit) {
    return static_cast<uint32_t>(std::popcount(mask & ((uint64_t{1} << bit) - 1)));
  };
  const uint32_t bricks = before(cell.bricks, code >> 6);
  const uint32_t first = block.first_brick + cell.first_brick;
  const uint64_t* const masks = &svo.bricks[first];
  uint32_t index = block.first_voxel + cell.first_voxel + before(masks[bricks], code & 63);
  for (uint32_t i = 0; i < bricks; ++i) index += static_cast<uint32_t>(std::popcount(masks[i]));
  return {index, first + bricks};
}

vec3 voxel_color(const Svo& svo, VoxelIndex at) {
  if (!svo.colors.empty()) return unpack_color(svo.colors[at.voxel]);
  const uint32_t selector = svo.color_selectors[at.voxel >> 4] >> (2 * (at.voxel & 15)) & 3;
  return selected_color(svo.color_ends[at.brick], selector);
}

VoxelAttributes level_attributes(const SvoLevel& level, size_t index) {
  return {unpack_normal(level.normals[index]), unpack_color(level.colors[index]),
          static_cast<float>(level.spreads[index]) / 255.0f};
}

VoxelAttributes voxel_attributes(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
                                 VoxelCode code) {
  const uint32_t level = level_of(code);
  if (level == 3)
    return level_attributes(svo.cell_level, static_cast<size_t>(&cell - svo.cells.data()));
  if (level == 2) {
    const uint32_t below = (1u << (code - kFirstCode[2])) - 1;
    const int rank = std::popcount(cell.bricks & below);
    return level_attributes(svo.brick_level, block.first_brick + cell.first_brick + rank);
  }
  if (level == 0) {
    const VoxelIndex at = voxel_index(svo, block, cell, code);
    return {unpack_normal(svo.normals[at.voxel]), voxel_color(svo, at), 1.0f};
  }
  return coarse_attributes(svo, block, cell, code - kFirstCode[1]);
}

}  // namespace sinew
