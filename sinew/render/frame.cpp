// One picture, breadth-first: every stage works on all rays of a wave before the next begins.
// The image is drawn in batches of tiles, so that memory does not grow with its size.
#include "sinew/render/frame.h"

#include <algorithm>
#include <atomic>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/sampling.h"
#include "sinew/render/trace_effects.h"

namespace sinew {

struct RenderScratch {
  AttributeTable attributes;
  std::vector<ShadingLight> lights;
  Wave wave;
  Probes probes;
  Offspring offspring;
};

namespace {

constexpr uint32_t kTile = 16;         // pixels; within a tile they follow Morton's order
constexpr uint32_t kBatchTiles = 128;  // 32,768 rays: their surfaces stay in the cache

// The tiles of an image, row by row. Those at the right and lower edge may be smaller.
struct TileGrid {
  uint32_t width, height;
  uint32_t columns = (width + kTile - 1) / kTile;
  uint32_t rows = (height + kTile - 1) / kTile;

  uint32_t count() const { return columns * rows; }
  // Pixels in the tiles before `tile`.
  size_t first_pixel(uint32_t tile) const {
    const uint32_t row = tile / columns, column = tile % columns;
    const size_t above = size_t{width} * std::min(row * kTile, height);
    const size_t tile_height = std::min(kTile, height - std::min(row * kTile, height));
    return above + std::min(column * kTile, width) * tile_height;
  }
};

void check_settings(const RenderSettings& settings) {
  SINEW_CHECK(settings.width > 0 && settings.height > 0);
  SINEW_CHECK(uint64_t{settings.width} * settings.height < (uint64_t{1} << 32));
  SINEW_CHECK(settings.samples >= 1 && settings.samples <= 4096);
  SINEW_CHECK(settings.reflections <= 16 && settings.ambient_rays <= 4096);
  SINEW_CHECK(settings.ambient_distance >= 0.0f);
}

uint32_t even_bits(uint32_t x) {
  x &= 0x55u;
  x = (x | (x >> 1)) & 0x33u;
  return (x | (x >> 2)) & 0x0fu;
}

// One camera ray through each pixel of the tiles [first, last), at the sample's place in it.
void start_wave(const CameraRays& rays, const TileGrid& grid, uint32_t first, uint32_t last,
                vec2 offset, Wave& wave) {
  const size_t start = grid.first_pixel(first);
  wave.resize(grid.first_pixel(last) - start);
  parallel_for(last - first, 4, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const uint32_t tile = first + static_cast<uint32_t>(t);
      const uint32_t left = tile % grid.columns * kTile, top = tile / grid.columns * kTile;
      size_t next = grid.first_pixel(tile) - start;
      for (uint32_t code = 0; code < kTile * kTile; ++code) {
        const uint32_t x = left + even_bits(code), y = top + even_bits(code >> 1);
        if (x >= grid.width || y >= grid.height) continue;
        wave.rays[next] = rays(static_cast<float>(x) + offset.x, static_cast<float>(y) + offset.y);
        wave.paths[next] = {y * grid.width + x, 0, 0, vec3(1.0f)};
        ++next;
      }
    }
  });
}

// Closest hits of the wave; says which objects were met and counts rays by kind.
void trace_wave(const FrameContext& frame, Wave& wave, AttributeTable& attributes,
                RayCounts& counts, StageClock& clock) {
  const FilterContext filter{&frame.world, &frame.scene, wave.rays.data(), nullptr};
  clock.end_shading();
  parallel_for(wave.count, kChunk, [&](size_t begin, size_t end) {
    QueryOptions options{.facing = Facing::front};
    if (frame.filtered) options.filter = visible_filter(filter);
    options.first_ray = static_cast<uint32_t>(begin);
    frame.world.closest_hits({wave.rays.data() + begin, end - begin},
                             {wave.hits.data() + begin, end - begin}, options);
  });
  clock.end_tracing();
  std::atomic<uint64_t> reflected{0};
  parallel_for(wave.count, kChunk, [&](size_t begin, size_t end) {
    uint64_t in_chunk = 0;
    for (size_t i = begin; i < end; ++i) {
      in_chunk += wave.paths[i].bounce > 0 ? 1 : 0;
      if (!wave.hits[i]) continue;
      SINEW_CHECK(wave.hits[i].object < frame.scene.objects.size());
      attributes.touch(wave.hits[i].object);
    }
    reflected.fetch_add(in_chunk, std::memory_order_relaxed);
  });
  counts.reflection += reflected;
  counts.primary += wave.count - reflected;
}

// Fills the G-buffer.
void resolve_wave(const FrameContext& frame, AttributeTable& attributes, Wave& wave) {
  attributes.refresh();
  parallel_for(wave.count, kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      wave.direct[i] = vec3(0.0f);
      const Hit& hit = wave.hits[i];
      if (hit) {
        resolve_surface(frame.scene, attributes.of(hit.object), wave.rays[i], hit,
                        wave.surfaces[i]);
      } else {
        wave.surfaces[i].hit = hit;
      }
    }
  });
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

FrameContext make_context(const World& world, const Scene& scene, const RenderSettings& settings) {
  FrameContext frame{world, scene, settings};
  frame.ambient_distance = settings.ambient_distance;
  if (frame.ambient_distance == 0.0f) {
    const Box box = world.box();
    frame.ambient_distance = box.empty() ? 1.0f : 0.25f * length(box.extent());
  }
  frame.filtered = needs_filter(scene);
  return frame;
}

}  // namespace

void RenderScratchDeleter::operator()(RenderScratch* scratch) const {
  delete scratch;
}
RenderScratchPtr make_render_scratch() {
  return RenderScratchPtr(new RenderScratch);
}

FrameStats render_frame(const World& world, const Scene& scene, const ScenePose& pose,
                        const CameraView& camera, const RenderSettings& settings,
                        RenderScratch& scratch, Image& out) {
  check_settings(settings);
  SINEW_CHECK(pose.objects.size() == scene.objects.size());
  StageClock clock;
  RayCounts counts;
  auto& [attributes, lights, wave, probes, offspring] = scratch;
  const FrameContext frame = make_context(world, scene, settings);
  const CameraRays camera_rays(camera, settings.width, settings.height);
  const TileGrid grid{settings.width, settings.height};
  attributes.begin_frame(world, scene, pose);
  gather_lights(scene, pose, camera, lights);
  out.width = settings.width;
  out.height = settings.height;
  out.pixels.assign(size_t{out.width} * out.height, vec4(0.0f));

  for (uint32_t tile = 0; tile < grid.count(); tile += kBatchTiles) {
    const uint32_t last_tile = std::min(tile + kBatchTiles, grid.count());
    for (uint32_t sample = 0; sample < settings.samples; ++sample) {
      start_wave(camera_rays, grid, tile, last_tile, hammersley(sample, settings.samples), wave);
      while (wave.count > 0) {
        trace_wave(frame, wave, attributes, counts, clock);
        resolve_wave(frame, attributes, wave);
        for (const ShadingLight& light : lights) {
          counts.shadow += add_light(frame, light, wave, probes, clock);
        }
        counts.ambient += trace_ambient(frame, sample, wave, probes, clock);
        shade_wave(frame, wave, offspring);
        accumulate(wave, out);
        offspring.become(wave);  // mirror images, and what lies behind blends
      }
    }
  }
  const float share = 1.0f / static_cast<float>(settings.samples);
  for (vec4& pixel : out.pixels) pixel *= share;
  clock.end_shading();
  return {clock.trace_ms, clock.shade_ms, counts};
}

}  // namespace sinew
