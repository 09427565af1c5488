// The parts of a frame that render_frame() and Refinement share.
#pragma once

#include "sinew/render/camera_wave.h"
#include "sinew/render/frame.h"
#include "sinew/render/trace_effects.h"

namespace sinew {

struct RenderScratch {
  AttributeTable attributes;
  TextureTable textures;
  std::vector<ShadingLight> lights;
  Wave wave;
  Probes probes;
  Offspring offspring;
  VoxelFrame voxels;
  Image drawn;              // of sub-sampled frames
  CoarseToFine order;       // of frames with a time budget
  double reserve_ms = 0.0;  // what such a frame needs after its last ray
};

// Finds which voxels are in front where these pixels are drawn, for draw_tiles() of the same
// sample.
void draw_voxels(const CameraView& camera, const RenderSettings& settings,
                 const DrawnPixels& pixels, vec2 offset, RenderScratch& scratch, Tally& tally);

// Makes the scratch ready for a frame of about so many camera rays, which `settings` must outlive.
FrameContext begin_frame(const World& world, const Scene& scene, const ScenePose& pose,
                         const CameraView& camera, const RenderSettings& settings, uint64_t rays,
                         RenderScratch& scratch);

FrameStats stats_of(const Tally& tally, const RenderScratch& scratch);

// By how much rays are narrower than pixels if several share one.
float ray_share(const RenderSettings& settings);

// One pass over some tiles: adds `sample` of each pixel, at `offset` in it, with all rays that come
// of it, to the image.
void draw_tiles(const FrameContext& frame, const DrawnPixels& pixels, uint32_t first_tile,
                uint32_t last_tile, uint32_t sample, vec2 offset, RenderScratch& scratch,
                Tally& tally, Image& image);

}  // namespace sinew
