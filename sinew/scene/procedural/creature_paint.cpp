#include "sinew/scene/procedural/creature_paint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/creature_skeleton.h"
#include "sinew/scene/procedural/noise.h"

namespace sinew {
namespace {

// Linear colours.
constexpr vec3 kJade(0.085f, 0.300f, 0.165f);
constexpr vec3 kNight(0.010f, 0.070f, 0.085f);
constexpr vec3 kCream(0.720f, 0.540f, 0.270f);
constexpr vec3 kAmber(0.640f, 0.210f, 0.040f);

// Leather of bumps: their height's slope in space, and the shade of the grooves between them.
struct Bumps {
  vec3 slope{0.0f};
  float groove = 0.0f;  // 1 in grooves
  uint32_t id = 0;
};

// Pebbled scales, `frequency` a metre.
Bumps scales(vec3 p, float frequency) {
  const Cells cells = cellular_noise(frequency * p, 0.85f, 77);
  Bumps bumps;
  const float gap = cells.second - cells.nearest;  // 0 in a groove
  bumps.id = cells.id;
  bumps.groove = 1.0f - glm::smoothstep(0.02f, 0.24f, gap);
  // Height rises from the groove and levels off; d gap / d p from the two directions.
  const vec3 gap_slope = cells.to_nearest / std::max(cells.nearest, 1e-4f) -
                         cells.to_second / std::max(cells.second, 1e-4f);
  bumps.slope = gap_slope * (gap < 0.34f ? 1.0f - gap / 0.34f : 0.0f);
  return bumps;
}

// Broad plates across the belly, one behind the other along z.
Bumps scutes(vec3 p) {
  constexpr float kPitch = 0.062f;
  const float bend = 0.10f * p.x * p.x / kPitch;
  const float s = (p.z + bend * kPitch) / kPitch;
  const float t = s - std::floor(s);
  Bumps bumps;
  bumps.id = static_cast<uint32_t>(static_cast<int>(std::floor(s)));
  const float edge = std::min(t, 1.0f - t);
  bumps.groove = 1.0f - glm::smoothstep(0.02f, 0.16f, edge);
  bumps.slope = vec3(0.0f, 0.0f, (t < 0.5f ? 1.0f : -1.0f) * std::max(0.0f, 1.0f - edge / 0.22f));
  return bumps;
}

vec3 skin_color(vec3 p, const SkinRegion& region, const Bumps& bumps) {
  const float cloud = fractal_noise(3.2f * p, 4, 3);
  const float fine = fractal_noise(21.0f * p, 2, 4);
  vec3 color = glm::mix(kJade, kNight, glm::smoothstep(0.10f, 0.95f, region.back + 0.45f * cloud));
  // Stripes down the flanks, broken by noise, wider towards the back.
  const float wave = std::sin(21.0f * p.z + 5.0f * cloud + 2.5f * std::abs(p.x));
  const float stripe =
      glm::smoothstep(0.30f, 0.75f, wave + 0.35f * region.back - 0.55f * region.leg);
  color = glm::mix(color, kNight, 0.80f * stripe * (1.0f - region.belly));
  // Amber freckles on the flanks and legs.
  const Cells dots = cellular_noise(9.5f * p, 0.9f, 15);
  const float size = 0.12f + 0.26f * unit_float(hash_u32(dots.id));
  const float dot_mask = glm::smoothstep(size, 0.55f * size, dots.nearest) *
                         glm::smoothstep(0.9f, 0.45f, region.back) * (1.0f - region.belly);
  color = glm::mix(color, kAmber, 0.75f * dot_mask);
  color = glm::mix(color, kNight, 0.55f * region.hand);
  const float belly = glm::smoothstep(0.35f, 0.65f, region.belly + 0.12f * cloud);
  color = glm::mix(color, kCream * (0.92f + 0.25f * cloud), belly);
  const float variety = 0.86f + 0.28f * unit_float(hash_u32(bumps.id));
  return color * variety * (1.0f + 0.25f * fine) * (1.0f - 0.45f * bumps.groove);
}

template <class T>
T interpolate(const std::vector<T>& values, uvec3 t, vec3 b) {
  return b.x * values[t.x] + b.y * values[t.y] + b.z * values[t.z];
}

SkinRegion interpolate(const std::vector<SkinRegion>& regions, uvec3 t, vec3 b) {
  const auto mix = [&](float SkinRegion::*m) {
    return b.x * regions[t.x].*m + b.y * regions[t.y].*m + b.z * regions[t.z].*m;
  };
  return {mix(&SkinRegion::belly), mix(&SkinRegion::back), mix(&SkinRegion::leg),
          mix(&SkinRegion::hand)};
}

}  // namespace

std::vector<SkinRegion> skin_regions(const ImplicitMesh& body,
                                     const std::vector<SkinWeights>& weights) {
  std::vector<SkinRegion> regions(body.normals.size());
  parallel_for(regions.size(), 2048, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      SkinRegion& region = regions[v];
      for (uint32_t k = 0; k < SkinWeights::kInfluences; ++k) {
        const uint32_t joint = weights[v].joints[k];
        if (joint < kLegs) continue;
        region.leg += weights[v].weights[k];
        if ((joint - kLegs) % kLegJoints >= kFoot) region.hand += weights[v].weights[k];
      }
      const float up = body.normals[v].y;
      // On the head only the jaw and lips count, not the underside of the brow.
      const vec3 p = body.surface.positions[v];
      const float low = p.z < 0.62f ? 1.0f : glm::smoothstep(0.97f, 0.92f, p.y);
      region.belly = glm::smoothstep(-0.35f, -0.80f, up) * (1.0f - region.leg) * low;
      region.back = glm::smoothstep(0.0f, 0.95f, up) * (1.0f - 0.6f * region.leg);
    }
  });
  return regions;
}

PaintedTextures paint_skin(const ImplicitMesh& body, const std::vector<SkinRegion>& regions,
                           const Unwrapping& unwrapping, uint32_t resolution) {
  const std::vector<uvec3>& triangles = body.surface.triangles;
  return paint_surface(
      unwrapping, body.surface.positions, triangles, resolution, [&](const SurfacePoint& at) {
        const uvec3 t = triangles[at.triangle];
        const vec3 p = interpolate(body.surface.positions, t, at.barycentric);
        const vec3 n = normalize(interpolate(body.normals, t, at.barycentric));
        const SkinRegion region = interpolate(regions, t, at.barycentric);
        const bool underside = region.belly > 0.55f;
        const Bumps bumps = underside ? scutes(p) : scales(p, 40.0f);
        const vec3 slope = bumps.slope - dot(bumps.slope, n) * n;
        Paint paint;
        paint.color = skin_color(p, region, bumps);
        paint.normal =
            vec3(-0.38f * dot(slope, at.tangent), -0.38f * dot(slope, at.bitangent), 1.0f);
        return paint;
      });
}

Image8 paint_eye(uint32_t resolution) {
  return paint_image(resolution, resolution, [](float u, float v) {
    const vec2 d = 2.0f * vec2(u - 0.5f, v - 0.5f);
    const float r = length(d), angle = std::atan2(d.y, d.x);
    const float rays =
        fractal_noise(vec3(3.0f * std::cos(angle), 3.0f * std::sin(angle), 2.0f * r), 3, 1);
    const float iris = glm::smoothstep(0.70f, 0.64f, r);
    const float rim = glm::smoothstep(0.48f, 0.66f, r);
    vec3 color = glm::mix(vec3(0.95f, 0.62f, 0.06f), vec3(0.62f, 0.16f, 0.01f),
                          glm::clamp(rim + 0.8f * rays, 0.0f, 1.0f));
    // An upright, slightly pointed pupil.
    const float pupil =
        glm::smoothstep(1.0f, 0.85f, std::abs(d.x) / 0.20f + d.y * d.y / (0.50f * 0.50f));
    color = glm::mix(color, vec3(0.004f), pupil);
    return glm::mix(vec3(0.10f, 0.06f, 0.04f), color, iris);
  });
}

}  // namespace sinew
