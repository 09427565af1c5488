// Views, lights, fills, the background and the timing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/io/aff/reader.h"

namespace sinew::aff {
namespace {

constexpr float kPi = 3.14159265f;
constexpr int64_t kMostFrames = 1'000'000;

bool is_direction(vec3 v) {
  const float l = length(v);
  return l > 0.0f && std::isfinite(l);
}

// Looks from `from` to `at`, whose distance is not 0; an `up` that says nothing gives any.
quat look_along(vec3 direction, vec3 up) {
  const vec3 back = -normalize(direction);
  vec3 right = cross(up, back);
  if (!(length(right) > 1e-6f * length(up))) {
    right = cross(std::abs(back.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, 1.0f), back);
  }
  right = normalize(right);
  return normalize(glm::quat_cast(mat3(right, cross(back, right), back)));
}

}  // namespace

Result<bool> Reader::read_setting(std::string_view statement, Words& words) {
  Result<void> done;
  if (statement == "v") {
    done = read_view(words);
  } else if (statement == "l" || statement == "la") {
    done = read_light(words, statement == "la");
  } else if (statement == "f" || statement == "fm") {
    done = read_fill(words, statement == "fm");
  } else if (statement == "b") {
    done = read_background(words);
  } else if (statement == "am") {
    done = words.vector(ambient_light_);
  } else if (statement == "a") {
    done = read_timing(words);
  } else {
    return false;
  }
  return done.map([] { return true; });
}

// The angle is from the bottom to the top of the picture.
Result<void> Reader::read_view(Words& words) {
  vec3 from, at, up;
  double angle = 0.0, hither = 0.0, resolution[2];
  const uint64_t line = words.line();
  SINEW_CHECKED(words.expect("from"));
  SINEW_CHECKED(words.vector(from));
  SINEW_CHECKED(words.expect("at"));
  SINEW_CHECKED(words.vector(at));
  SINEW_CHECKED(words.expect("up"));
  SINEW_CHECKED(words.vector(up));
  SINEW_CHECKED(words.expect("angle"));
  SINEW_CHECKED(words.number(angle));
  if (!(angle > 0.0 && angle < 180.0)) {
    return words.error(fmt::format("the view's angle is {} degrees", angle),
                       "give one between 0 and 180");
  }
  SINEW_CHECKED(words.expect("hither"));
  SINEW_CHECKED(words.number(hither));
  SINEW_CHECKED(words.expect("resolution"));
  SINEW_CHECKED(words.numbers(resolution));
  if (!is_direction(at - from) || !is_direction(up)) {
    return words.error(fmt::format("the view of line {} has no direction", line),
                       "let it look at another point than its own");
  }
  if (!scene_.cameras.empty()) {
    return words.error("there is a second view", "give one");
  }
  Camera& camera = scene_.cameras.emplace_back();
  camera.name = "camera";
  camera.yfov = static_cast<float>(glm::radians(angle));
  camera.znear = std::max(static_cast<float>(hither), 0.0f);
  Node node;
  node.name = camera.name;
  node.translation = from;
  node.rotation = look_along(at - from, up);
  node.camera = 0;
  SINEW_TRY(const uint32_t index, add_node(std::move(node), words));
  content_.named_nodes.push_back({"camera", index});
  return {};
}

// "l x y z [r g b]", "la name x y z [r g b]". A surface that faces the light reflects Kd times its
// colour, at every distance; our diffuse surfaces reflect base / pi.
Result<void> Reader::read_light(Words& words, bool animated) {
  Light light;
  light.name = animated ? "" : "light " + std::to_string(scene_.lights.size());
  if (animated) {
    SINEW_TRY(light.name, words.name("the name of a light"));
  }
  Node node;
  SINEW_CHECKED(words.vector(node.translation));
  if (words.next_is_number()) SINEW_CHECKED(words.vector(light.color));
  light.color = max(light.color, vec3(0.0f));
  light.type = LightType::point;
  light.falloff = false;
  light.intensity = kPi;
  node.name = light.name;
  node.light = static_cast<int32_t>(scene_.lights.size());
  SINEW_TRY(node.parent, node_here(words));
  SINEW_TRY(const uint32_t index, add_node(std::move(node), words));
  if (animated) content_.named_nodes.push_back({light.name, index});
  scene_.lights.push_back(std::move(light));
  return {};
}

// "fm Ka Kd Ks shine T ior" with colours, or NFF's "f r g b Kd Ks shine T ior", which has no
// ambient colour.
Result<void> Reader::read_fill(Words& words, bool extended) {
  Fill fill;
  if (extended) {
    SINEW_CHECKED(words.vector(fill.ambient));
    SINEW_CHECKED(words.vector(fill.diffuse));
    SINEW_CHECKED(words.vector(fill.specular));
  } else {
    vec3 color;
    vec2 shares;
    SINEW_CHECKED(words.vector(color));
    SINEW_CHECKED(words.vector(shares));
    fill.diffuse = color * shares.x;
    fill.specular = vec3(shares.y);
  }
  vec3 rest;
  SINEW_CHECKED(words.vector(rest));
  fill.shine = rest.x;
  fill.transmittance = rest.y;
  fill.ior = rest.z;
  materials_.set_fill(fill);
  return {};
}

Result<void> Reader::read_background(Words& words) {
  vec3 color;
  SINEW_CHECKED(words.vector(color));
  Environment& environment = scene_.environment;
  environment.zenith = environment.horizon = environment.nadir = linear_from_display(color);
  return {};
}

Result<void> Reader::read_timing(Words& words) {
  double range[2];
  int64_t frames = 0;
  SINEW_CHECKED(words.numbers(range));
  if (range[1] < range[0]) {
    return words.error(
        fmt::format("the animation ends at {} before it starts at {}", range[1], range[0]));
  }
  SINEW_CHECKED(words.integer(frames));
  if (frames < 1 || frames > kMostFrames) {
    return words.error(fmt::format("claims {} frames", frames),
                       fmt::format("give 1 to {}", kMostFrames));
  }
  content_.timing = {range[0], range[1], static_cast<int32_t>(frames)};
  return {};
}

}  // namespace sinew::aff
