// What every ray of a wave brings to its pixel, and the rays that go on: mirrored, refracted, or
// straight on behind a blend.
// Based on: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
// Differs: only a path that has not been mirrored yet splits, so waves cannot grow without limit.
#include <algorithm>

#include "sinew/math/color.h"
#include "sinew/render/shade.h"
#include "sinew/render/trace_effects.h"

namespace sinew {
namespace {

constexpr uint8_t kMostLayers = 16;         // blended surfaces that a path passes
constexpr float kLeastMirror = 0.01f;       // share of the pixel for which a mirror ray is traced
constexpr float kLeastBehind = 1.0f / 512;  // ... for which a path goes on through a surface

// A path that goes on from a surface.
struct Continuation {
  Ray ray;
  Path path;
};

// One surface on a path, while it is shaded.
struct Encounter {
  const FrameContext& frame;
  const Surface& surface;
  const Path& path;
  vec3 direction;  // of the ray; unit
  vec3 reflectance;

  vec3 view() const { return -direction; }
  bool may_split() const { return path.mirrors == 0; }
};

// Whether the path may go through the surface, and how: the share that takes this way.
struct Passage {
  Continuation next;
  bool traced = false;
  bool reflected = false;  // totally: what a mirror would show comes this way
  vec3 share{0.0f};        // of the light that comes through, if it is not traced
  float covered = 1.0f;    // share of the surface's alpha that what lies behind does not bring
};

// The reflection of the path if it is worth a ray. `share` is what a sharp mirror shows of it.
std::optional<Continuation> mirror(const Encounter& e, float share, float alpha) {
  const bool through = alpha < 1.0f || largest(e.surface.transmitted) > 0.0f;
  if (e.path.mirrors >= e.frame.settings.reflections || (!e.may_split() && through)) return {};
  Continuation out{{}, e.path};
  out.path.throughput *= alpha * share * e.reflectance;
  if (largest(out.path.throughput) < kLeastMirror) return {};
  out.path.cone.width = e.surface.width;
  ++out.path.mirrors;
  out.path.kind = RayKind::reflection;
  out.ray.origin = leave_before(e.surface, e.surface.position);
  out.ray.direction = mirror_direction(e.surface, e.view());
  return out;
}

// The way through a transmissive surface. Light that is totally reflected stays on the same path.
Passage pass_through(const Encounter& e) {
  Passage out;
  out.share = e.surface.transmitted;
  const std::optional<vec3> bent = refracted_direction(e.surface, e.view());
  if (bent) {
    out.share *= 1.0f - e.reflectance;
    out.next.ray.origin = leave_behind(e.surface, e.surface.position);
    out.next.ray.direction = *bent;
  } else {
    out.reflected = true;
    out.next.ray.origin = leave_before(e.surface, e.surface.position);
    out.next.ray.direction = mirror_direction(e.surface, e.view());
  }
  out.next.path = e.path;
  out.next.path.throughput *= out.share;
  out.next.path.cone.width = e.surface.width;
  out.next.path.kind = RayKind::refraction;
  ++out.next.path.refractions;
  out.traced = out.next.path.refractions <= e.frame.settings.refractions &&
               largest(out.next.path.throughput) >= kLeastBehind;
  return out;
}

// The way on behind a blend, straight, for what alpha leaves open and what the material transmits.
Passage pass_blend(const Encounter& e) {
  Passage out;
  const float alpha = e.surface.alpha;
  const vec3 transmitted = e.surface.transmitted * (1.0f - e.reflectance);
  out.share = 1.0f - alpha + alpha * transmitted;
  out.covered = 1.0f - transmitted.x;
  out.next.ray.origin = leave_behind(e.surface, e.surface.position);
  out.next.ray.direction = e.direction;
  out.next.path = e.path;
  out.next.path.throughput *= out.share;
  out.next.path.cone.width = e.surface.width;
  ++out.next.path.layers;
  out.traced =
      out.next.path.layers <= kMostLayers && largest(out.next.path.throughput) >= kLeastBehind;
  return out;
}

// The light that one ray brings to its pixel; pushes the rays that go on.
vec4 shade_surface(const FrameContext& frame, const Wave& wave, size_t index, size_t chunk,
                   Offspring& offspring) {
  const Surface& surface = wave.surfaces[index];
  Path path = wave.paths[index];
  path.throughput *= surface.medium;
  const vec3 direction = normalize(wave.rays[index].direction);
  const Environment& environment = frame.scene.environment;
  const Encounter e{frame, surface, path, direction,
                    surface.unlit ? vec3(0.0f) : mirror_reflectance(surface, -direction)};

  float alpha = surface.alpha;
  Passage passage;
  if (alpha < 1.0f) {
    passage = pass_blend(e);
    if (!passage.traced) {  // what ends here is opaque
      alpha = 1.0f;
      passage = {};
    }
  } else if (largest(surface.transmitted) > 0.0f) {
    passage = pass_through(e);
  }

  vec3 radiance = surface.emission;
  if (!surface.unlit) {
    float traced = 1.0f;  // share of the mirror image that rays bring
    if (!passage.reflected) {
      const float sharp = mirror_share(surface.roughness);
      const auto mirrored = mirror(e, sharp, alpha);
      if (mirrored) offspring.push(chunk, mirrored->ray, mirrored->path);
      traced = mirrored ? sharp : 0.0f;
    }
    radiance += wave.direct[index] +
                scatter_environment(surface, environment, -direction, wave.ambient[index], traced);
  }
  if (passage.traced) {
    offspring.push(chunk, passage.next.ray, passage.next.path);
  } else if (largest(passage.share) > 0.0f) {
    radiance += passage.share * environment_radiance(environment, passage.next.ray.direction);
  }
  const float coverage = path.is_direct() ? path.throughput.x * alpha * passage.covered : 0.0f;
  return vec4(path.throughput * alpha * radiance, coverage);
}

// The light that a ray brings which met nothing.
vec4 shade_background(const FrameContext& frame, const Ray& ray, const Path& path) {
  if (path.is_direct() && frame.settings.transparent) return vec4(0.0f);
  const vec3 sky = environment_radiance(frame.scene.environment, normalize(ray.direction));
  return vec4(path.throughput * sky, path.is_direct() ? path.throughput.x : 0.0f);
}

}  // namespace

void shade_wave(const FrameContext& frame, Wave& wave, Offspring& offspring) {
  offspring.resize(wave);
  for_chunks(wave, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      wave.result[i] = wave.surfaces[i].hit ? shade_surface(frame, wave, i, chunk, offspring)
                                            : shade_background(frame, wave.rays[i], wave.paths[i]);
    }
  });
}

}  // namespace sinew
