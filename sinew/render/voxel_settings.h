// How voxels are drawn.
#pragma once

#include <cstdint>

namespace sinew {

// What moves voxels: the skin lattice; or, as opponents (svo/thesis.h, svo/thesis_corners.h),
// joints of every voxel, or of every corner of every voxel. Shadow maps are the lattice's.
enum class VoxelSkinning : uint8_t { lattice, thesis, corners };

struct VoxelSettings {
  VoxelSkinning skinning = VoxelSkinning::lattice;
  uint32_t shadow_map = 1024;  // pixels a side of a light's shadow map, 16..16384
  float lod = 1.0f;  // pixels: no voxel that is drawn is smaller, if a coarser level can be had; 0:
                     // always the finest

  bool operator==(const VoxelSettings&) const = default;
};

}  // namespace sinew
