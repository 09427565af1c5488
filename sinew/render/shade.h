// How a surface scatters light: Blinn-Phong, energy-normalised, with Schlick's Fresnel term.
// Based on: T. Akenine-Moller, E. Haines, N. Hoffman, "Real-Time Rendering", 3rd ed., section 7.6
// (normalisation (n + 8) / (8 pi)); C. Schlick, "An Inexpensive BRDF Model", 1994; glTF 2.0,
// appendix B for what the parameters mean.
#pragma once

#include <optional>

#include "sinew/render/gbuffer.h"
#include "sinew/render/lights.h"

namespace sinew {

// Phong exponent of a roughness: 2 / alpha^2 - 2, alpha = roughness^2, at most 2048 so that the
// highlight of a punctual light stays wider than a few pixels and makes no fireflies.
float phong_exponent(float roughness);

// How bright the middle of a highlight is: all of them hold the same energy, so that sharp ones are
// bright; or, as Phong has it, all are equally bright, which is what scenes of old (NFF, AFF) mean.
enum class Highlight : uint8_t { normalized, phong };

// Reflected radiance for unit irradiance on a surface that faces the light: BRDF times the cosine.
// Unit vectors, away from the surface.
vec3 scatter(const Surface& surface, vec3 view, vec3 to_light,
             Highlight highlight = Highlight::normalized);

// Share of light that is reflected as from a (blurred) mirror, seen from `view`. Where light would
// leave a denser medium too obliquely all of it is reflected, but for roughness.
vec3 mirror_reflectance(const Surface& surface, vec3 view);

// How much of the mirror reflectance is sharp enough for a ray: 1 up to roughness 0.2, 0 from 0.35.
float mirror_share(float roughness);

// Reflection of the view direction about the shading normal, bent to leave the triangle's plane.
vec3 mirror_direction(const Surface& surface, vec3 view);

// Where light seen from `view` comes from behind a transmissive surface: Snell's law about the
// shading normal, bent to stay behind the triangle's plane. Nothing: total reflection.
std::optional<vec3> refracted_direction(const Surface& surface, vec3 view);

// Radiance of the environment, diffusely reflected and, for the share that no mirror ray brings,
// blurred by roughness. `ambient` is the unoccluded part of the surroundings, 0..1.
vec3 scatter_environment(const Surface& surface, const Environment& environment, vec3 view,
                         float ambient, float traced_share);

}  // namespace sinew
