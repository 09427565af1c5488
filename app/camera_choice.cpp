#include "app/camera_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "app/values.h"

namespace sinew::app {
namespace {

constexpr float kOrbitFov = 35.0f;  // degrees
constexpr int kBoundsSamples = 24;  // times of the clip that framing looks at
constexpr float kDegree = std::numbers::pi_v<float> / 180.0f;

tl::unexpected<Error> bad_camera(std::string_view text, std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, "", fmt::format("--camera '{}'", text), std::move(problem),
               std::move(remedy)});
}

struct Setting {
  std::string_view key;
  std::vector<double> numbers;
};

// "eye=1,2,3,fov=40" -> eye: 1 2 3; fov: 40. A comma begins a new key unless a number follows.
std::optional<std::vector<Setting>> parse_settings(std::string_view text) {
  std::vector<Setting> settings;
  while (!text.empty()) {
    const size_t comma = std::min(text.find(','), text.size());
    std::string_view part = text.substr(0, comma);
    if (const size_t equals = part.find('='); equals != part.npos) {
      settings.push_back({part.substr(0, equals), {}});
      part.remove_prefix(equals + 1);
    }
    const auto number = parse_number(part);
    if (!number || settings.empty()) return std::nullopt;
    settings.back().numbers.push_back(*number);
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return settings;
}

vec3 to_vec3(const std::vector<double>& v) {
  return vec3(glm::dvec3(v[0], v[1], v[2]));
}

Result<CameraChoice> parse_look_at(std::string_view text, const std::vector<Setting>& settings) {
  constexpr const char* kRemedy = "write eye=4,2,6,target=0,1,0,fov=40";
  LookAtCamera camera;
  bool has_eye = false, has_target = false;
  for (const auto& [key, numbers] : settings) {
    if (key == "eye" && numbers.size() == 3) {
      camera.eye = to_vec3(numbers);
      has_eye = true;
    } else if (key == "target" && numbers.size() == 3) {
      camera.target = to_vec3(numbers);
      has_target = true;
    } else if (key == "fov" && numbers.size() == 1) {
      camera.fov = static_cast<float>(numbers[0]);
    } else {
      return bad_camera(
          text, fmt::format("'{}' with {} numbers makes no sense", key, numbers.size()), kRemedy);
    }
  }
  if (!has_eye || !has_target) return bad_camera(text, "needs an eye and a target", kRemedy);
  if (!(camera.fov > 0.1f && camera.fov < 179.0f)) {
    return bad_camera(text, "the field of view is out of range", "give 0.1 to 179 degrees");
  }
  if (!(length(camera.eye - camera.target) > 0.0f)) {
    return bad_camera(text, "eye and target are the same point", kRemedy);
  }
  return camera;
}

Result<CameraChoice> parse_orbit(std::string_view text, const std::vector<double>& numbers) {
  constexpr const char* kRemedy = "write orbit=35,18 or orbit=35,18,1.5";
  if (numbers.size() < 2 || numbers.size() > 3) {
    return bad_camera(text, "needs an azimuth and an elevation in degrees", kRemedy);
  }
  OrbitCamera camera;
  camera.azimuth = static_cast<float>(std::remainder(numbers[0], 360.0));
  camera.elevation = static_cast<float>(numbers[1]);
  if (numbers.size() == 3) camera.zoom = static_cast<float>(numbers[2]);
  if (!(std::abs(camera.elevation) <= 90.0f)) {
    return bad_camera(text, "the elevation is out of range", "give -90 to 90 degrees");
  }
  if (!(camera.zoom >= 0.001f && camera.zoom <= 1000.0f)) {
    return bad_camera(text, "the zoom is out of range", "give 0.001 to 1000");
  }
  return camera;
}

// +Y is up unless the camera looks along it.
vec3 up_for(vec3 direction) {
  const bool vertical = std::abs(direction.y) > 0.9999f * length(direction);
  return vertical ? vec3(0.0f, 0.0f, direction.y > 0.0f ? -1.0f : 1.0f) : vec3(0.0f, 1.0f, 0.0f);
}

Result<CameraView> orbit_view(const OrbitCamera& camera, const Scene& scene, int clip,
                              float aspect) {
  const Box box = animation_bounds(scene, clip, clip == kRestPose ? 1 : kBoundsSamples);
  if (box.empty()) {
    return fail({ErrorKind::bad_input, scene.name, "", "nothing can be seen in it",
                 "choose another clip or give --camera eye=...,target=..."});
  }
  // A hair from the vertical, so that up stays defined.
  const float elevation = std::clamp(camera.elevation, -89.9f, 89.9f) * kDegree;
  const float azimuth = camera.azimuth * kDegree;
  const vec3 direction(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                       std::cos(azimuth) * std::cos(elevation));
  CameraView view = frame_box(box, direction, kOrbitFov * kDegree, aspect);
  const vec3 center = box.center();
  view.to_world[3] = center + (view.to_world[3] - center) / camera.zoom;
  return view;
}

Result<int> find_camera(const Scene& scene, const std::string& name) {
  const auto& cameras = scene.cameras;
  std::string list;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].name == name) return static_cast<int>(i);
    list += fmt::format("{}{} '{}'", i ? ", " : "", i, cameras[i].name);
  }
  size_t index = 0;
  const char* end = name.data() + name.size();
  const auto [stop, status] = std::from_chars(name.data(), end, index);
  if (status == std::errc() && stop == end && index < cameras.size()) {
    return static_cast<int>(index);
  }
  return bad_camera(name,
                    list.empty() ? "the file has no cameras" : "the file's cameras are " + list,
                    "give one of them, eye=x,y,z,target=x,y,z or orbit=azimuth,elevation");
}

}  // namespace

Result<CameraChoice> parse_camera(std::string_view text) {
  const auto means = [&](std::string_view key) { return text.starts_with(key); };
  if (!means("eye=") && !means("target=") && !means("fov=") && !means("orbit=")) {
    return FileCamera{std::string(text)};
  }
  const auto settings = parse_settings(text);
  if (!settings) {
    return bad_camera(text, "holds something that is not a number",
                      "write eye=4,2,6,target=0,1,0,fov=40 or orbit=35,18");
  }
  if (!means("orbit=")) return parse_look_at(text, *settings);
  if (settings->size() != 1) {
    return bad_camera(text, "orbit stands alone", "write orbit=azimuth,elevation,zoom");
  }
  return parse_orbit(text, settings->front().numbers);
}

Result<FrameCamera> FrameCamera::choose(const CameraChoice& choice, const Scene& scene, int clip,
                                        float aspect) {
  FrameCamera camera;
  OrbitCamera orbit;
  if (const auto* look = std::get_if<LookAtCamera>(&choice)) {
    camera.fixed_ =
        look_at(look->eye, look->target, up_for(look->eye - look->target), look->fov * kDegree);
    return camera;
  }
  if (const auto* file = std::get_if<FileCamera>(&choice)) {
    if (!file->name.empty()) {
      SINEW_TRY(camera.index_, find_camera(scene, file->name));
      return camera;
    }
    if (!scene.cameras.empty()) {
      camera.index_ = 0;
      return camera;
    }
  } else {
    orbit = std::get<OrbitCamera>(choice);
  }
  SINEW_TRY(camera.fixed_, orbit_view(orbit, scene, clip, aspect));
  return camera;
}

CameraView FrameCamera::view(const Scene& scene, const ScenePose& pose) const {
  if (index_ < 0) return fixed_;
  return scene_camera(scene, pose, static_cast<uint32_t>(index_));
}

}  // namespace sinew::app
