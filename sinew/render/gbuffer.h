// The G-buffer: what shading needs to know about the surface that each ray met.
// Both sides of a surface shade alike: normals are turned towards the ray.
#pragma once

#include <cstdint>

#include "sinew/math/ray.h"
#include "sinew/render/attributes.h"
#include "sinew/render/texture.h"
#include "sinew/scene/scene.h"

namespace sinew {

// One entry a ray. Colours are linear.
struct Surface {
  vec3 position{0.0f};          // world
  vec3 lifted{0.0f};            // position raised to the smooth surface that the vertex normals
                                // suggest: where shadow and ambient rays start
  vec3 normal{0.0f};            // world, unit, shading normal (normal map applied), towards the ray
  vec3 geometric_normal{0.0f};  // world, unit, of the triangle, towards the ray
  vec3 albedo{0.0f};            // diffuse reflectance
  vec3 specular{0.0f};          // reflectance at normal incidence
  float grazing = 1.0f;         // reflectance at grazing incidence, if smooth
  vec3 transmitted{0.0f};       // share of what is not reflected that passes through
  vec3 emission{0.0f};
  float roughness = 1.0f;
  float alpha = 1.0f;  // opacity after mask and blend
  float occlusion = 1.0f;
  float width = 0.0f;        // of the ray cone, metres
  float footprint = 0.0f;    // distance by which to leave the surface for secondary rays
  float voxel = 0.0f;        // diagonal of the voxel that was met, metres; 0: it is no voxel
  float bend = 1.0f;         // index of refraction on the ray's side over that on the other side
  vec3 medium{1.0f};         // share of light that the matter which the ray came through has left
  bool from_behind = false;  // the ray met the triangle's back
  bool unlit = false;
  Hit hit;  // false: the ray left the scene
};

// Reflectance at normal incidence where the material is no metal.
vec3 dielectric_reflectance(const Material& material);

// Base colour factor times vertex colour times texture at the very point of the hit: linear RGB,
// alpha.
vec4 base_color(const Scene& scene, const Mesh& mesh, const Hit& hit);

// The share of light that passes straight through at the hit: what alpha leaves open, and what a
// transmissive material lets through.
vec3 transparency(const Scene& scene, const TextureTable& textures, const Mesh& mesh,
                  const Hit& hit);

// A ray as wide as what it stands for.
// Based on: T. Akenine-Moller et al., "Texture Level of Detail Strategies for Real-Time Ray
// Tracing", Ray Tracing Gems, chapter 20 (2019), without the curvature of mirrors.
struct RayCone {
  float width = 0.0f;   // at the ray's origin, metres
  float spread = 0.0f;  // by which it widens in a metre
};

// The surface that `ray` met at `hit` (which must be true) on the object with these attributes.
// Textures are averaged over the cone.
void resolve_surface(const Scene& scene, const TextureTable& textures,
                     const ObjectAttributes& object, const Ray& ray, const RayCone& cone,
                     const Hit& hit, Surface& out);

}  // namespace sinew
