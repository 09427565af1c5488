// One picture, breadth-first: every stage works on all rays of a wave before the next begins.
// The image is drawn in batches of tiles, so that memory does not grow with its size; with a time
// budget all of it is one batch, so that no secondary ray comes before any primary one.
#include "sinew/render/frame.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/render/draw.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/sampling.h"
#include "sinew/render/settling.h"

namespace sinew {
namespace {

constexpr uint32_t kBatchTiles = 128;         // 32,768 rays: their surfaces stay in the cache
constexpr size_t kBudgetSlice = 16 * kChunk;  // primary rays between two looks at the clock

void check_settings(const RenderSettings& settings) {
  SINEW_CHECK(settings.width > 0 && settings.height > 0);
  SINEW_CHECK(uint64_t{settings.width} * settings.height < (uint64_t{1} << 32));
  SINEW_CHECK(settings.samples >= 1 && settings.samples <= 4096);
  SINEW_CHECK(settings.reflections <= 16 && settings.refractions <= 32);
  SINEW_CHECK(settings.ambient_rays <= 4096 && settings.ambient_distance >= 0.0f);
  SINEW_CHECK(settings.subsampling >= 1 && settings.subsampling <= 64);
  SINEW_CHECK(settings.time_budget_ms >= 0.0);
}

// Adds the wave's results to its pixels. The chunk that holds the first ray of a pixel adds all of
// them, in order.
void accumulate(const Wave& wave, Image& out) {
  const auto continues = [&](size_t i) {
    return i > 0 && i < wave.count && wave.paths[i].pixel == wave.paths[i - 1].pixel;
  };
  parallel_for(wave.count, kChunk, [&](size_t begin, size_t end) {
    while (begin < end && continues(begin)) ++begin;
    if (begin == end) return;
    while (continues(end)) ++end;
    for (size_t i = begin; i < end; ++i) out.pixels[wave.paths[i].pixel] += wave.result[i];
  });
}

// From a wave whose surfaces are known to light in the image, and on to the waves that follow.
void shade_and_follow(const FrameContext& frame, uint32_t sample, RenderScratch& scratch,
                      Tally& tally, Image& image) {
  Wave& wave = scratch.wave;
  while (wave.count > 0) {
    settle_starts(frame, wave, tally);
    for (size_t i = 0; i < scratch.lights.size(); ++i) {
      add_light(frame, scratch.lights[i], i, wave, scratch.probes, tally);
    }
    trace_ambient(frame, sample, wave, scratch.probes, tally);
    shade_wave(frame, wave, scratch.offspring);
    accumulate(wave, image);
    scratch.offspring.become(wave);  // mirror images, and what lies behind blends and glass
    trace_wave(frame, scratch.attributes, wave, tally);
  }
}

// The rasteriser draws the voxels of a whole pass at once, so that passes come one after the other.
void draw_with_voxels(const FrameContext& frame, const CameraView& camera,
                      const DrawnPixels& pixels, RenderScratch& scratch, Tally& tally,
                      Image& image) {
  const uint32_t samples = frame.settings.samples, tiles = pixels.grid.count();
  for (uint32_t sample = 0; sample < samples; ++sample) {
    const vec2 offset = hammersley(sample, samples);
    draw_voxels(camera, frame.settings, pixels, offset, scratch, tally);
    for (uint32_t tile = 0; tile < tiles; tile += kBatchTiles) {
      draw_tiles(frame, pixels, tile, std::min(tile + kBatchTiles, tiles), sample, offset, scratch,
                 tally, image);
    }
  }
}

// Nothing is traced.
void draw_voxels_alone(const FrameContext& frame, const CameraView& camera,
                       const DrawnPixels& pixels, RenderScratch& scratch, Tally& tally,
                       Image& image) {
  const RenderSettings& settings = frame.settings;
  VoxelFrame& voxels = scratch.voxels;
  const VoxelLighting lighting{voxels.materials(),      scratch.lights, voxels.shadows(),
                               frame.scene.environment, camera,         settings.reflections > 0};
  const auto fetch = [&](std::span<const VisibilityKey> keys, VoxelBatch& batch) {
    voxels.fetch(keys, batch);
  };
  voxels.allow_parts();
  for (uint32_t sample = 0; sample < settings.samples; ++sample) {
    const vec2 offset = hammersley(sample, settings.samples);
    draw_voxels(camera, settings, pixels, offset, scratch, tally);
    voxels.shade({.lighting = lighting,
                  .visibility = voxels.visibility(),
                  .fetch = fetch,
                  .width = settings.width,
                  .height = settings.height,
                  .step = settings.subsampling,
                  .offset = offset,
                  .transparent = settings.transparent,
                  .share = 1.0f / static_cast<float>(settings.samples),
                  .first = sample == 0},
                 image);
  }
}

void draw_once(const FrameContext& frame, const CameraView& camera, const DrawnPixels& pixels,
               RenderScratch& scratch, Tally& tally, Image& image) {
  const uint32_t samples = frame.settings.samples, tiles = pixels.grid.count();
  const bool drawn = frame.voxels && frame.voxels->rasters();
  if (drawn) draw_with_voxels(frame, camera, pixels, scratch, tally, image);
  for (uint32_t tile = 0; tile < tiles && !drawn; tile += kBatchTiles) {
    for (uint32_t sample = 0; sample < samples; ++sample) {
      draw_tiles(frame, pixels, tile, std::min(tile + kBatchTiles, tiles), sample,
                 hammersley(sample, samples), scratch, tally, image);
    }
  }
  const float share = 1.0f / static_cast<float>(samples);
  for (vec4& pixel : image.pixels) pixel *= share;
}

// Counts the rays of every time that the picture is drawn.
void draw_everything(const FrameContext& frame, const CameraView& camera, const DrawnPixels& pixels,
                     RenderScratch& scratch, Tally& tally, Image& image) {
  Settling settling(frame.world, frame.scene.octrees);
  bool again = false;
  do {
    if (again) std::ranges::fill(image.pixels, vec4(0.0f));
    draw_once(frame, camera, pixels, scratch, tally, image);
    tally.clock.end_shading();
    again = settling.again();
    tally.clock.end_drawing();
  } while (again);
}

// Primary rays from coarse to fine while there is time, at least those of the coarsest lattice;
// then, while there is time, what they call for.
void draw_in_time(const FrameContext& frame, const CameraView& camera, const DrawnPixels& pixels,
                  RenderScratch& scratch, Tally& tally, Image& image) {
  CoarseToFine& order = scratch.order;
  Wave& wave = scratch.wave;
  if (frame.voxels && frame.voxels->rasters()) {
    draw_voxels(camera, frame.settings, pixels, vec2(0.5f), scratch, tally);
  }
  order.resize(pixels.grid.width, pixels.grid.height);
  size_t drawn = 0;
  while (drawn < order.count() && (drawn < order.coarsest() || !frame.deadline.passed())) {
    const size_t end = std::min(std::max(drawn + kBudgetSlice, order.coarsest()), order.count());
    order.start_wave(pixels, drawn, end, wave);
    tally.clock.end_shading();
    trace_hits(frame, wave, drawn, end);
    tally.clock.end_tracing();
    drawn = end;
  }
  tally.traced.primary += drawn;
  tally.skipped.primary += order.count() - drawn;
  resolve_wave(frame, scratch.attributes, wave);
  shade_and_follow(frame, 0, scratch, tally, image);
  order.fill(drawn, image);
}

// Moves the reserve towards what the frame took beyond the last moment for rays.
void adapt_reserve(double budget_ms, double taken_ms, bool ran_out, double& reserve_ms) {
  if (!ran_out && taken_ms <= budget_ms) return;
  reserve_ms = std::clamp(reserve_ms + 0.5 * (taken_ms - budget_ms), 0.0, 0.8 * budget_ms);
}

void resize(uint32_t width, uint32_t height, Image& image) {
  image.width = width;
  image.height = height;
  image.pixels.resize(size_t{width} * height);
}

void clear(uint32_t width, uint32_t height, Image& image) {
  resize(width, height, image);
  std::fill(image.pixels.begin(), image.pixels.end(), vec4(0.0f));
}

bool has_triangles(const ScenePose& pose) {
  return std::any_of(pose.objects.begin(), pose.objects.end(),
                     [](const Pose& object) { return object.present; });
}

bool casts_shadows(std::span<const ShadingLight> lights) {
  return std::ranges::any_of(lights, [](const ShadingLight& light) { return light.shadows; });
}

// Decides what of the voxels is drawn and what is traced.
void begin_voxels(const ScenePose& pose, const CameraView& camera, RenderScratch& scratch,
                  FrameContext& frame) {
  const RenderSettings& settings = frame.settings;
  VoxelFrame& voxels = scratch.voxels;
  const bool shadows = settings.shadows && casts_shadows(scratch.lights);
  const VoxelShadowing from = settings.voxels.shadowing;
  frame.voxels = &voxels;
  frame.near_triangles = has_triangles(pose);
  const bool rays = frame.near_triangles || settings.ambient_rays > 0 ||
                    (settings.reflections > 0 && voxels.has_mirrors()) ||
                    (shadows && from == VoxelShadowing::rays);
  voxels.choose(camera, settings.width, settings.height, settings.subsampling, rays);
  frame.voxels_alone = !rays && voxels.stats().traced == 0;
  frame.voxel_maps = shadows && (from == VoxelShadowing::maps ||
                                 (from == VoxelShadowing::automatic &&
                                  (frame.voxels_alone || settings.time_budget_ms > 0.0)));
  voxels.set_shadows(scratch.lights, frame.voxel_maps);
}

}  // namespace

void RenderScratchDeleter::operator()(RenderScratch* scratch) const {
  delete scratch;
}
RenderScratchPtr make_render_scratch() {
  return RenderScratchPtr(new RenderScratch);
}

FrameContext begin_frame(const World& world, const Scene& scene, const ScenePose& pose,
                         const CameraView& camera, const RenderSettings& settings, uint64_t rays,
                         RenderScratch& scratch) {
  SINEW_CHECK(pose.objects.size() == scene.objects.size());
  if (scratch.attributes.begin_frame(world, scene, pose, rays)) {
    scratch.textures.build(scene);
    scratch.voxels.bind(scene, scratch.textures);
  }
  gather_lights(scene, pose, camera, scratch.lights);

  FrameContext frame{world, scene, settings, scratch.textures};
  scratch.voxels.begin(world, settings.voxels);
  if (scratch.voxels.any()) begin_voxels(pose, camera, scratch, frame);
  frame.ambient_distance = settings.ambient_distance;
  if (frame.ambient_distance == 0.0f) {
    frame.ambient_distance = world.size() > 0.0f ? 0.25f * world.size() : 1.0f;
  }
  frame.filtered = needs_filter(scene);
  return frame;
}

void draw_voxels(const CameraView& camera, const RenderSettings& settings,
                 const DrawnPixels& pixels, vec2 offset, RenderScratch& scratch, Tally& tally) {
  tally.clock.end_shading();
  scratch.voxels.draw(camera, settings.width, settings.height, static_cast<uint32_t>(pixels.step),
                      offset);
  tally.clock.end_drawing();
}

float ray_share(const RenderSettings& settings) {
  return 1.0f / std::sqrt(static_cast<float>(settings.samples));
}

void draw_tiles(const FrameContext& frame, const DrawnPixels& pixels, uint32_t first_tile,
                uint32_t last_tile, uint32_t sample, vec2 offset, RenderScratch& scratch,
                Tally& tally, Image& image) {
  start_wave(pixels, first_tile, last_tile, offset, scratch.wave);
  trace_wave(frame, scratch.attributes, scratch.wave, tally);
  shade_and_follow(frame, sample, scratch, tally, image);
}

FrameStats stats_of(const Tally& tally, const RenderScratch& scratch) {
  const VoxelStats& voxels = scratch.voxels.stats();
  const double begun_ms = voxels.pose_ms + voxels.shadow_ms;  // the clock takes it for shading
  return {.trace_ms = tally.clock.trace_ms,
          .shade_ms = tally.clock.shade_ms - begun_ms,
          .draw_ms = tally.clock.draw_ms + begun_ms,
          .rays = tally.traced,
          .skipped = tally.skipped,
          .voxels = voxels};
}

FrameStats render_frame(const World& world, const Scene& scene, const ScenePose& pose,
                        const CameraView& camera, const RenderSettings& settings,
                        RenderScratch& scratch, Image& out) {
  check_settings(settings);
  Tally tally;
  RenderSettings in_frame = settings;
  if (settings.time_budget_ms > 0.0) in_frame.samples = 1;
  const uint32_t step = settings.subsampling;
  const TileGrid grid{(settings.width + step - 1) / step, (settings.height + step - 1) / step};
  FrameContext frame = begin_frame(world, scene, pose, camera, in_frame,
                                   uint64_t{grid.width} * grid.height * in_frame.samples, scratch);
  const DrawnPixels pixels{CameraRays(camera, settings.width, settings.height), grid,
                           static_cast<float>(step), ray_share(in_frame)};
  Image& drawn = step > 1 ? scratch.drawn : out;
  if (frame.voxels_alone) {
    resize(grid.width, grid.height, drawn);
    draw_voxels_alone(frame, camera, pixels, scratch, tally, drawn);
  } else {
    clear(grid.width, grid.height, drawn);
    if (settings.time_budget_ms > 0.0) {
      frame.deadline = Deadline::after_ms(settings.time_budget_ms - scratch.reserve_ms);
      draw_in_time(frame, camera, pixels, scratch, tally, drawn);
    } else {
      draw_everything(frame, camera, pixels, scratch, tally, drawn);
    }
  }
  if (step > 1) {
    clear(settings.width, settings.height, out);
    upsample(drawn, step, out);
  }
  tally.clock.end_shading();
  if (frame.deadline.is_set()) {
    adapt_reserve(settings.time_budget_ms, tally.clock.trace_ms + tally.clock.shade_ms,
                  tally.skipped.total() > 0, scratch.reserve_ms);
  }
  return stats_of(tally, scratch);
}

}  // namespace sinew
