// The effects that need rays from surfaces: light with shadows, ambient occlusion, and the rays
// that go on behind mirrors and blended surfaces. Each works on a whole wave at once.
#pragma once

#include "sinew/base/deadline.h"
#include "sinew/render/frame.h"
#include "sinew/render/lights.h"
#include "sinew/render/voxels/voxel_frame.h"
#include "sinew/render/wave.h"

namespace sinew {

// Splits a frame's time into queries and the rest, on the calling thread.
class StageClock {
 public:
  StageClock();
  void end_shading();  // time since the last call was shading
  void end_tracing();  // ... was ray queries
  void end_drawing();  // ... was the rasteriser
  double draw_ms = 0.0;
  double trace_ms = 0.0;
  double shade_ms = 0.0;

 private:
  double lap();
  double last_ms_ = 0.0;
};

// What every stage reads; constant during a frame.
struct FrameContext {
  const World& world;
  const Scene& scene;
  const RenderSettings& settings;
  const TextureTable& textures;
  float ambient_distance = 0.0f;       // metres
  bool filtered = false;               // some hits must be asked about (see ray_filter.h)
  const VoxelFrame* voxels = nullptr;  // null: there are none
  bool voxels_alone = false;           // nothing of the picture needs rays
  bool voxel_maps = false;             // voxels' shadows come from maps, not from rays
  bool near_triangles = false;         // voxels may touch triangles
  Deadline deadline = {};              // rays are left out when it has passed

  // Whether the picture of voxels in front says something of these rays.
  bool drawn(const Wave& wave) const {
    return voxels != nullptr && wave.camera && voxels->rasters();
  }
};

// What a frame has done so far.
struct Tally {
  StageClock clock;
  RayCounts traced, skipped;
};

// Finds the closest hits of the wave's rays [begin, end).
void trace_hits(const FrameContext& frame, Wave& wave, size_t begin, size_t end);

// Says which objects the wave has hit, and fills the G-buffer.
void resolve_wave(const FrameContext& frame, AttributeTable& attributes, Wave& wave);

// Both, for as many rays as there is time for; the rest meets nothing.
void trace_wave(const FrameContext& frame, AttributeTable& attributes, Wave& wave, Tally& tally);

// Brings the starts of rays from voxels that lie close to triangles to these triangles' near side:
// a voxel's rays begin clear of its neighbours, which may be behind what it touches.
void settle_starts(const FrameContext& frame, Wave& wave, Tally& tally);

// Adds the reflected radiance of light `index` to wave.direct, in shadow where something is
// between. Rays that there is no time for find nothing between.
void add_light(const FrameContext& frame, const ShadingLight& light, size_t index, Wave& wave,
               Probes& probes, Tally& tally);

// Sets wave.ambient: the cosine-weighted share of the hemisphere that is open up to the ambient
// distance. `sample` is the pass over the pixels. Rays that there is no time for are open.
void trace_ambient(const FrameContext& frame, uint32_t sample, Wave& wave, Probes& probes,
                   Tally& tally);

// Sets wave.result from everything found out about the rays, and makes the rays that go on.
void shade_wave(const FrameContext& frame, Wave& wave, Offspring& offspring);

}  // namespace sinew
