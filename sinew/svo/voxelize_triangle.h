// Which voxels of a block a triangle lies in. Internal to the voxeliser.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/svo/voxelize.h"

namespace sinew {

// Coordinates in voxels, relative to the block's first voxel.
struct GridTriangle {
  glm::dvec3 vertex[3];
};

// A voxel of a block: x + 64 y + 4096 z.
using BlockPlace = uint32_t;

// Appends the voxels from (0, 0, 0) to `last` (63 at most) that the shell of the triangle has, each
// once. The triangle must have an area. Exact but for the rounding of double; exact altogether
// where products of coordinates are.
//
// conservative: triangle and closed cube have a point in common.
// thin: the cube touches the triangle's box; seen along each axis, no edge has the cube's
// octahedron
//   (the middles of its faces) wholly on its outer side; and the plane passes through the voxel's
//   centre line along the axis where the normal is longest (of equals, the last), which is half
//   open.
void mark_triangle(const GridTriangle& triangle, Shell shell, uvec3 last,
                   std::vector<BlockPlace>& out);

}  // namespace sinew
