// Which voxels of a block a triangle lies in. Internal to the voxeliser.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sinew/svo/make/voxelize.h"

namespace sinew {

// Coordinates in voxels, relative to the block's first voxel.
struct GridTriangle {
  glm::dvec3 vertex[3];
};

// A voxel of a block: x + 64 y + 4096 z.
using BlockPlace = uint32_t;

// What a triangle can have in a block: four voxels in each column, and room for a vector.
inline constexpr size_t kMostPlaces = 4 * 64 * 64 + 64;

// Writes the voxels from (0, 0, 0) to `last` (63 at most) that the shell of the triangle has, each
// once, to `out`, which has room for kMostPlaces; gives how many they are. Exact but for the
// rounding of double; exact altogether where products of coordinates are.
//
// conservative: triangle and closed cube have a point in common.
// thin: the cube touches the triangle's box; seen along each axis, no edge has the cube's
// octahedron
//   (the middles of its faces) wholly on its outer side; and the plane passes through the voxel's
//   centre line along the axis where the normal is longest (of equals, the last), which is half
//   open.
size_t mark_triangle(const GridTriangle& triangle, Shell shell, uvec3 last, BlockPlace* out);

}  // namespace sinew
