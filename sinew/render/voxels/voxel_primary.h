// Which voxel objects the rasteriser draws, and which camera rays find: an estimate from boxes and
// counts alone, so that it costs next to nothing and is the same on every machine.
#pragma once

#include <cstdint>

#include "sinew/render/voxels/voxel_settings.h"
#include "sinew/svo/draw/visibility.h"

namespace sinew {

// What one object's part of a picture is likely to cost, on one core.
struct PrimaryCosts {
  double raster_us = 0.0;
  double trace_us = 0.0;
};

// `view` is one pass over the picture.
PrimaryCosts estimate_primary(const VoxelInstance& object, const RasterView& view,
                              const VoxelSettings& settings);

// Whether rays find the object. Without `rays`, nothing else of the picture needs them, and shading
// voxels by tiles is worth more than what rays could save.
bool is_traced(const VoxelInstance& object, const RasterView& view, const VoxelSettings& settings,
               bool rays);

}  // namespace sinew
