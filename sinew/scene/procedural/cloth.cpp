// study:cloth: a cloth that falls onto a ball, drapes over it and slides down to the ground; made
// by simulation (cloth_simulation.h) and kept as a vertex cache.
// After: J. Bittner, D. Meister, "T-SAH", 2015, table 1, "Cloth Ball" (92.2k triangles, 94 key
// frames). The motion and the look are our own.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/math/random.h"
#include "sinew/scene/procedural/cloth_simulation.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318531f;
constexpr size_t kMostKeyBytes = size_t{2} << 30;

constexpr StudyParameter kParameters[] = {
    {"triangles", "about how many triangles the cloth has, 200 to 1000000", "92450"},
    {"frames", "how many frames are simulated, 25 a second, 2 to 1000", "94"},
};

enum ClothMaterial : uint32_t { kFabricMaterial, kBallMaterial, kGroundMaterial };

ClothConfig cloth_config(uint32_t triangles, uint32_t frames) {
  ClothConfig config;
  config.cells =
      static_cast<uint32_t>(std::lround(std::sqrt(0.5f * static_cast<float>(triangles))));
  config.frames = frames;
  config.start = {0.36f, 1.40f, 0.10f};
  config.turn = 0.42f;
  config.tilt = 0.05f;
  return config;
}

// Row by row; diagonals alternate, so that the cloth has no grain.
std::vector<uvec3> grid_triangles(uint32_t cells) {
  std::vector<uvec3> triangles;
  triangles.reserve(size_t{2} * cells * cells);
  for (uint32_t r = 0; r < cells; ++r) {
    for (uint32_t c = 0; c < cells; ++c) {
      const uint32_t a = r * (cells + 1) + c, b = a + cells + 1;
      if ((r + c) % 2 == 0) {
        triangles.push_back({a, b, b + 1});
        triangles.push_back({a, b + 1, a + 1});
      } else {
        triangles.push_back({a, b, a + 1});
        triangles.push_back({a + 1, b, b + 1});
      }
    }
  }
  return triangles;
}

Mesh make_cloth_mesh(const ClothConfig& config) {
  Mesh mesh;
  mesh.name = "cloth";
  const size_t count = size_t{config.cells + 1} * (config.cells + 1);
  mesh.keys = config.frames + 1;
  mesh.key_positions = simulate_cloth(config);
  mesh.positions.assign(mesh.key_positions.begin(), mesh.key_positions.begin() + count);
  mesh.triangles = grid_triangles(config.cells);
  for (uint32_t i = 0; i < count; ++i) {
    mesh.texcoords[0].push_back(vec2(i % (config.cells + 1), i / (config.cells + 1)) /
                                static_cast<float>(config.cells));
  }
  mesh.parts.push_back({kFabricMaterial, false});
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

// Madder red with a border of stripes and a lattice of small lozenges, all woven.
vec3 fabric(float u, float v) {
  constexpr vec3 kRed(0.50f, 0.045f, 0.035f), kCream(0.80f, 0.70f, 0.52f),
      kBlue(0.03f, 0.07f, 0.20f);
  const float edge = std::min(std::min(u, 1.0f - u), std::min(v, 1.0f - v));
  vec3 color = kRed;
  if (edge < 0.085f) {
    const float stripe = edge / 0.085f;
    if (stripe > 0.82f || (stripe > 0.16f && stripe < 0.30f))
      color = kCream;
    else if (stripe >= 0.30f)
      color = kBlue;
  } else {
    const float x = 14.0f * u, y = 14.0f * v;
    const float dx = std::abs(x - std::floor(x) - 0.5f), dy = std::abs(y - std::floor(y) - 0.5f);
    const float lozenge = dx + dy;
    if (lozenge < 0.13f || (lozenge > 0.235f && lozenge < 0.285f)) color = kCream;
  }
  const float weave =
      0.5f + 0.25f * std::sin(kTwoPi * 170.0f * u) + 0.25f * std::sin(kTwoPi * 170.0f * v);
  const float worn = fractal_noise(vec3(9.0f * u, 9.0f * v, 3.0f), 4, 31);
  return color * (0.82f + 0.22f * weave) * (1.0f + 0.22f * worn);
}

// Boards of a floor: four across the texture, each with its own tone and grain.
vec3 boards(float u, float v) {
  const float x = 4.0f * u, column = std::floor(x);
  const float y = v + 0.37f * column - std::floor(v + 0.37f * column);
  const float tone = 0.80f + 0.35f * unit_float(hash_u32(static_cast<uint32_t>(column)));
  const float angle = kTwoPi * y;  // the texture repeats along the boards
  const vec3 at(7.0f * x, 1.1f * std::cos(angle), 1.1f * std::sin(angle));
  const float grain = fractal_noise(at, 5, 41 + static_cast<uint32_t>(column));
  const float gap = std::min(std::min(x - column, column + 1.0f - x), std::min(y, 1.0f - y));
  const vec3 wood = glm::mix(vec3(0.20f, 0.105f, 0.050f), vec3(0.34f, 0.20f, 0.10f), 0.5f + grain);
  return wood * tone * (0.35f + 0.65f * glm::smoothstep(0.004f, 0.02f, gap));
}

void add_stage(Scene& scene, const ClothConfig& config) {
  TriangleSurface sphere = geodesic_sphere(32);
  Mesh ball = single_part_mesh(sphere, kBallMaterial);
  ball.name = "ball";
  ball.normals = sphere.positions;
  for (vec3& p : ball.positions) p *= config.ball_radius;
  scene.nodes[add_mesh_node(scene, std::move(ball))].translation = config.ball;
  Mesh ground = make_box({-4.0f, -0.1f, -4.0f}, {4.0f, 0.0f, 4.0f}, false, kGroundMaterial);
  ground.name = "ground";
  add_mesh_node(scene, std::move(ground));
  add_sun(scene, "key", {{0.9f, 1.3f, 0.6f}, {1.0f, 0.91f, 0.78f}, 3.9f});
  add_sun(scene, "fill", {{-0.9f, 0.7f, 0.5f}, {0.62f, 0.78f, 1.0f}, 0.9f});
  add_camera(scene, "Front", {{1.5f, 2.1f, 4.3f}, {0.36f, 0.48f, 0.0f}, 0.58f});
  scene.environment = {{0.16f, 0.22f, 0.34f}, {0.52f, 0.54f, 0.56f}, {0.12f, 0.10f, 0.08f}};
}

void add_materials(Scene& scene) {
  scene.images.push_back(paint_image(1024, 1024, fabric));
  scene.images.push_back(paint_image(512, 512, boards));
  Material cloth = colored_material("fabric", vec3(1.0f), 0.85f);
  cloth.base_color_texture.image = 0;
  cloth.base_color_texture.wrap_s = cloth.base_color_texture.wrap_t = Wrap::clamp;
  scene.materials.push_back(std::move(cloth));
  scene.materials.push_back(colored_material("ball", vec3(0.93f, 0.70f, 0.34f), 0.12f, 0.85f));
  Material ground = colored_material("boards", vec3(1.0f), 0.35f);
  ground.base_color_texture.image = 1;
  scene.materials.push_back(std::move(ground));
}

}  // namespace

const StudyInfo cloth_info{
    "cloth", "a cloth of 92,450 triangles, simulated, that falls onto a ball and slides down",
    kParameters};

Result<Scene> make_cloth(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 200, 1000000));
  SINEW_TRY(const uint32_t frames, arguments.integer("frames", 2, 1000));
  const ClothConfig config = cloth_config(triangles, frames);
  if (size_t{frames + 1} * (config.cells + 1) * (config.cells + 1) * sizeof(vec3) > kMostKeyBytes) {
    return fail({ErrorKind::usage, "study:cloth", "",
                 "so many frames of so many triangles take more than 2 GiB",
                 "ask for fewer frames or triangles"});
  }
  Scene scene;
  add_materials(scene);
  const uint32_t node = add_mesh_node(scene, make_cloth_mesh(config));
  Clip clip;
  clip.name = "Fall";
  clip.end = frames / config.fps;
  clip.channels.push_back(value_channel(node, ChannelPath::cache_key, 1,
                                        {0.0f, static_cast<float>(clip.end)},
                                        {0.0f, static_cast<float>(frames)}));
  scene.clips.push_back(std::move(clip));
  add_stage(scene, config);
  scene.default_frames = static_cast<int32_t>(frames);
  scene.default_fps = config.fps;
  return scene;
}

}  // namespace sinew
