// Deferred shading of voxels: the light of a batch at once, in SIMD. What it computes is what
// shade.h does for the surfaces of resolve_voxel(), but for rounding.
#pragma once

#include <span>

#include "sinew/render/voxels/voxel_batch.h"
#include "sinew/render/voxels/voxel_material.h"
#include "sinew/render/voxels/voxel_shadows.h"

namespace sinew {

// What all voxels of a picture have in common.
struct VoxelLighting {
  std::span<const VoxelMaterial> materials;
  std::span<const ShadingLight> lights;
  std::span<const VoxelShadowMap> shadows;  // one a light
  Environment environment;
  CameraView camera;
  bool mirrors = true;  // sharp mirrors show the environment as a ray would; else blurred
};

// Radiance towards the eye, then 1: one a voxel of the batch, and as many more as it is padded by.
using Radiance = float[kMostWinners][4];
void shade_voxels(const VoxelLighting& lighting, const VoxelBatch& batch, Radiance& out);

// One row of the environment behind everything, opaque.
struct BackgroundRow {
  float first_x = 0.0f, step_x = 1.0f;  // pixels of the camera: where the row begins and goes on
  float y = 0.0f;
  uint32_t width = 0, height = 0;  // of the camera's whole image
  uint32_t count = 0;
};
void shade_background(const Environment& environment, const CameraView& camera,
                      const BackgroundRow& row, vec4* out);

}  // namespace sinew
