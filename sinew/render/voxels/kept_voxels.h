// What shading needs of the voxels that a picture in parts shows: the detail of the octrees that
// they are from may be gone when it is shaded. 56 bytes a voxel and tile, at most a voxel a pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/render/voxels/voxel_batch.h"

namespace sinew {

class KeptVoxels {
 public:
  void clear();
  // Fetches what wins pixels now and has not been fetched before, and forgets what wins none. All
  // that is new must be there.
  void keep(std::span<const VoxelInstance> instances, const Visibility& visibility);
  // What fetch_voxels() gave for these keys, which must all be of this tile (voxel_tiles.h).
  void fetch(size_t tile, std::span<const VisibilityKey> keys, VoxelBatch& out) const;

 private:
  struct Voxel {
    uint64_t name = 0;  // see key_name()
    float place[4] = {}, normal[4] = {}, color[3] = {};
    uint32_t material = 0;
  };
  struct Scratch;
  static Voxel voxel_of(uint64_t name, const VoxelBatch& batch, uint32_t i);
  static void keep_tile(std::span<const VoxelInstance> instances, Scratch& scratch,
                        std::vector<Voxel>& voxels);

  std::vector<std::vector<Voxel>> tiles_;  // each by name
};

}  // namespace sinew
