// study:soup: independent triangles that fly between five constellations in a museum room.
// After: J. Lext, U. Assarsson, T. Moller, "A Benchmark for Animated Ray Tracing", 2001: the art
// piece of the Museum scene (65,536 triangles at its finest, five keys over four seconds, two
// lights, one room). The constellations and the room are our own.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr uint32_t kKeys = 5;
constexpr double kFps = 25.0;
constexpr float kTwoPi = 6.28318531f;
constexpr vec3 kMiddle(0.0f, 1.75f, 0.0f);  // of the art piece, metres

constexpr StudyParameter kParameters[] = {
    {"triangles", "number of independent triangles of the art piece, 1 to 1000000", "65536"},
    {"key_seconds", "time from one constellation to the next in seconds, 0.1 to 60", "1"},
};

// A triangle's place: its middle, its outward direction, and the area it should have.
struct Place {
  vec3 center;
  vec3 normal;
  float area;
};

float fraction(double x) {
  return static_cast<float>(x - std::floor(x));
}

// Turn of point i of the golden-ratio sequence, in [0, 1): well spread for any range of i.
float golden_turn(uint32_t i) {
  return fraction(0.6180339887498949 * i);
}

// Spherical Fibonacci points, from the upper pole to the lower.
Place on_sphere(uint32_t i, float s, float share) {
  const float y = 1.0f - 2.0f * s, r = std::sqrt(std::max(0.0f, 1.0f - y * y));
  const float angle = kTwoPi * golden_turn(i);
  const vec3 n(r * std::cos(angle), y, r * std::sin(angle));
  return {1.05f * n, n, 1.1f * 2.0f * kTwoPi * 1.05f * 1.05f * share};
}

// A tube along a trefoil knot.
Place on_knot(uint32_t i, float s, float share) {
  constexpr float kTube = 0.19f, kScale = 0.40f;
  const auto curve = [](float t) {
    return kScale * vec3(std::sin(t) + 2.0f * std::sin(2.0f * t),
                         std::cos(t) - 2.0f * std::cos(2.0f * t), -std::sin(3.0f * t));
  };
  const float t = kTwoPi * s;
  const vec3 along = normalize(curve(t + 1e-2f) - curve(t - 1e-2f));
  const vec3 side = normalize(cross(along, vec3(0.0f, 0.0f, 1.0f)));
  const float angle = kTwoPi * golden_turn(i);
  const vec3 n = std::cos(angle) * side + std::sin(angle) * cross(side, along);
  return {curve(t) + kTube * n, n, 1.2f * kTwoPi * kTube * 11.5f * share};
}

// The surfaces of 5 x 5 x 5 cubes, one after the other along a line that folds through them.
Place on_cubes(uint32_t i, float s, float share) {
  constexpr uint32_t kSide = 5, kCubes = kSide * kSide * kSide;
  constexpr float kPitch = 0.38f, kEdge = 0.21f;
  const uint32_t cube = std::min(kCubes - 1, static_cast<uint32_t>(s * kCubes));
  glm::uvec3 cell(cube % kSide, cube / kSide % kSide, cube / kSide / kSide);
  if (cell.z % 2 == 1) cell.y = kSide - 1 - cell.y;
  if (cube / kSide % 2 == 1) cell.x = kSide - 1 - cell.x;
  const float turn = 6.0f * golden_turn(i);
  const int face = std::min(5, static_cast<int>(turn)), axis = face % 3;
  vec3 n(0.0f), p;
  n[axis] = face < 3 ? 1.0f : -1.0f;
  p[axis] = 0.5f * n[axis];
  p[(axis + 1) % 3] = turn - static_cast<float>(face) - 0.5f;
  p[(axis + 2) % 3] = fraction(static_cast<double>(s) * kCubes) - 0.5f;
  return {kPitch * (vec3(cell) - 0.5f * (kSide - 1.0f)) + kEdge * p, n,
          1.2f * 6.0f * kEdge * kEdge * kCubes * share};
}

// A spiral with three arms, tilted towards the door.
Place on_swirl(uint32_t i, float s, float share) {
  Random random(hash_combine(3, i));
  const float turn = 3.0f * golden_turn(i), arm = std::floor(turn);
  const float radius = 0.12f + 1.45f * std::sqrt(s);
  const float spread = 2.0f * (turn - arm) - 1.0f, height = random.uniform(-1.0f, 1.0f);
  const float angle =
      kTwoPi * (arm / 3.0f + 0.95f * std::sqrt(s)) + 0.42f * spread * std::abs(spread);
  const vec3 flat(radius * std::cos(angle), 0.16f * height * std::abs(height) * (1.2f - s),
                  radius * std::sin(angle));
  const quat tilt = glm::angleAxis(0.55f, vec3(1.0f, 0.0f, 0.0f));
  const vec3 n = normalize(vec3(0.35f * spread, 1.0f, 0.35f * height));
  return {tilt * flat, tilt * n, 6.0f * share};
}

// Anywhere in a ball, in about the direction from its middle as on the sphere, turned anyhow.
Place in_cloud(uint32_t i, float s, float share) {
  Random random(hash_combine(5, i));
  const vec3 direction = normalize(on_sphere(i, s, share).normal + 0.25f * random.direction());
  const float radius = 1.55f * std::cbrt(random.uniform());
  return {radius * direction, random.direction(), 8.0f * share};
}

std::array<vec3, 3> corners_of(const Place& place, float spin) {
  const vec3 helper =
      std::abs(place.normal.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
  const vec3 x = normalize(cross(helper, place.normal)), z = cross(place.normal, x);
  const float radius =
      std::sqrt(place.area / 1.29903811f);  // equilateral: area = 3 sqrt(3) / 4 r^2
  std::array<vec3, 3> corners;
  for (int k = 0; k < 3; ++k) {
    const float angle = kTwoPi * (spin + static_cast<float>(k) / 3.0f);
    corners[k] = kMiddle + place.center - radius * (std::cos(angle) * z - std::sin(angle) * x);
  }
  return corners;
}

vec4 triangle_color(float s) {
  const auto wave = [&](float phase) {
    const float w = 0.5f + 0.5f * std::cos(kTwoPi * (1.5f * s + phase));
    return 0.06f + 0.84f * w * w;
  };
  return vec4(wave(0.05f), wave(0.33f), wave(0.62f), 1.0f);
}

Mesh make_art(uint32_t triangles) {
  using Constellation = Place (*)(uint32_t, float, float);
  constexpr std::array<Constellation, kKeys> constellations{on_sphere, on_knot, on_cubes, on_swirl,
                                                            in_cloud};
  Mesh mesh;
  mesh.name = "art";
  const size_t vertices = size_t{3} * triangles;
  mesh.keys = kKeys;
  mesh.key_positions.resize(kKeys * vertices);
  mesh.colors.resize(vertices);
  mesh.triangles.resize(triangles);
  const float share = 1.0f / static_cast<float>(triangles);
  parallel_for(triangles, 2048, [&](size_t begin, size_t end) {
    for (uint32_t i = static_cast<uint32_t>(begin); i < end; ++i) {
      const float s = (static_cast<float>(i) + 0.5f) * share;
      mesh.triangles[i] = uvec3(3 * i, 3 * i + 1, 3 * i + 2);
      for (uint32_t key = 0; key < kKeys; ++key) {
        const std::array<vec3, 3> corners =
            corners_of(constellations[key](i, s, share), golden_turn(i + 7 * key));
        std::ranges::copy(corners, &mesh.key_positions[key * vertices + size_t{3} * i]);
      }
      std::fill_n(&mesh.colors[size_t{3} * i], 3, triangle_color(s));
    }
  });
  mesh.positions.assign(mesh.key_positions.begin(), mesh.key_positions.begin() + vertices);
  mesh.parts.push_back({0, true});
  mesh.triangle_part.assign(triangles, 0);
  return mesh;
}

enum RoomMaterial : uint32_t { kArt, kWall, kFloor, kCeiling, kStone, kFrame, kPicture };

void add_materials(Scene& scene) {
  scene.materials = {colored_material("art", vec3(1.0f), 0.25f, 0.35f),
                     colored_material("wall", {0.44f, 0.36f, 0.27f}, 0.9f),
                     colored_material("floor", vec3(1.0f), 0.15f),
                     colored_material("ceiling", {0.80f, 0.79f, 0.76f}, 0.9f),
                     colored_material("stone", {0.13f, 0.14f, 0.17f}, 0.3f),
                     colored_material("frame", {0.75f, 0.55f, 0.25f}, 0.35f, 0.5f)};
  scene.images.push_back(paint_image(256, 256, [](float u, float v) {  // two by two tiles
    const bool light = (u < 0.5f) == (v < 0.5f);
    const float vein = std::abs(fractal_noise(vec3(5.0f * u, 5.0f * v, light ? 0.0f : 9.0f), 4, 2));
    const vec3 stone = light ? vec3(0.62f, 0.58f, 0.52f) : vec3(0.20f, 0.13f, 0.11f);
    return stone * (0.78f + 0.5f * std::min(0.5f, vein));
  }));
  scene.materials[kFloor].base_color_texture.image = 0;
  scene.materials[kFloor].base_color_texture.scale = vec2(0.5f);
  for (uint32_t i = 0; i < 4; ++i) {  // pictures: hills of four moods
    const int32_t image = static_cast<int32_t>(scene.images.size());
    scene.images.push_back(paint_image(128, 96, [i](float u, float v) {
      const float hill =
          0.55f + 0.5f * fractal_noise(vec3(2.5f * u, static_cast<float>(i), 0.5f), 3, i);
      const float t = 0.25f * static_cast<float>(i) + (v < hill ? 0.3f * v : 0.45f + 0.2f * v);
      return 0.75f * vec3(triangle_color(0.66f * t));
    }));
    scene.materials.push_back(colored_material("picture", vec3(1.0f), 0.7f));
    scene.materials.back().base_color_texture.image = image;
  }
}

// A picture on the wall at `center`, its front towards `normal` (along x or z).
void add_picture(Scene& scene, vec3 center, vec3 normal, uint32_t material) {
  const vec3 along = glm::abs(vec3(normal.z, 0.0f, normal.x));
  const vec3 size = 0.75f * along + vec3(0.0f, 0.55f, 0.0f);
  const vec3 depth = 0.03f * glm::abs(normal);
  Mesh frame = make_box(center - 1.1f * size - depth, center + 1.1f * size + depth, false, kFrame);
  frame.name = "frame";
  add_mesh_node(scene, std::move(frame));

  const vec3 right = cross(vec3(0.0f, 1.0f, 0.0f), normal) * 0.75f, up(0.0f, 0.55f, 0.0f);
  const vec3 front = center + 0.035f * normal;
  Mesh canvas;
  canvas.name = "picture";
  canvas.positions = {front - right - up, front + right - up, front + right + up,
                      front - right + up};
  canvas.normals.assign(4, normal);
  canvas.texcoords[0] = {{0.0f, 1.0f}, {1.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, 0.0f}};
  canvas.triangles = {{0, 1, 2}, {0, 2, 3}};
  canvas.triangle_part.assign(2, 0);
  canvas.parts.push_back({material, false});
  add_mesh_node(scene, std::move(canvas));
}

void add_room(Scene& scene) {
  constexpr vec3 kLow(-5.0f, 0.0f, -5.0f), kHigh(5.0f, 4.5f, 5.0f);
  Mesh room = make_box(kLow, kHigh, true, kWall);
  room.name = "room";
  room.parts = {{kWall, false}, {kFloor, false}, {kCeiling, false}};
  room.triangle_part = {0, 0, 0, 0, 1, 1, 2, 2, 0, 0, 0, 0};  // see make_box: x, y, z; low, high
  add_mesh_node(scene, std::move(room));

  DiscConfig disc;
  disc.radius = 0.9f;
  disc.rim = 0.22f;
  Mesh pedestal = make_disc(disc, kStone);
  pedestal.name = "pedestal";
  const uint32_t node = add_mesh_node(scene, std::move(pedestal));
  scene.nodes[node].translation.y = disc.rim;

  for (uint32_t i = 0; i < 4; ++i) {
    const float side = i % 2 == 0 ? -1.9f : 1.9f;
    if (i < 2) {
      add_picture(scene, {side, 1.9f, kLow.z + 0.03f}, {0.0f, 0.0f, 1.0f}, kPicture + i);
    } else {
      add_picture(scene, {kLow.x + 0.03f, 1.9f, side}, {1.0f, 0.0f, 0.0f}, kPicture + i);
    }
  }
}

}  // namespace

const StudyInfo soup_info{
    "soup", "65,536 independent triangles between five constellations, in a museum room",
    kParameters};

Result<Scene> make_soup(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 1, 1000000));
  SINEW_TRY(const double key_seconds, arguments.number("key_seconds", 0.1, 60.0));
  Scene scene;
  add_materials(scene);
  const uint32_t art = add_mesh_node(scene, make_art(triangles));
  add_room(scene);
  add_lamp(scene, "lamp by the door", {2.0f, 3.7f, 2.6f}, {1.0f, 0.90f, 0.76f}, 38.0f);
  add_lamp(scene, "lamp by the window", {-2.4f, 3.3f, 1.0f}, {0.76f, 0.88f, 1.0f}, 20.0f);
  add_camera(scene, "Door", {{3.3f, 2.2f, 4.3f}, {-0.15f, 1.62f, 0.0f}, 0.80f});

  Clip clip;
  clip.name = "Constellations";
  clip.end = key_seconds * (kKeys - 1);
  clip.channels.push_back(value_channel(art, ChannelPath::cache_key, 1,
                                        even_times(kKeys - 1, clip.end),
                                        {0.0f, 1.0f, 2.0f, 3.0f, 4.0f}));
  scene.clips.push_back(std::move(clip));
  scene.environment = {vec3(0.30f, 0.31f, 0.33f), vec3(0.26f), vec3(0.20f, 0.18f, 0.16f), {}, {}};
  scene.default_frames = static_cast<int32_t>(std::lround(key_seconds * (kKeys - 1) * kFps));
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
