// Tiles of a picture that are shaded at once, and the voxels that they show.
#pragma once

#include <algorithm>
#include <cstdint>

#include "sinew/render/voxels/voxel_batch.h"
#include "sinew/svo/draw/visibility.h"

namespace sinew {

inline constexpr uint32_t kTileWidth = 32, kTileHeight = 16;  // pixels; winners fit a batch
static_assert(kTileWidth * kTileHeight <= kMostWinners);
inline constexpr uint16_t kBackground = 0xffff;

// The voxels in a tile, each once, and which of them each pixel shows.
struct TileWinners {
  uint32_t count = 0;
  VisibilityKey keys[kMostWinners];
  uint16_t index[kTileHeight][kTileWidth];
};

struct Tile {
  uint32_t left, top, width, height;
};

inline void list_winners(const Visibility& visibility, const Tile& tile, TileWinners& out) {
  out.count = 0;
  uint64_t above[kTileWidth];
  std::fill_n(above, kTileWidth, ~uint64_t{0});
  for (uint32_t y = 0; y < tile.height; ++y) {
    const VisibilityKey* const row =
        &visibility.keys[size_t{tile.top + y} * visibility.width + tile.left];
    uint64_t before = ~uint64_t{0};
    for (uint32_t x = 0; x < tile.width; ++x) {
      const uint64_t name = row[x] == kNothing ? ~uint64_t{0} : key_name(row[x]);
      uint16_t& index = out.index[y][x];
      if (row[x] == kNothing) {
        index = kBackground;
      } else if (name == before) {
        index = out.index[y][x - 1];
      } else if (name == above[x]) {
        index = out.index[y - 1][x];
      } else {
        index = static_cast<uint16_t>(out.count);
        out.keys[out.count++] = row[x];
      }
      before = above[x] = name;
    }
  }
}

inline uint32_t tile_columns(const Visibility& visibility) {
  return (visibility.width + kTileWidth - 1) / kTileWidth;
}
inline size_t shading_tiles(const Visibility& visibility) {
  return size_t{tile_columns(visibility)} * ((visibility.height + kTileHeight - 1) / kTileHeight);
}
inline Tile shading_tile(const Visibility& visibility, size_t index) {
  const uint32_t columns = tile_columns(visibility);
  const uint32_t left = static_cast<uint32_t>(index % columns) * kTileWidth;
  const uint32_t top = static_cast<uint32_t>(index / columns) * kTileHeight;
  return {left, top, std::min(kTileWidth, visibility.width - left),
          std::min(kTileHeight, visibility.height - top)};
}

}  // namespace sinew
