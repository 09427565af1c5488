// Voxels whose corners are skinned, one by one: what the thesis says would close its holes, and
// would be too expensive. The slow twin of the skin lattice (posed.h), which moves corners of
// cells. Based on: D. Bautembach, "Animated Sparse Voxel Octrees", Hamburg 2011, section 8.1.3:
// "all eight corners would get transformed and the new voxel would be defined as the axis-aligned
// bounding box of those eight points". Differs: a corner that voxels share is moved once; the box
// is that of the projections; voxels only, no levels of detail.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/thesis/thesis_voxels.h"

namespace sinew {

struct CornerVoxels {
  VoxelGrid grid;
  uint32_t joints = 0;                // that a pose must have; 0: not skinned
  std::vector<ThesisVoxel> voxels{};  // in Morton order; their own weights are not used
  std::vector<std::array<uint32_t, 8>>
      corner{};                       // of each voxel; bit 0 of the index is x, 1 y, 2 z
  std::vector<vec3> rest{};           // of each corner
  std::vector<ThesisWeights> skin{};  // of each corner: mean of the voxels around it

  size_t bytes() const;
};
CornerVoxels make_corner_voxels(const VoxelGrid& grid, std::vector<ThesisVoxel> voxels,
                                uint32_t joints);

struct CornerScratch {
  std::vector<vec4> projected;  // pixels x and y, depth, and 1 if it is seen, else 0
};

struct CornerInstance {
  const CornerVoxels* voxels = nullptr;
  std::span<const Affine> joints;  // as many as the voxels say
  Affine placement = identity_affine();
  uint32_t first_unit = 0;  // a unit of keys stands for 1024 voxels
};
inline uint32_t unit_count(const CornerVoxels& voxels) {
  return static_cast<uint32_t>((voxels.voxels.size() + 1023) / 1024);
}

// Covers, for every voxel, each pixel whose centre lies in the box of its eight projected corners.
// Returns how many voxels were drawn.
uint64_t rasterize_corners(std::span<const CornerInstance> instances, const RasterView& view,
                           CornerScratch& scratch, Visibility& out);

// What a key of rasterize_corners names. Normals stay as they rest.
VoxelSample sample_corners(std::span<const CornerInstance> instances, VisibilityKey key);

}  // namespace sinew
