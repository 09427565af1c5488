// Lights as shading sees them: punctual lights of the scene (or a default set), and the
// environment, a vertical gradient.
// Based on: KHR_lights_punctual (range window, spot cones; its photometric units are taken as
// plain radiometric ones: lux is irradiance, candela is intensity).
#pragma once

#include <vector>

#include "sinew/render/camera.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct ShadingLight {
  LightType type = LightType::directional;
  vec3 position{0.0f};      // point and spot; world
  vec3 direction{0.0f};     // where it shines to; directional and spot; world, unit
  vec3 intensity{0.0f};     // colour times lux or candela
  float range = 0.0f;       // metres; 0: no limit
  bool falloff = true;      // point and spot: with the square of the distance
  float cone_scale = 0.0f;  // spot: attenuation = clamp(cos * cone_scale + cone_offset)^2
  float cone_offset = 1.0f;
  bool shadows = true;
};

// What arrives at a point.
struct Illumination {
  vec3 direction{0.0f};   // towards the light, unit
  float distance = 0.0f;  // to the light; infinite for directional lights
  vec3 irradiance{0.0f};  // on a surface that faces the light
};

// The visible lights of the scene that shine at all. A scene without lights gets a key light from
// the upper left behind the camera and, without shadows, a weak fill from the right.
void gather_lights(const Scene& scene, const ScenePose& pose, const CameraView& camera,
                   std::vector<ShadingLight>& out);

// Nearer than a centimetre a point light grows no brighter.
Illumination illuminate(const ShadingLight& light, vec3 position);

// Radiance from a unit direction: linear in the sine of the elevation from horizon to zenith and
// to nadir.
vec3 environment_radiance(const Environment& environment, vec3 direction);

// Cosine-weighted mean of the radiance over the hemisphere about the unit normal: what a white
// diffuse surface reflects of what rays see of the environment. Exact.
vec3 environment_ambient(const Environment& environment, vec3 normal);

}  // namespace sinew
