// Makes octrees: from a voxelised surface with the motion of its triangles, or from plain voxels.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/base/error.h"
#include "sinew/motion/motion.h"
#include "sinew/svo/format.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {

// What the fragments' triangles are.
struct SvoSource {
  std::span<const uvec3> triangles;
  std::span<const uint16_t> materials;  // one a triangle
  Motion motion;                        // rigid, skin or morph; others are taken at rest
};

// Cells with a copy for every sheet and material, the skin lattice, filtered levels. In parallel,
// the same bits for any number of threads. An error if there are no voxels, or too many for the
// format.
Result<Svo> make_svo(const VoxelSurface& surface, const SvoSource& source);

// A voxel that belongs to no triangle.
struct PlainVoxel {
  VoxelMorton voxel = 0;
  uint16_t normal = 0;
  uint16_t color = 0;
  uint16_t material = 0;
};

// A rigid octree with one sheet. `voxels` are sorted, each place once.
Result<Svo> make_svo(const VoxelGrid& grid, std::span<const PlainVoxel> voxels);

}  // namespace sinew
