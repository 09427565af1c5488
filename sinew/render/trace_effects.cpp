#include "sinew/render/trace_effects.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/math/color.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/sampling.h"
#include "sinew/render/shade.h"

namespace sinew {
namespace {

// Between two looks at the clock: some milliseconds of work.
constexpr size_t kSlice = 16 * kChunk;

// Calls body(begin, end) for [0, count) slice by slice until the deadline passes; without one, for
// all of it at once. Returns how far it came.
template <class Body>
size_t until(const Deadline& deadline, size_t count, const Body& body) {
  const size_t slice = deadline.is_set() ? kSlice : count;
  size_t done = 0;
  while (done < count && !deadline.passed()) {
    const size_t end = std::min(done + slice, count);
    body(done, end);
    done = end;
  }
  return done;
}

bool is_lit(const Surface& surface) {
  return surface.hit && !surface.unlit;
}

// Voxels' level of detail. Rays from surfaces see finer ones than the surface itself shows, so that
// they begin clear of their neighbours; their level rises slowly, because what is coarse sticks
// out.
constexpr float kFiner = 0.5f;
constexpr float kAmbientSpread = 0.03f;
constexpr float kWithin =
    1.05f;  // how far beyond the start of its rays a voxel looks for triangles

// Rays of the camera end at the voxel that is drawn in front.
void end_at_voxels(const FrameContext& frame, Wave& wave, size_t begin, size_t end) {
  for (size_t i = begin; i < end; ++i) {
    Ray& ray = wave.rays[i];
    const float t = frame.voxels->t_of(wave.paths[i].pixel, ray);
    ray.t_max = std::max(std::min(ray.t_max, t), ray.t_min);
  }
}

// How wide the rays [begin, end) of a wave are where they choose voxels: the narrowest of them.
RayFootprint footprint_of(const FrameContext& frame, const Wave& wave, size_t begin, size_t end) {
  RayCone cone = wave.paths[begin].cone;
  for (size_t i = begin + 1; i < end; ++i) {
    cone.width = std::min(cone.width, wave.paths[i].cone.width);
    cone.spread = std::min(cone.spread, wave.paths[i].cone.spread);
  }
  const float scale = frame.settings.voxels.lod * (wave.camera ? 1.0f : kFiner);
  return {scale * cone.width, scale * cone.spread};
}

// The same of rays from surfaces.
RayFootprint footprint_of(const FrameContext& frame, const Wave& wave,
                          std::span<const uint32_t> owners, float spread) {
  if (owners.empty()) return {};
  float width = wave.surfaces[owners[0]].width;
  for (const uint32_t owner : owners) width = std::min(width, wave.surfaces[owner].width);
  return {frame.settings.voxels.lod * kFiner * width, frame.settings.voxels.lod * spread};
}

// The share of the light that voxels let through to the surface.
float lit_by_voxels(const FrameContext& frame, size_t light, const Surface& surface,
                    vec3 to_light) {
  if (!frame.voxel_maps) return 1.0f;
  return lit_share(frame.voxels->shadows()[light],
                   {surface.position, surface.normal,
                    std::clamp(dot(surface.normal, to_light), 0.0f, 1.0f), surface.voxel});
}

// Finds which probes are blocked, and by how much others are dimmed on their way. Counts them.
// `spread` is that of their footprint; rays that pass voxels find triangles alone.
void trace_probes(const FrameContext& frame, const Wave& wave, bool pass_voxels, float spread,
                  Probes& probes, StageClock& clock, uint64_t& traced, uint64_t& skipped) {
  const FilterContext filter{&frame.world, &frame.scene, probes.rays.data(),
                             probes.optical_depth.data(), &frame.textures};
  clock.end_shading();
  const size_t done = until(frame.deadline, wave.count, [&](size_t begin, size_t end) {
    parallel_for(end - begin, kChunk, [&](size_t chunk_begin, size_t) {
      const size_t first = begin + chunk_begin, count = probes.count[first / kChunk];
      QueryOptions options{.facing = Facing::back};
      if (frame.filtered) options.filter = shadow_filter(filter);
      options.first_ray = static_cast<uint32_t>(first);
      if (pass_voxels) options.hidden = frame.voxels->all();
      if (frame.voxels) {
        options.footprint = footprint_of(frame, wave, {probes.owner.data() + first, count}, spread);
      }
      frame.world.any_hits({probes.rays.data() + first, count},
                           {probes.blocked.data() + first, count}, options);
    });
  });
  clock.end_tracing();
  if (done < wave.count) {
    std::fill(probes.blocked.begin() + static_cast<ptrdiff_t>(done), probes.blocked.end(),
              uint8_t{0});
  }
  const uint64_t in_time = probes.total(done);
  traced += in_time;
  skipped += probes.total(wave.count) - in_time;
}

// Calls gather(owner, part of the probe's light that arrives) for all probes.
template <class Gather>
void gather_probes(const Wave& wave, const Probes& probes, const Gather& gather) {
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t) {
    for (size_t slot = begin; slot < begin + probes.count[chunk]; ++slot) {
      if (probes.blocked[slot]) continue;
      gather(probes.owner[slot], probes.light[slot] * transmittance(probes.optical_depth[slot]));
    }
  });
}

Ray shadow_ray(const ShadingLight& light, const Surface& surface) {
  constexpr float kBeforeLight = 1.0f - 1e-4f;
  Ray ray;
  ray.origin = leave_before(surface, surface.lifted);
  if (light.type == LightType::directional) {
    ray.direction = -light.direction;
    return ray;
  }
  ray.direction = light.position - ray.origin;
  ray.t_max = kBeforeLight;
  return ray;
}

// The counts of the wave's rays from `begin` on, by kind.
RayCounts count_rays(const Wave& wave, size_t begin, size_t end) {
  RayCounts out;
  for (size_t i = begin; i < end; ++i) {
    const RayKind kind = wave.paths[i].kind;
    out.primary += kind == RayKind::primary;
    out.reflection += kind == RayKind::reflection;
    out.refraction += kind == RayKind::refraction;
  }
  return out;
}

void add(RayCounts& sum, const RayCounts& counts) {
  sum.primary += counts.primary;
  sum.reflection += counts.reflection;
  sum.refraction += counts.refraction;
}

}  // namespace

StageClock::StageClock() {
  lap();
}
void StageClock::end_shading() {
  shade_ms += lap();
}
void StageClock::end_tracing() {
  trace_ms += lap();
}
void StageClock::end_drawing() {
  draw_ms += lap();
}

double StageClock::lap() {
  using namespace std::chrono;
  const double now = duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
  const double passed_ms = now - last_ms_;
  last_ms_ = now;
  return passed_ms;
}

void trace_hits(const FrameContext& frame, Wave& wave, size_t begin, size_t end) {
  const FilterContext filter{&frame.world, &frame.scene, wave.rays.data()};
  parallel_for(end - begin, kChunk, [&](size_t chunk_begin, size_t chunk_end) {
    const size_t first = begin + chunk_begin, count = chunk_end - chunk_begin;
    QueryOptions options{.facing = Facing::front};
    if (frame.drawn(wave)) {
      end_at_voxels(frame, wave, first, first + count);
      options.hidden = frame.voxels->drawn();
    }
    if (frame.voxels) options.footprint = footprint_of(frame, wave, first, first + count);
    if (frame.filtered) options.filter = visible_filter(filter);
    options.first_ray = static_cast<uint32_t>(first);
    frame.world.closest_hits({wave.rays.data() + first, count}, {wave.hits.data() + first, count},
                             options);
  });
}

void trace_wave(const FrameContext& frame, AttributeTable& attributes, Wave& wave, Tally& tally) {
  tally.clock.end_shading();
  const size_t done = until(frame.deadline, wave.count,
                            [&](size_t begin, size_t end) { trace_hits(frame, wave, begin, end); });
  tally.clock.end_tracing();
  std::fill(wave.hits.begin() + static_cast<ptrdiff_t>(done),
            wave.hits.begin() + static_cast<ptrdiff_t>(wave.count), Hit{});
  add(tally.traced, count_rays(wave, 0, done));
  add(tally.skipped, count_rays(wave, done, wave.count));
  resolve_wave(frame, attributes, wave);
}

void resolve_wave(const FrameContext& frame, AttributeTable& attributes, Wave& wave) {
  const size_t objects = frame.scene.objects.size(), all = objects + frame.scene.voxels.size();
  for_chunks(wave, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!wave.hits[i]) continue;
      SINEW_CHECK(wave.hits[i].object < all);
      if (wave.hits[i].object < objects) attributes.touch(wave.hits[i].object);
    }
  });
  attributes.refresh();
  for_chunks(wave, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      wave.direct[i] = vec3(0.0f);
      const Hit& hit = wave.hits[i];
      const Path& path = wave.paths[i];
      if (hit && hit.object >= objects) {
        frame.voxels->resolve(frame.world, hit, wave.rays[i], path.cone, wave.surfaces[i]);
      } else if (hit) {
        resolve_surface(frame.scene, frame.textures, attributes.of(hit.object), wave.rays[i],
                        path.cone, hit, wave.surfaces[i]);
      } else if (frame.drawn(wave) && frame.voxels->visibility().keys[path.pixel] != kNothing) {
        frame.voxels->resolve(path.pixel, wave.rays[i], path.cone, wave.surfaces[i]);
      } else {
        wave.surfaces[i].hit = hit;
      }
    }
  });
}

void settle_starts(const FrameContext& frame, Wave& wave, Tally& tally) {
  if (!frame.voxels || !frame.near_triangles) return;
  tally.clock.end_shading();
  for_chunks(wave, [&](size_t, size_t begin, size_t end) {
    Ray rays[kChunk];
    Hit hits[kChunk];
    uint32_t owners[kChunk];
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
      const Surface& surface = wave.surfaces[i];
      if (!is_lit(surface) || !(surface.voxel > 0.0f)) continue;
      owners[count] = static_cast<uint32_t>(i);
      rays[count++] = {.origin = surface.position,
                       .direction = surface.geometric_normal,
                       .t_max = kWithin * surface.footprint};
    }
    if (count == 0) return;
    frame.world.closest_hits({rays, count}, {hits, count}, {.hidden = frame.voxels->all()});
    for (size_t k = 0; k < count; ++k) {
      if (hits[k]) wave.surfaces[owners[k]].footprint = 0.5f * hits[k].t;
    }
  });
  tally.clock.end_tracing();
}

void add_light(const FrameContext& frame, const ShadingLight& light, size_t index, Wave& wave,
               Probes& probes, Tally& tally) {
  const bool shadows = frame.settings.shadows && light.shadows;
  const Highlight highlight = light.falloff ? Highlight::normalized : Highlight::phong;
  probes.resize(wave);
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Surface& surface = wave.surfaces[i];
      if (!is_lit(surface)) continue;
      const Illumination arriving = illuminate(light, surface.position);
      const vec3 view = -normalize(wave.rays[i].direction);
      vec3 reflected = arriving.irradiance * scatter(surface, view, arriving.direction, highlight);
      if (!(largest(reflected) > 0.0f)) continue;
      if (shadows) reflected *= lit_by_voxels(frame, index, surface, arriving.direction);
      if (!(largest(reflected) > 0.0f)) continue;
      if (shadows) {
        probes.push(chunk, shadow_ray(light, surface), static_cast<uint32_t>(i), reflected);
      } else {
        wave.direct[i] += reflected;
      }
    }
  });
  if (!shadows) return;
  const float spread = wave.paths[0].cone.spread;
  trace_probes(frame, wave, frame.voxel_maps, spread, probes, tally.clock, tally.traced.shadow,
               tally.skipped.shadow);
  gather_probes(wave, probes,
                [&](uint32_t owner, vec3 light_in) { wave.direct[owner] += light_in; });
}

void trace_ambient(const FrameContext& frame, uint32_t sample, Wave& wave, Probes& probes,
                   Tally& tally) {
  const uint32_t rays = frame.settings.ambient_rays, points = rays * frame.settings.samples;
  std::fill_n(wave.ambient.begin(), wave.count, rays > 0 ? 0.0f : 1.0f);
  for (uint32_t k = 0; k < rays; ++k) {
    const vec2 point = hammersley(sample * rays + k, points);
    probes.resize(wave);
    for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const Surface& surface = wave.surfaces[i];
        if (!is_lit(surface)) continue;
        const Path& path = wave.paths[i];
        const uint32_t depth =
            (uint32_t{path.mirrors} << 16) | (uint32_t{path.refractions} << 8) | path.layers;
        const uint32_t hash = hash_combine(path.pixel, hash_combine(frame.settings.seed, depth));
        Ray ray;
        ray.origin = leave_before(surface, surface.lifted);
        ray.direction = cosine_direction(surface.normal, shifted(point, hash));
        const float below = dot(ray.direction, surface.geometric_normal);
        if (below < 0.0f) ray.direction -= 2.0f * below * surface.geometric_normal;
        ray.t_max = frame.ambient_distance;
        probes.push(chunk, ray, static_cast<uint32_t>(i), vec3(1.0f / static_cast<float>(rays)));
      }
    });
    trace_probes(frame, wave, false, kAmbientSpread, probes, tally.clock, tally.traced.ambient,
                 tally.skipped.ambient);
    gather_probes(wave, probes, [&](uint32_t owner, vec3 open) {
      wave.ambient[owner] += (open.x + open.y + open.z) / 3.0f;
    });
  }
}

}  // namespace sinew
