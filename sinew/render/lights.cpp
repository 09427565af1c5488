#include "sinew/render/lights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {
namespace {

vec3 unit_or(vec3 v, vec3 fallback) {
  const float l = length(v);
  return l > 0.0f && std::isfinite(l) ? v / l : fallback;
}

ShadingLight place_light(const Light& light, const Affine& node) {
  ShadingLight out;
  out.type = light.type;
  out.position = node[3];
  out.direction = unit_or(-node[2], vec3(0.0f, 0.0f, -1.0f));
  out.intensity = light.color * light.intensity;
  out.range = light.range;
  out.falloff = light.falloff;
  if (light.type == LightType::spot) {
    const float outer = std::cos(light.outer_cone);
    out.cone_scale = 1.0f / std::max(0.001f, std::cos(light.inner_cone) - outer);
    out.cone_offset = -outer * out.cone_scale;
  }
  return out;
}

// Directions follow the camera, so a turning view stays lit; the key is always above.
void add_default_lights(const CameraView& camera, std::vector<ShadingLight>& out) {
  const vec3 right = camera.to_world[0], back = camera.to_world[2], up(0.0f, 1.0f, 0.0f);
  ShadingLight key;
  key.direction = -normalize(-0.55f * right + 0.45f * back + 0.85f * up);
  key.intensity = vec3(2.3f, 2.2f, 2.05f);
  ShadingLight fill;
  fill.direction = -normalize(0.8f * right + 0.5f * back + 0.25f * up);
  fill.intensity = vec3(0.30f, 0.33f, 0.40f);
  fill.shadows = false;
  out.push_back(key);
  out.push_back(fill);
}

}  // namespace

void gather_lights(const Scene& scene, const ScenePose& pose, const CameraView& camera,
                   std::vector<ShadingLight>& out) {
  out.clear();
  bool any = false;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const int32_t index = scene.nodes[i].light;
    if (index < 0) continue;
    any = true;
    if (!pose.visible[i]) continue;
    const Light& light = scene.lights[static_cast<size_t>(index)];
    if (light.intensity > 0.0f) out.push_back(place_light(light, pose.nodes[i]));
  }
  if (!any) add_default_lights(camera, out);
}

Illumination illuminate(const ShadingLight& light, vec3 position) {
  if (light.type == LightType::directional) {
    return {-light.direction, std::numeric_limits<float>::infinity(), light.intensity};
  }
  constexpr float kNearest2 = 1e-4f;  // square metres
  const vec3 to_light = light.position - position;
  const float d2 = dot(to_light, to_light), d = std::sqrt(d2);
  if (!(d > 0.0f)) return {};
  const vec3 direction = to_light / d;
  float scale = light.falloff ? 1.0f / std::max(d2, kNearest2) : 1.0f;
  if (light.range > 0.0f) {
    const float q = d / light.range, q2 = q * q;
    scale *= std::clamp(1.0f - q2 * q2, 0.0f, 1.0f);
  }
  if (light.type == LightType::spot) {
    const float cone = std::clamp(
        -dot(light.direction, direction) * light.cone_scale + light.cone_offset, 0.0f, 1.0f);
    scale *= cone * cone;
  }
  return {direction, d, light.intensity * scale};
}

vec3 environment_radiance(const Environment& environment, vec3 direction) {
  const float y = std::clamp(direction.y, -1.0f, 1.0f);
  return mix(environment.horizon, y > 0.0f ? environment.zenith : environment.nadir, std::abs(y));
}

vec3 environment_ambient(const Environment& environment, vec3 normal) {
  // (1/pi) * integral of max(0, w.y) * max(0, w.n) over the sphere, for n at angle theta from y.
  const auto lobe = [](float cos_theta, float theta) {
    return (2.0f / 3.0f) / 3.14159265f *
           ((3.14159265f - theta) * cos_theta + std::sqrt(1.0f - cos_theta * cos_theta));
  };
  const float y = std::clamp(normal.y, -1.0f, 1.0f), theta = std::acos(y);
  return environment.horizon + (environment.zenith - environment.horizon) * lobe(y, theta) +
         (environment.nadir - environment.horizon) * lobe(-y, 3.14159265f - theta);
}

}  // namespace sinew
