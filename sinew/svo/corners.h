// Corners of the skin lattice as numbers that a Motion takes: the one place where they are decoded,
// so that what poses them and what bounds them agree bit for bit.
#pragma once

#include <array>
#include <cstdint>

#include "sinew/svo/format.h"

namespace sinew {

inline constexpr uint32_t kCornerSide = kBlockSide / kCellSide + 1;  // corners of a block
inline constexpr uint32_t kCornerPlaces = kCornerSide * kCornerSide * kCornerSide;

struct CornerPlaces {
  std::array<std::array<uint8_t, 4>, kCornerPlaces> at;  // x, y, z, 0
};
inline constexpr CornerPlaces make_corner_places() {
  CornerPlaces places{};
  for (uint32_t i = 0; i < kCornerPlaces; ++i) {
    places.at[i] = {static_cast<uint8_t>(i % kCornerSide),
                    static_cast<uint8_t>(i / kCornerSide % kCornerSide),
                    static_cast<uint8_t>(i / (kCornerSide * kCornerSide)), 0};
  }
  return places;
}
inline constexpr CornerPlaces kCornerPlaceTable = make_corner_places();

// Where lattice corner (x, y, z), counted over the whole grid, is at rest. The corners that blocks
// have in common come out the same from each.
inline vec3 corner_rest(const VoxelGrid& grid, uvec3 corner) {
  return grid.origin + (static_cast<float>(kCellSide) * grid.voxel) * vec3(corner);
}
inline vec3 corner_rest(const VoxelGrid& grid, const SvoBlock& block, uint16_t place) {
  const auto& p = kCornerPlaceTable.at[place];
  return corner_rest(grid, uvec3(8u * block.x + p[0], 8u * block.y + p[1], 8u * block.z + p[2]));
}

inline float corner_weight(uint16_t stored) {
  return static_cast<float>(stored) * (1.0f / 65535.0f);
}

inline vec3 corner_delta(float unit, const std::array<int16_t, 3>& stored) {
  return unit * vec3(stored[0], stored[1], stored[2]);
}

}  // namespace sinew
