// render_frame: one picture of a world. The whole pipeline reads on one page, in frame.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "sinew/render/camera.h"
#include "sinew/render/voxels/voxel_settings.h"
#include "sinew/scene/image.h"
#include "sinew/world/world.h"

namespace sinew {

struct RenderSettings {
  uint32_t width = 800;
  uint32_t height = 600;
  uint32_t samples = 1;           // camera rays a pixel, 1..4096
  uint32_t reflections = 1;       // mirror bounces, 0..16
  uint32_t refractions = 8;       // transmissive surfaces that a path goes through, 0..32; behind
                                  // the last one it sees the environment
  uint32_t ambient_rays = 0;      // ambient occlusion rays a hit, 0..4096; 0: none, the environment
                                  // shines unoccluded
  float ambient_distance = 0.0f;  // how far occlusion reaches, metres; 0: a quarter of the scene's
                                  // diagonal
  bool shadows = true;
  float exposure = 0.0f;     // stops
  bool transparent = false;  // the background has alpha 0 instead of the environment's colour
  uint32_t seed = 0;

  // For interactive rates (L section 4).
  uint32_t subsampling = 1;     // one pixel is drawn for a square of so many pixels a side, at its
                                // centre, and the rest interpolated bilinearly; 1..64
  double time_budget_ms = 0.0;  // > 0: rays that the frame has no time for are left out: breadth-
                                // first, so that all primary rays come before any other, with one
                                // primary ray a drawn pixel whatever `samples` says. Not the same
                                // bits every time. Voxels are drawn whatever it says.

  VoxelSettings voxels{};

  bool operator==(const RenderSettings&) const = default;
};

// A ray that goes on behind a blended surface counts as the kind it continues.
struct RayCounts {
  uint64_t primary = 0;
  uint64_t shadow = 0;
  uint64_t ambient = 0;
  uint64_t reflection = 0;
  uint64_t refraction = 0;  // also straight through thin transmissive surfaces

  uint64_t total() const { return primary + shadow + ambient + reflection + refraction; }
};

struct FrameStats {
  double trace_ms = 0.0;  // in ray queries
  double shade_ms = 0.0;  // everything else
  double draw_ms = 0.0;   // in the rasteriser: poses, shadow maps and pictures of voxels
  RayCounts rays;         // really traced
  RayCounts skipped;      // left out because the time was up, and their offspring never made
  VoxelStats voxels;
};

// Buffers that live from frame to frame; a frame after the first of a size allocates nothing. They
// keep tables of the last scene drawn, which must not change its data meanwhile.
struct RenderScratch;
struct RenderScratchDeleter {
  void operator()(RenderScratch* scratch) const;
};
using RenderScratchPtr = std::unique_ptr<RenderScratch, RenderScratchDeleter>;
RenderScratchPtr make_render_scratch();

// Draws the world as `pose` has it (the world must have been committed with that pose) to `out`:
// linear radiance. Triangles are traced, voxels rasterised or traced as the settings say; shadows,
// ambient occlusion, mirrors and glass see both. Voxels alone that call for none of these but
// shadows are drawn and shaded without any ray. Same bits for every thread count. Settings must be
// in range (checked).
FrameStats render_frame(const World& world, const Scene& scene, const ScenePose& pose,
                        const CameraView& camera, const RenderSettings& settings,
                        RenderScratch& scratch, Image& out);

// Display transform: exposure, a filmic shoulder that keeps hue, sRGB.
void tonemap(const Image& image, float exposure, Image8& out);

}  // namespace sinew
