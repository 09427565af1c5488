// The kernels of the rasteriser: corners and cells of a block, and a tile.
#pragma once

#include <cstdint>

#include "sinew/svo/draw/rasterize_view.h"

namespace sinew {

// Projects the block's corners, and lists its cells that are in the view.
struct BlockJob {
  const ClipMap* map = nullptr;
  const RasterSettings* settings = nullptr;
  uint32_t width = 0, height = 0;   // of the view
  uint32_t node = 0;                // of the block, in Svo::nodes
  const vec3* positions = nullptr;  // of the block's corners
  uint32_t corners = 0;
  ClipPoint* points = nullptr;  // out, one a corner
  ClipPoint* screen = nullptr;  // scratch, the same size
  RasterCell* cells = nullptr;  // out, at most one a cell
};

// Sets `block.cells`, `block.voxel` and `block.reach`. `index` is the block's among RasterBlocks.
void view_block(const BlockJob& job, uint32_t index, RasterBlock& block);

struct TileCounts {
  uint64_t cells_hidden = 0, voxels = 0, leaves = 0, nodes = 0;
};

struct SkinnedTable;

struct TileJob {
  const RasterSettings* settings = nullptr;
  const RasterBlock* blocks = nullptr;
  const ClipPoint* points = nullptr;
  const RasterCell* cells = nullptr;
  const uint32_t* list = nullptr;  // of cells that may cover pixels of the tile
  uint32_t count = 0;
  uint32_t* order = nullptr;  // scratch, `count` entries
  uint32_t* units = nullptr;  // scratch, one entry more
  uint8_t* marks = nullptr;   // the same
  float near = 0.0f;
  bool perspective = true;
  uint32_t x = 0, y = 0, width = 0, height = 0;  // pixels of the tile
  const uint64_t* seen_before = nullptr;         // a bit a unit: in the last frame
  uint64_t* seen_now = nullptr;                  // written by all tiles at once
  VisibilityKey* keys = nullptr;                 // the tile's first, or
  float* depth = nullptr;
  float* front = nullptr;      // with `keys`: their depths, at full precision. Then the tile, and
  bool adds = false;           // ... without keys `depth`, is drawn on top of what they hold
  uint32_t stride = 0;         // pixels from one row to the next
  uint8_t* touched = nullptr;  // of RasterBlocks: set for those that show something finer
                               // than cells, or would if it were there; may be null
  const SkinnedTable* skinned = nullptr;  // then voxels are placed so (thesis_skinned.h)
};

// Sorts the entries [0, first) and [second, count) of the job's order by depth, then place.
void sort_front_to_back(const TileJob& job, uint32_t first, uint32_t second);

// Draws the tile. Allocates nothing.
TileCounts draw_tile(const TileJob& job);

}  // namespace sinew
