// study:twist: one finely tessellated bar, skinned by a chain of joints, that twists and bends.
// Weights are quadratic B-splines along the chain (C. de Boor, "A Practical Guide to Splines",
// 1978), so that the bar stays smooth across joints.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr uint32_t kFrames = 50;
constexpr double kFps = 25.0;
constexpr uint32_t kJoints = 24;
constexpr float kHeight = 2.6f;  // metres
constexpr float kHalfWidth = 0.34f;
constexpr float kRounding = 0.10f;  // radius of the edges of the two ends
constexpr float kTwoPi = 6.28318531f;

constexpr StudyParameter kParameters[] = {
    {"triangles", "about how many triangles the bar has, 1000 to 4000000", "256000"},
};

// Half the outline of a rounded slab: x is the half width (1 at the side), y the height. `v` in
// [0, 1] measures the way along it from the middle of the lower end to that of the upper.
vec2 outline(float v) {
  constexpr float kFlat = kHalfWidth - kRounding, kArc = 0.25f * kTwoPi * kRounding;
  constexpr float kHalf = kFlat + kArc + 0.5f * kHeight - kRounding;
  const float way = 2.0f * kHalf * std::min(v, 1.0f - v);
  vec2 p;  // on the lower half
  if (way < kFlat) {
    p = {way, 0.0f};
  } else if (way < kFlat + kArc) {
    const float angle = (way - kFlat) / kRounding;
    p = {kFlat + kRounding * std::sin(angle), kRounding * (1.0f - std::cos(angle))};
  } else {
    p = {kHalfWidth, kRounding + way - kFlat - kArc};
  }
  return {p.x / kHalfWidth, v < 0.5f ? p.y : kHeight - p.y};
}

// The cross section is the superellipse |x|^4 + |z|^4 = 1.
vec3 bar_point(float u, float v) {
  const float c = std::cos(kTwoPi * u), s = std::sin(kTwoPi * u);
  const vec2 at = outline(v);
  const float radius = kHalfWidth * at.x / std::sqrt(std::sqrt(c * c * c * c + s * s * s * s));
  return vec3(radius * s, at.y, radius * c);
}

// Bands of copper and teal that follow the four sides, with gold lines between them.
vec4 bar_color(vec3 p) {
  const float angle = std::atan2(p.x, p.z) / kTwoPi + 0.5f;
  const float band = 8.0f * angle + 0.5f;
  const float line = std::abs(band - std::round(band));  // 0 on a border between bands
  const bool odd = (static_cast<int>(std::floor(band)) & 1) != 0;
  const vec3 color = odd ? vec3(0.82f, 0.30f, 0.16f) : vec3(0.06f, 0.36f, 0.42f);
  const float gold = glm::smoothstep(0.07f, 0.05f, line);
  return vec4(glm::mix(color, vec3(0.95f, 0.72f, 0.32f), gold), 1.0f);
}

Mesh make_bar(uint32_t triangles) {
  // Twice as long as around, with nearly square cells: 320 x 400 by default.
  const float cells = 0.5f * static_cast<float>(triangles);
  const uint32_t around = std::max(8u, static_cast<uint32_t>(std::lround(std::sqrt(0.8f * cells))));
  const uint32_t rows =
      std::max(4u, static_cast<uint32_t>(std::lround(cells / static_cast<float>(around))));
  Mesh bar = single_part_mesh(closed_tube(around, rows, bar_point), 0);
  bar.name = "bar";
  bar.normals = vertex_normals(bar.positions, bar.triangles);
  const size_t count = bar.positions.size();
  bar.colors.resize(count);
  bar.influences = 3;
  bar.joints.resize(3 * count);
  bar.weights.resize(3 * count);
  parallel_for(count, 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      bar.colors[i] = bar_color(bar.positions[i]);
      // Joint j rests at height j * kHeight / (kJoints - 1).
      const float s = bar.positions[i].y / kHeight * static_cast<float>(kJoints - 1);
      const int middle =
          std::clamp(static_cast<int>(std::lround(s)), 0, static_cast<int>(kJoints) - 1);
      const float d = s - static_cast<float>(middle);
      const float below = 0.5f * (0.5f - d) * (0.5f - d), above = 0.5f * (0.5f + d) * (0.5f + d);
      const std::array<float, 3> weights{below, 1.0f - below - above, above};
      for (int k = 0; k < 3; ++k) {
        const int joint = std::clamp(middle + k - 1, 0, static_cast<int>(kJoints) - 1);
        bar.joints[3 * i + k] = static_cast<uint16_t>(joint);
        bar.weights[3 * i + k] = weights[k];
      }
    }
  });
  return bar;
}

// The turn of joint `joint` against its parent at phase `u` in [0, 1] of the loop.
quat joint_rotation(uint32_t joint, float u) {
  const float s = static_cast<float>(joint) / static_cast<float>(kJoints - 1);
  const float ease = glm::smoothstep(0.0f, 0.25f, s);  // the foot stands still
  const float step = ease / static_cast<float>(kJoints - 1);
  const float twist = 8.5f * std::sin(kTwoPi * u) * step;
  const float sideways = 2.1f * std::sin(kTwoPi * (u - 0.30f * s) + 1.0f) * step;
  const float forwards = 1.3f * std::cos(kTwoPi * (2.0f * u - 0.25f * s)) * step;
  return glm::angleAxis(sideways, vec3(0.0f, 0.0f, 1.0f)) *
         glm::angleAxis(forwards, vec3(1.0f, 0.0f, 0.0f)) *
         glm::angleAxis(twist, vec3(0.0f, 1.0f, 0.0f));
}

void add_chain(Scene& scene) {
  Skin skin;
  skin.name = "chain";
  Clip clip;
  clip.name = "Twist";
  clip.end = kFrames / kFps;
  const std::vector<float> times = even_times(2 * kFrames, clip.end);
  constexpr float kStep = kHeight / static_cast<float>(kJoints - 1);
  int32_t parent = -1;
  for (uint32_t joint = 0; joint < kJoints; ++joint) {
    const vec3 offset(0.0f, joint == 0 ? 0.0f : kStep, 0.0f);
    const uint32_t node = add_node(scene, "joint " + std::to_string(joint), offset, parent);
    parent = static_cast<int32_t>(node);
    skin.joints.push_back(node);
    skin.inverse_bind.push_back(trs(vec3(0.0f, -kStep * static_cast<float>(joint), 0.0f),
                                    glm::identity<quat>(), vec3(1.0f)));
    std::vector<quat> keys;
    for (size_t k = 0; k < times.size(); ++k) {
      const size_t phase = k % (times.size() - 1);  // the last key is the first
      keys.push_back(
          joint_rotation(joint, static_cast<float>(phase) / static_cast<float>(times.size() - 1)));
    }
    clip.channels.push_back(rotation_channel(node, times, keys));
  }
  scene.skins.push_back(std::move(skin));
  scene.clips.push_back(std::move(clip));
}

void add_floor(Scene& scene) {
  // Polished slate with thin rings: one ring and no spokes in the texture.
  scene.images.push_back(paint_image(256, 128, [](float u, float v) {
    const float cloud =
        fractal_noise(vec3(std::cos(kTwoPi * u), std::sin(kTwoPi * u), 4.0f * v), 4, 5);
    const float ring = glm::smoothstep(0.03f, 0.015f, std::abs(v - 0.5f));
    return glm::mix(vec3(0.055f, 0.062f, 0.075f) * (1.0f + 0.5f * cloud), vec3(0.16f, 0.13f, 0.08f),
                    ring);
  }));
  Material floor = colored_material("floor", vec3(1.0f), 0.10f);
  floor.base_color_texture.image = 0;
  floor.base_color_texture.wrap_t = Wrap::mirror;
  scene.materials.push_back(std::move(floor));
  DiscConfig disc;
  disc.radius = 3.0f;
  disc.rings = 6;
  disc.sectors = 96;
  disc.turns = 4.0f;
  disc.ring_height = 0.5f;
  Mesh mesh = make_disc(disc, 1);
  mesh.name = "floor";
  const uint32_t node = add_mesh_node(scene, std::move(mesh));
  scene.nodes[node].translation.y = -0.004f;  // keeps the bar's end and the floor apart
}

}  // namespace

const StudyInfo twist_info{
    "twist", "a finely tessellated bar of 256,000 triangles that twists and bends", kParameters};

Result<Scene> make_twist(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 1000, 4000000));
  Scene scene;
  scene.materials.push_back(colored_material("lacquer", vec3(1.0f), 0.12f, 0.55f));
  const uint32_t bar = add_mesh_node(scene, make_bar(triangles));
  scene.nodes[bar].skin = 0;
  add_chain(scene);
  add_floor(scene);
  add_sun(scene, "key", {{0.7f, 1.0f, 0.8f}, {1.0f, 0.92f, 0.80f}, 4.0f});
  add_sun(scene, "rim", {{-1.0f, 0.6f, -0.5f}, {0.62f, 0.78f, 1.0f}, 1.8f});
  add_camera(scene, "Front", {{0.6f, 1.9f, 6.4f}, {0.0f, 1.26f, 0.0f}, 0.53f});
  scene.environment = {{0.06f, 0.15f, 0.36f}, {0.50f, 0.56f, 0.62f}, {0.06f, 0.055f, 0.06f}, {}};
  scene.default_frames = kFrames;
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
