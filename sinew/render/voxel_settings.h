// How voxels are drawn.
#pragma once

#include <cstdint>

namespace sinew {

struct VoxelSettings {
  uint32_t shadow_map = 1024;  // pixels a side of a light's shadow map, 16..16384
  float lod = 1.0f;  // pixels: no voxel that is drawn is smaller, if a coarser level can be had; 0:
                     // always the finest

  bool operator==(const VoxelSettings&) const = default;
};

}  // namespace sinew
