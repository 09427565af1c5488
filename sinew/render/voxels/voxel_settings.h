// How voxels are drawn, and what that took.
#pragma once

#include <cstdint>

#include "sinew/svo/draw/rasterize.h"

namespace sinew {

// What moves voxels: the skin lattice; or, as opponents (svo/thesis/thesis.h,
// svo/thesis/thesis_corners.h), joints of every voxel, or of every corner of every voxel. Shadow
// maps are the lattice's.
enum class VoxelSkinning : uint8_t { lattice, thesis, corners };

// How it is found which voxel a pixel shows: by the rasteriser, by rays, or for each object by what
// is likely to be cheaper. Opponents are always rasterised.
enum class VoxelPrimary : uint8_t { automatic, raster, trace };

// Where shadows of voxels come from: from maps, or from rays. `automatic`: from maps where nothing
// else of the picture needs rays, and where time is limited.
enum class VoxelShadowing : uint8_t { automatic, maps, rays };

struct VoxelSettings {
  VoxelSkinning skinning = VoxelSkinning::lattice;
  VoxelPrimary primary = VoxelPrimary::automatic;
  VoxelShadowing shadowing = VoxelShadowing::automatic;
  uint32_t shadow_map = 1024;  // pixels a side of a light's shadow map, 16..16384
  float lod = 0.75f;  // pixels: no voxel that is drawn is smaller, if a coarser level can be had;
                      // 0: always the finest

  bool operator==(const VoxelSettings&) const = default;
};

struct VoxelStats {
  uint32_t objects = 0;      // present
  uint32_t traced = 0;       // of these: found by camera rays; the rest by the rasteriser
  bool shadow_maps = false;  // were drawn; else rays find shadows, if any
  uint32_t passes = 0;       // over the picture
  RasterStats camera;        // of the last pass
  RasterStats shadows;       // of all maps
  double pose_ms = 0.0;      // objects to their poses; blocks are posed while they are drawn
  double shadow_ms = 0.0;
  double draw_ms = 0.0;   // of all passes
  double shade_ms = 0.0;  // of passes that shade_pass() shades
};

}  // namespace sinew
