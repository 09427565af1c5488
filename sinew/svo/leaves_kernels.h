// Boxes of a cell's voxels in a pose.
#pragma once

#include <cstdint>

#include "sinew/bvh/wide.h"
#include "sinew/svo/format.h"

namespace sinew {

// Corners of a cell, relative to its first one: so rounding is that of the cell's size. Rows of
// x, y, z and nothing.
struct alignas(16) CellCorners {
  float base[4];
  float at[8][4];
  float pad[4];  // more than the rounding of a point's image
};
CellCorners cell_corners(const SvoCell& cell, const vec3* positions);

// The cell's box, and the longest of its edges.
struct CellBox {
  Box box;
  float longest = 0.0f;
};
CellBox cell_box(const CellCorners& corners);

// The first packet of boxes is at `packets`; returns how many boxes there are. `bricks` are the
// cell's own; level is 0 to 2.
uint32_t box_voxels(const CellCorners& corners, const SvoCell& cell, const uint64_t* bricks,
                    uint32_t level, uint32_t first_primitive, Node8* packets);

}  // namespace sinew
