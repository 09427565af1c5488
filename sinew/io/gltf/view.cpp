#include "sinew/io/gltf/view.h"

#include <fmt/format.h>

#include <cmath>

#include "sinew/io/gltf/extras.h"

namespace sinew::gltf {
namespace {

Result<Camera> read_camera(const Json& json) {
  Camera camera;
  SINEW_TRY(camera.name, json.text("name"));
  SINEW_TRY(const std::string type, json.text("type"));
  if (type != "perspective" && type != "orthographic") {
    return json.error(fmt::format("has the unknown type \"{}\"", type));
  }
  camera.orthographic = type == "orthographic";
  SINEW_TRY(const Json lens, json.object(type.c_str()));
  SINEW_TRY(camera.yfov, lens.number("yfov", camera.yfov));
  SINEW_TRY(camera.ymag, lens.number("ymag", camera.ymag));
  camera.ymag = std::abs(camera.ymag);  // some files flip the picture; we do not
  SINEW_TRY(camera.znear, lens.number("znear", camera.znear));
  constexpr float kHalfTurn = 3.14159265f;
  if (!camera.orthographic && !(camera.yfov > 0.0f && camera.yfov < kHalfTurn)) {
    return json.error("\"yfov\" must be above 0 and below pi");
  }
  if (camera.orthographic && camera.ymag == 0.0f) return json.error("\"ymag\" must not be 0");
  if (!(camera.znear >= 0.0f)) return json.error("\"znear\" must not be negative");
  return camera;
}

Result<Light> read_light(const Json& json) {
  Light light;
  SINEW_TRY(light.name, json.text("name"));
  SINEW_TRY(const std::string type, json.text("type"));
  if (type == "directional") {
    light.type = LightType::directional;
  } else if (type == "point") {
    light.type = LightType::point;
  } else if (type == "spot") {
    light.type = LightType::spot;
  } else {
    return json.error(fmt::format("has the unknown type \"{}\"", type));
  }
  SINEW_CHECKED(json.numbers("color", {&light.color.x, 3}));
  SINEW_TRY(light.intensity, json.number("intensity", light.intensity));
  SINEW_TRY(light.range, json.number("range", light.range));
  SINEW_TRY(const Json spot, json.object("spot"));
  SINEW_TRY(light.inner_cone, spot.number("innerConeAngle", light.inner_cone));
  SINEW_TRY(light.outer_cone, spot.number("outerConeAngle", light.outer_cone));
  const bool positive = light.intensity >= 0.0f && light.range >= 0.0f && light.color.x >= 0.0f &&
                        light.color.y >= 0.0f && light.color.z >= 0.0f;
  if (!positive) return json.error("has a negative colour, intensity or range");
  if (extras_of(json).has("sinew_intensity_everywhere")) {
    light.falloff = false;
    SINEW_TRY(light.intensity,
              extras_of(json).number("sinew_intensity_everywhere", light.intensity));
  }
  if (!(light.inner_cone >= 0.0f && light.inner_cone <= light.outer_cone)) {
    return json.error("\"innerConeAngle\" must lie between 0 and \"outerConeAngle\"");
  }
  return light;
}

}  // namespace

Result<void> read_cameras(const Json& root, Scene& scene) {
  SINEW_TRY(const std::vector<Json> cameras, root.objects("cameras", "camera"));
  for (const Json& json : cameras) {
    SINEW_TRY(scene.cameras.emplace_back(), read_camera(json));
  }
  return {};
}

Result<void> read_lights(const Json& root, Scene& scene) {
  SINEW_TRY(const Json extensions, root.object("extensions"));
  SINEW_TRY(const Json extension, extensions.object("KHR_lights_punctual"));
  SINEW_TRY(const std::vector<Json> lights, extension.objects("lights", "light"));
  for (const Json& json : lights) {
    SINEW_TRY(scene.lights.emplace_back(), read_light(json));
  }
  return {};
}

}  // namespace sinew::gltf
