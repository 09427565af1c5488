#include "sinew/render/shade.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr float kPi = 3.14159265f;

float pow5(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

// Cosine of the refracted direction to the normal; negative: total reflection.
float refracted_cosine(const Surface& surface, vec3 view) {
  const float cosine = std::clamp(dot(surface.normal, view), 0.0f, 1.0f);
  const float square = 1.0f - surface.bend * surface.bend * (1.0f - cosine * cosine);
  return square > 0.0f ? std::sqrt(square) : -1.0f;
}

// Schlick's term wants the angle on the side of the thinner medium; 0 at total reflection.
float thin_side_cosine(const Surface& surface, vec3 view) {
  if (surface.bend > 1.0f) return std::max(refracted_cosine(surface, view), 0.0f);
  return std::clamp(dot(surface.normal, view), 0.0f, 1.0f);
}

}  // namespace

float phong_exponent(float roughness) {
  const float alpha = roughness * roughness;
  return std::min(2.0f / std::max(alpha * alpha, 1e-6f) - 2.0f, 2048.0f);
}

vec3 scatter(const Surface& surface, vec3 view, vec3 to_light, Highlight highlight) {
  const float n_l = dot(surface.normal, to_light);
  if (!(n_l > 0.0f)) return vec3(0.0f);
  const vec3 half = normalize(view + to_light);
  const float exponent = phong_exponent(surface.roughness);
  const vec3 fresnel = surface.specular + (1.0f - surface.specular) *
                                              pow5(1.0f - std::clamp(dot(view, half), 0.0f, 1.0f));
  const float peak = highlight == Highlight::phong ? 1.0f : (exponent + 8.0f) / 8.0f;
  const float lobe =
      peak / kPi * std::pow(std::clamp(dot(surface.normal, half), 0.0f, 1.0f), exponent);
  return (surface.albedo / kPi * (1.0f - fresnel) + fresnel * lobe) * n_l;
}

vec3 mirror_reflectance(const Surface& surface, vec3 view) {
  // Rough surfaces brighten less towards grazing angles: their ceiling is 1 - roughness.
  const vec3 ceiling = max(vec3(1.0f - surface.roughness), surface.specular);
  const float grazing = pow5(1.0f - thin_side_cosine(surface, view));
  return surface.specular + (ceiling - surface.specular) * grazing;
}

float mirror_share(float roughness) {
  const float x = std::clamp((0.35f - roughness) / 0.15f, 0.0f, 1.0f);
  return x * x * (3.0f - 2.0f * x);
}

vec3 mirror_direction(const Surface& surface, vec3 view) {
  constexpr float kLeast = 1e-3f;  // cosine to the triangle's normal
  const vec3 d = 2.0f * dot(surface.normal, view) * surface.normal - view;
  const float out = dot(d, surface.geometric_normal);
  return out >= kLeast ? d : normalize(d + (kLeast - out) * surface.geometric_normal);
}

std::optional<vec3> refracted_direction(const Surface& surface, vec3 view) {
  constexpr float kLeast = 1e-3f;  // cosine to the triangle's normal
  const float behind = refracted_cosine(surface, view);
  if (behind < 0.0f) return {};
  const float before = std::clamp(dot(surface.normal, view), 0.0f, 1.0f);
  const vec3 d = (surface.bend * before - behind) * surface.normal - surface.bend * view;
  const float out = -dot(d, surface.geometric_normal);
  return out >= kLeast ? d : normalize(d - (kLeast - out) * surface.geometric_normal);
}

vec3 scatter_environment(const Surface& surface, const Environment& environment, vec3 view,
                         float ambient, float traced_share) {
  const vec3 reflectance = mirror_reflectance(surface, view);
  const float open = ambient * surface.occlusion;
  vec3 radiance = surface.albedo * (1.0f - reflectance) *
                  environment.ambient.value_or(environment_ambient(environment, surface.normal)) *
                  open;
  if (traced_share < 1.0f) {
    const vec3 direction = mirror_direction(surface, view);
    const vec3 blurred = mix(environment_radiance(environment, direction),
                             environment_ambient(environment, direction), surface.roughness);
    radiance += reflectance * (1.0f - traced_share) * blurred * open;
  }
  return radiance;
}

}  // namespace sinew
