// What voxelising triangles gives before it is an octree: which triangles lie in which voxels, and
// how the surface looks there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/svo/format.h"

namespace sinew {

// Bits of x, y, z interleaved, x lowest; 12 bits each. So v >> 9 is the cell, v >> 18 the block.
using VoxelMorton = uint64_t;
VoxelMorton morton_of(uvec3 voxel);
uvec3 voxel_of(VoxelMorton morton);

inline constexpr uint32_t kInside = 0xffffffffu;  // instead of a triangle: a voxel of solid filling

// One triangle in one voxel.
struct VoxelFragment {
  VoxelMorton voxel = 0;
  uint32_t triangle = 0;  // or kInside
  uint16_t normal = 0;    // of the triangle's point nearest to the voxel's centre
  uint16_t color = 0;
};
static_assert(sizeof(VoxelFragment) == 16);

// The surface of one object, in its space at rest. `fragments` are sorted by (voxel, triangle),
// each pair once. Triangles of zero area, or with vertices that are not finite, have none.
struct VoxelSurface {
  VoxelGrid grid;
  std::vector<VoxelFragment> fragments;
  uint64_t voxels = 0;  // different ones
};

}  // namespace sinew
