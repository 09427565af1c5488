#include "sinew/render/trace_effects.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/sampling.h"
#include "sinew/render/shade.h"

namespace sinew {
namespace {

constexpr uint16_t kMostLayers = 16;        // blended surfaces that a path passes
constexpr float kLeastMirror = 0.01f;       // share of the pixel for which a mirror ray is traced
constexpr float kLeastBehind = 1.0f / 512;  // ... for which a path goes on behind a blend

// Calls body(chunk, begin, end) for every chunk of the wave's rays, in parallel.
template <class Body>
void for_chunks(const Wave& wave, const Body& body) {
  parallel_for(wave.count, kChunk,
               [&](size_t begin, size_t end) { body(begin / kChunk, begin, end); });
}

bool is_lit(const Surface& surface) {
  return surface.hit && !surface.unlit;
}

float largest(vec3 v) {
  return std::max({v.x, v.y, v.z});
}

// A start for rays that leave the surface to the side of the viewer.
vec3 before(const Surface& surface, vec3 point) {
  return point + surface.geometric_normal * surface.footprint;
}
vec3 behind(const Surface& surface, vec3 point) {
  return point - surface.geometric_normal * surface.footprint;
}

// Finds which probes are blocked, and by how much blends dim the others.
void trace_probes(const FrameContext& frame, const Wave& wave, Probes& probes) {
  const FilterContext filter{&frame.world, &frame.scene, probes.rays.data(),
                             probes.optical_depth.data()};
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t) {
    QueryOptions options{.facing = Facing::back};
    if (frame.filtered) options.filter = shadow_filter(filter);
    options.first_ray = static_cast<uint32_t>(begin);
    const size_t count = probes.count[chunk];
    frame.world.any_hits({probes.rays.data() + begin, count},
                         {probes.blocked.data() + begin, count}, options);
  });
}

// The part of the probe's light that arrives.
float passed(const Probes& probes, size_t slot) {
  return probes.blocked[slot] ? 0.0f : transmittance(probes.optical_depth[slot]);
}

Ray shadow_ray(const ShadingLight& light, const Surface& surface) {
  constexpr float kBeforeLight = 1.0f - 1e-4f;
  Ray ray;
  ray.origin = before(surface, surface.lifted);
  if (light.type == LightType::directional) {
    ray.direction = -light.direction;
    return ray;
  }
  ray.direction = light.position - ray.origin;
  ray.t_max = kBeforeLight;
  return ray;
}

// The reflection of a path, or nothing if it is not worth a ray.
bool make_mirror_ray(const FrameContext& frame, const Surface& surface, vec3 view, float share,
                     float alpha, const Path& path, Ray& ray, Path& out) {
  // A reflected ray does not split again, so that waves cannot grow without limit.
  if (path.bounce >= frame.settings.reflections || (path.bounce > 0 && alpha < 1.0f)) return false;
  out = path;
  out.throughput *= alpha * share * mirror_reflectance(surface, view);
  if (largest(out.throughput) < kLeastMirror) return false;
  ++out.bounce;
  ray.origin = before(surface, surface.position);
  ray.direction = mirror_direction(surface, view);
  return true;
}

// The light that one ray brings to its pixel; pushes the rays that go on.
vec4 shade_surface(const FrameContext& frame, const Wave& wave, size_t index, size_t chunk,
                   Offspring& offspring) {
  const Surface& surface = wave.surfaces[index];
  const Path& path = wave.paths[index];
  const vec3 view = -normalize(wave.rays[index].direction);

  Ray ray;
  Path next = path;
  next.throughput *= 1.0f - surface.alpha;
  ++next.layer;
  const bool goes_on = next.layer <= kMostLayers && largest(next.throughput) >= kLeastBehind;
  const float alpha = goes_on ? surface.alpha : 1.0f;  // what ends here is opaque

  vec3 radiance = surface.emission;
  if (!surface.unlit) {
    Path mirrored;
    float share = mirror_share(surface.roughness);
    if (make_mirror_ray(frame, surface, view, share, alpha, path, ray, mirrored)) {
      offspring.push(chunk, ray, mirrored);
    } else {
      share = 0.0f;
    }
    radiance += wave.direct[index] + scatter_environment(surface, frame.scene.environment, view,
                                                         wave.ambient[index], share);
  }
  if (goes_on) {
    ray = {};
    ray.origin = behind(surface, surface.position);
    ray.direction = wave.rays[index].direction;
    offspring.push(chunk, ray, next);
  }
  const float coverage = path.bounce == 0 ? path.throughput.x * alpha : 0.0f;
  return vec4(path.throughput * alpha * radiance, coverage);
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

double StageClock::lap() {
  using namespace std::chrono;
  const double now = duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
  const double passed_ms = now - last_ms_;
  last_ms_ = now;
  return passed_ms;
}

uint64_t add_light(const FrameContext& frame, const ShadingLight& light, Wave& wave, Probes& probes,
                   StageClock& clock) {
  const bool shadows = frame.settings.shadows && light.shadows;
  probes.resize(wave);
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Surface& surface = wave.surfaces[i];
      if (!is_lit(surface)) continue;
      const Illumination arriving = illuminate(light, surface.position);
      const vec3 view = -normalize(wave.rays[i].direction);
      const vec3 reflected = arriving.irradiance * scatter(surface, view, arriving.direction);
      if (!(largest(reflected) > 0.0f)) continue;
      if (shadows) {
        probes.push(chunk, shadow_ray(light, surface), static_cast<uint32_t>(i), reflected);
      } else {
        wave.direct[i] += reflected;
      }
    }
  });
  if (!shadows) return 0;
  clock.end_shading();
  trace_probes(frame, wave, probes);
  clock.end_tracing();
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t) {
    for (size_t slot = begin; slot < begin + probes.count[chunk]; ++slot) {
      wave.direct[probes.owner[slot]] += probes.light[slot] * passed(probes, slot);
    }
  });
  return probes.total(wave);
}

uint64_t trace_ambient(const FrameContext& frame, uint32_t sample, Wave& wave, Probes& probes,
                       StageClock& clock) {
  const uint32_t rays = frame.settings.ambient_rays, points = rays * frame.settings.samples;
  std::fill_n(wave.ambient.begin(), wave.count, rays > 0 ? 0.0f : 1.0f);
  uint64_t total = 0;
  for (uint32_t k = 0; k < rays; ++k) {
    const vec2 point = hammersley(sample * rays + k, points);
    probes.resize(wave);
    for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const Surface& surface = wave.surfaces[i];
        if (!is_lit(surface)) continue;
        const Path& path = wave.paths[i];
        const uint32_t depth = (uint32_t{path.bounce} << 16) | path.layer;
        const uint32_t hash = hash_combine(path.pixel, hash_combine(frame.settings.seed, depth));
        Ray ray;
        ray.origin = before(surface, surface.lifted);
        ray.direction = cosine_direction(surface.normal, shifted(point, hash));
        const float below = dot(ray.direction, surface.geometric_normal);
        if (below < 0.0f) ray.direction -= 2.0f * below * surface.geometric_normal;
        ray.t_max = frame.ambient_distance;
        probes.push(chunk, ray, static_cast<uint32_t>(i), vec3(1.0f / static_cast<float>(rays)));
      }
    });
    clock.end_shading();
    trace_probes(frame, wave, probes);
    clock.end_tracing();
    for_chunks(wave, [&](size_t chunk, size_t begin, size_t) {
      for (size_t slot = begin; slot < begin + probes.count[chunk]; ++slot) {
        wave.ambient[probes.owner[slot]] += probes.light[slot].x * passed(probes, slot);
      }
    });
    total += probes.total(wave);
  }
  return total;
}

void shade_wave(const FrameContext& frame, Wave& wave, Offspring& offspring) {
  offspring.resize(wave);
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (wave.surfaces[i].hit) {
        wave.result[i] = shade_surface(frame, wave, i, chunk, offspring);
        continue;
      }
      const Path& path = wave.paths[i];
      const vec3 sky =
          environment_radiance(frame.scene.environment, normalize(wave.rays[i].direction));
      const bool background = path.bounce == 0;
      wave.result[i] = background && frame.settings.transparent
                           ? vec4(0.0f)
                           : vec4(path.throughput * sky, background ? path.throughput.x : 0.0f);
    }
  });
}

}  // namespace sinew
