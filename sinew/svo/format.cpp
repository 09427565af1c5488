// The small arithmetic of octrees: packed attributes, and where they stand.
#include "sinew/svo/format.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

uint32_t Svo::first_block_node() const {
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [](const SvoNode& node) { return node.level == kBlockLevel; });
  return static_cast<uint32_t>(found - nodes.begin());
}

size_t Svo::bytes() const {
  size_t sum = bytes_of(nodes) + bytes_of(blocks) + bytes_of(cells) + bytes_of(bricks);
  for (const SvoLevel& level : levels) sum += bytes_of(level);
  sum += bytes_of(cell_level) + bytes_of(node_level);
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

uint32_t voxel_index(const Svo& svo, const SvoBlock& block, const SvoCell& cell, VoxelCode code) {
  const uint32_t level = level_of(code), local = code - kFirstCode[level];
  const uint32_t first = block.first_voxel[level] + cell.first_voxel[level];
  const auto before = [](uint64_t mask, uint32_t bit) {
    return static_cast<uint32_t>(std::popcount(mask & ((uint64_t{1} << bit) - 1)));
  };
  if (level == 1) return first + before(cell.coarse, local);
  if (level == 2) return first + before(cell.bricks, local);
  const uint32_t bricks = before(cell.bricks, local >> 6);
  const uint64_t* const masks = &svo.bricks[block.first_brick + cell.first_brick];
  uint32_t index = first + before(masks[bricks], local & 63);
  for (uint32_t i = 0; i < bricks; ++i) index += static_cast<uint32_t>(std::popcount(masks[i]));
  return index;
}

}  // namespace sinew
