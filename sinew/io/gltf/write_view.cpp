#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/io/gltf/write_node.h"
#include "sinew/scene/names.h"
#include "sinew/scene/sample.h"

namespace sinew::gltf {
namespace {

constexpr float kNearest = 1e-3f;  // metres: glTF wants a near plane in front of the eye
constexpr float kFarthest = 1e4f;  // metres: where orthographic cameras end, which ours do not

JsonOut write_camera(const Camera& camera) {
  JsonOut out = named(camera.name);
  const float znear = std::max(camera.znear, camera.orthographic ? 0.0f : kNearest);
  if (camera.orthographic) {
    out["type"] = "orthographic";
    out["orthographic"] = {{"xmag", double{camera.ymag}},
                           {"ymag", double{camera.ymag}},
                           {"zfar", double{std::max(kFarthest, 2.0f * znear)}},
                           {"znear", double{znear}}};
  } else {
    out["type"] = "perspective";
    out["perspective"] = {{"yfov", double{camera.yfov}}, {"znear", double{znear}}};
  }
  return out;
}

// For each light its distance from the middle of the scene at rest, at least a centimetre; 1 where
// no node has it.
std::vector<float> light_distances(const Scene& scene) {
  std::vector<float> result(scene.lights.size(), 1.0f);
  ScenePose pose;
  sample(scene, kRestPose, 0.0, pose);
  const Box box = animation_bounds(scene, kRestPose, 1);
  const vec3 middle = box.empty() ? vec3(0.0f) : 0.5f * (box.min + box.max);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const int32_t light = scene.nodes[i].light;
    if (light >= 0) {
      result[static_cast<size_t>(light)] = std::max(0.01f, length(pose.nodes[i][3] - middle));
    }
  }
  return result;
}

JsonOut write_light(const WriteContext& context, const Light& light, float distance) {
  JsonOut out = named(light.name);
  out["type"] = name_of(light.type);
  // glTF's colours end at 1.
  const vec3 color = glm::max(light.color, vec3(0.0f));
  const float brightest = std::max({color.x, color.y, color.z, 1.0f});
  out["color"] = json_of(glm::min(color / brightest, vec3(1.0f)));
  float intensity = std::max(light.intensity, 0.0f) * brightest;
  if (light.type != LightType::directional && !light.falloff) {
    if (!context.embedded) {
      context.warnings.add(
          element("light", light.name),
          "shines equally at all distances, which glTF cannot say; other programs see "
          "a light that is as bright in the middle of the scene");
    }
    out["extras"] = {{"sinew_intensity_everywhere", double{intensity}}};
    intensity *= distance * distance;
  }
  out["intensity"] = double{std::min(intensity, std::numeric_limits<float>::max())};
  if (light.range > 0.0f && light.type != LightType::directional) {
    out["range"] = double{light.range};
  }
  if (light.type == LightType::spot) {
    constexpr float kRightAngle = 1.57079633f;
    const float outer = std::clamp(light.outer_cone, 1e-4f, kRightAngle - 1e-6f);
    const float inner = std::clamp(light.inner_cone, 0.0f, std::nextafter(outer, 0.0f));
    out["spot"] = {{"innerConeAngle", double{inner}}, {"outerConeAngle", double{outer}}};
  }
  return out;
}

}  // namespace

void write_cameras(const WriteContext& context) {
  for (const Camera& camera : context.scene.cameras) {
    context.asset.add("cameras", write_camera(camera));
  }
}

void write_lights(const WriteContext& context) {
  const std::vector<Light>& lights = context.scene.lights;
  if (lights.empty()) return;
  const std::vector<float> distances = light_distances(context.scene);
  context.asset.use_extension("KHR_lights_punctual");
  JsonOut& out = context.asset.root()["extensions"]["KHR_lights_punctual"]["lights"];
  for (size_t i = 0; i < lights.size(); ++i) {
    out.push_back(write_light(context, lights[i], distances[i]));
  }
}

}  // namespace sinew::gltf
