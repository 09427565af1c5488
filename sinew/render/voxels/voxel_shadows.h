// Shadows of voxel objects: what each light sees of them, drawn by the rasteriser that draws the
// picture. Lookups are filtered over 3 x 3 texels (percentage-closer: W. Reeves, D. Salesin,
// R. Cook, "Rendering Antialiased Shadows with Depth Maps", SIGGRAPH 1987).
//
// A voxel is flat in the map, and the surface that its neighbours belong to may be aslant, so a
// voxel looks for its light from a point off the surface: along its normal, as far as both texels
// and voxels reach. Other surfaces look from where they are, so nothing floats above its shadow.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/render/lights.h"
#include "sinew/render/raster_view.h"
#include "sinew/render/voxels/voxel_settings.h"
#include "sinew/svo/draw/rasterize.h"
#include "sinew/world/voxel_bodies.h"

namespace sinew {

// One light's maps: none, one, or the six faces of a cube.
struct VoxelShadowMap {
  uint32_t views = 0;
  RasterView view[6];
  DepthMap map[6];
  float texel = 0.0f;  // size; metres, or metres at a depth of one
};

// A surface that looks for a light.
struct ShadowReceiver {
  vec3 position{0.0f};
  vec3 normal{0.0f};      // unit, towards the light
  float cosine = 1.0f;    // of the normal and the direction to the light
  float diagonal = 0.0f;  // of the voxel; 0: it is no voxel
};

inline constexpr float kFilterReach = 2.0f;     // texels
inline constexpr float kCoarsestCaster = 2.5f;  // texels: the diagonal of a voxel in the map
inline constexpr float kVoxelHeight = 1.25f;    // diagonals: how much higher than a voxel's middle
                                                // its neighbours on the same plane may reach

// By how much a voxel lifts its lookup along its normal; `texel` at its depth. Metres. Besides what
// neighbours reach above it, a slope rises under the filter and under voxels that are flat in the
// map.
inline float shadow_lift(float cosine, float diagonal, float texel) {
  const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
  const float caster = std::max(diagonal, kCoarsestCaster * texel);
  return kVoxelHeight * caster + sine * (kFilterReach * texel + 0.5f * caster);
}

// The share of the light that voxels let through, 0..1; 1 outside of the maps.
float lit_share(const VoxelShadowMap& shadow, const ShadowReceiver& receiver);

class VoxelShadows {
 public:
  // Draws a map for every light with shadows. Lights and bodies may change from frame to frame; in
  // the steady state nothing is allocated.
  RasterStats draw(std::span<const ShadingLight> lights, const VoxelBodies& bodies,
                   const VoxelSettings& settings, RasterPart part = RasterPart::whole);
  // No shadows: everything is lit.
  void clear(size_t lights);

  std::span<const VoxelShadowMap> maps() const { return {maps_.data(), lights_}; }

 private:
  std::vector<VoxelShadowMap> maps_;
  std::vector<RasterScratchPtr> scratch_;  // one a view
  size_t lights_ = 0;
};

}  // namespace sinew
