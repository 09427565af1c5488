// The G-buffer: what shading needs to know about the surface that each ray met.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/ray.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"
#include "sinew/world/world.h"

namespace sinew {

// One entry a ray. Colours are linear.
struct Surface {
  vec3 position{0.0f};            // world
  vec3 normal{0.0f};              // world, unit, shading normal (normal map applied), towards the ray
  vec3 geometric_normal{0.0f};    // world, unit, of the triangle, towards the ray
  vec3 albedo{0.0f};              // diffuse reflectance
  vec3 specular{0.0f};            // reflectance at normal incidence
  vec3 emission{0.0f};
  float roughness = 1.0f;
  float alpha = 1.0f;             // opacity after mask and blend
  float occlusion = 1.0f;
  float footprint = 0.0f;         // distance by which to leave the surface for secondary rays
  bool unlit = false;
  Hit hit;                        // false: the ray left the scene
};

}  // namespace sinew
