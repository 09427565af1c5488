// study:fracture: a shell that breaks into closed pieces, each bound to a joint of its own.
#include "sinew/scene/procedural/fracture.h"

#include <algorithm>
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

constexpr uint32_t kFrames = 50;
constexpr double kFps = 25.0;
constexpr uint32_t kKeysPerFrame = 2;
constexpr float kWhole = 0.16f;               // seconds before the first crack
constexpr vec3 kBlast(0.03f, 0.55f, -0.04f);  // where the push comes from, metres

constexpr StudyParameter kParameters[] = {
    {"triangles", "number of triangles of the shell, 10000 to 4000000, at least 60 a piece",
     "250880"},
    {"pieces", "number of pieces, 2 to 2000", "200"},
};

struct Piece {
  std::vector<vec3> points;
  vec3 center{0.0f};
};

std::vector<Piece> gather_pieces(const Mesh& shell, uint32_t pieces) {
  std::vector<Piece> result(pieces);
  for (size_t v = 0; v < shell.positions.size(); ++v) {
    result[shell.joints[v] - 1u].points.push_back(shell.positions[v]);
  }
  for (Piece& piece : result) {
    for (const vec3 p : piece.points) piece.center += p;
    if (!piece.points.empty()) piece.center /= static_cast<float>(piece.points.size());
  }
  return result;
}

// The crack runs from the crown down; what is hit later is pushed less.
FlightConfig throw_piece(const Piece& piece, uint32_t index) {
  Random random(hash_combine(71, index));
  FlightConfig flight;
  const vec3 away = piece.center - kBlast;
  const float depth = glm::clamp(1.45f - piece.center.y, 0.0f, 1.45f);
  flight.start = kWhole + 0.16f * depth;
  const vec3 direction = normalize(away + 0.22f * random.direction());
  // One draw a line: compilers differ in the order within an expression.
  const float lift = random.uniform(0.8f, 2.2f);
  flight.velocity = random.uniform(1.3f, 2.9f) * direction + vec3(0.0f, lift, 0.0f);
  const vec3 axis = random.direction();
  flight.spin = random.uniform(1.0f, 9.0f) * axis;
  flight.restitution = 0.28f;
  return flight;
}

void add_flight(Scene& scene, const Mesh& shell, uint32_t pieces) {
  const std::vector<Piece> parts = gather_pieces(shell, pieces);
  const std::vector<float> times = even_times(kFrames * kKeysPerFrame, kFrames / kFps);
  std::vector<std::vector<PiecePose>> poses(pieces);
  parallel_for(pieces, 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (parts[i].points.empty()) {
        poses[i].resize(times.size());
        continue;
      }
      const FlightConfig flight = throw_piece(parts[i], static_cast<uint32_t>(i));
      poses[i] = fly(parts[i].points, parts[i].center, flight, times);
    }
  });

  Clip clip;
  clip.name = "Break";
  clip.end = kFrames / kFps;
  Skin skin;
  skin.name = "pieces";
  const uint32_t root = add_node(scene, "egg");
  skin.joints.push_back(root);
  skin.inverse_bind.push_back(identity_affine());
  for (uint32_t i = 0; i < pieces; ++i) {
    const uint32_t node = add_node(scene, "piece " + std::to_string(i + 1), parts[i].center,
                                   static_cast<int32_t>(root));
    skin.joints.push_back(node);
    skin.inverse_bind.push_back(trs(-parts[i].center, glm::identity<quat>(), vec3(1.0f)));
    std::vector<vec3> centers;
    std::vector<quat> rotations;
    for (const PiecePose& pose : poses[i]) {
      centers.push_back(pose.center);
      rotations.push_back(pose.rotation);
    }
    clip.channels.push_back(translation_channel(node, times, centers));
    clip.channels.push_back(rotation_channel(node, times, rotations));
  }
  scene.skins.push_back(std::move(skin));
  scene.clips.push_back(std::move(clip));
}

void add_ground(Scene& scene) {
  scene.images.push_back(paint_image(512, 512, [](float u, float v) {
    const float ripple =
        0.5f + 0.5f * std::sin(6.28318531f * 4.0f * v +
                               1.6f * fractal_noise(vec3(3.0f * u, 3.0f * v, 0.0f), 3, 8));
    const float grain = fractal_noise(vec3(90.0f * u, 90.0f * v, 3.0f), 2, 9);
    return vec3(0.46f, 0.34f, 0.23f) * (0.86f + 0.12f * ripple + 0.22f * grain);
  }));
  Material sand = colored_material("sand", vec3(1.0f), 0.95f);
  sand.base_color_texture.image = 0;
  sand.base_color_texture.wrap_s = Wrap::mirror;
  sand.base_color_texture.wrap_t = Wrap::mirror;
  scene.materials.push_back(std::move(sand));
  DiscConfig disc;
  disc.radius = 5.0f;
  disc.rings = 10;
  disc.sectors = 96;
  disc.turns = 12.0f;
  Mesh ground = make_disc(disc, 3);
  ground.name = "ground";
  const uint32_t node = add_mesh_node(scene, std::move(ground));
  scene.nodes[node].translation.y = -0.002f;
}

}  // namespace

const StudyInfo fracture_info{
    "fracture", "an egg of 250,880 triangles that breaks into 200 closed pieces", kParameters};

Result<Scene> make_fracture(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 10000, 4000000));
  SINEW_TRY(const uint32_t pieces, arguments.integer("pieces", 2, 2000));
  if (triangles / 60 < pieces) {
    return fail({ErrorKind::usage, "study:fracture", "",
                 std::to_string(triangles) + " triangles are too few for " +
                     std::to_string(pieces) + " pieces",
                 "give at least 60 a piece"});
  }
  Scene scene;
  scene.materials = {colored_material("glaze", vec3(1.0f), 0.18f),
                     colored_material("inside", vec3(1.0f), 0.35f, 0.3f),
                     colored_material("break", vec3(1.0f), 0.9f)};
  Mesh shell = make_shell(triangles, pieces);
  add_flight(scene, shell, pieces);
  const uint32_t node = add_mesh_node(scene, std::move(shell));
  scene.nodes[node].skin = 0;
  add_ground(scene);
  add_sun(scene, "key", {{0.8f, 1.1f, 0.7f}, {1.0f, 0.90f, 0.75f}, 4.0f});
  add_sun(scene, "fill", {{-1.0f, 0.5f, 0.4f}, {0.66f, 0.80f, 1.0f}, 0.8f});
  add_camera(scene, "Front", {{0.9f, 1.7f, 5.2f}, {0.0f, 0.75f, 0.0f}, 0.62f});
  scene.environment = {{0.10f, 0.22f, 0.46f}, {0.52f, 0.58f, 0.63f}, {0.20f, 0.16f, 0.12f}};
  scene.default_frames = kFrames;
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
