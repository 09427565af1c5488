// study:herd: horses that gallop through a valley; every animal has its own skin, size, pace and
// way, and its hooves stand on the terrain. Animals of one coat share a mesh.
// After: J. Bittner, D. Meister, "T-SAH", 2015, table 1, "Horses" (8048.9k triangles, most of them
// static). The valley, the animals and how they move are our own.
#include "sinew/scene/procedural/herd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/stage.h"
#include "sinew/scene/procedural/terrain.h"

namespace sinew {
namespace {

constexpr double kSeconds = kHerdFrames / kHerdFps;
constexpr float kSpeed = 8.5f;  // of the herd, metres a second
constexpr uint32_t kKeysAFrame = 2;
constexpr float kTwoPi = 6.28318531f;
constexpr float kBetween = 3.3f, kBehind = 4.8f;  // metres from horse to horse
constexpr float kTile = 3.0f;                     // metres of grass in the texture

constexpr StudyParameter kParameters[] = {
    {"count", "number of animals, 1 to 1000", "100"},
    {"triangles", "about how many triangles an animal has, 2000 to 200000", "40000"},
    {"terrain", "about how many triangles the terrain has, 1000 to 20000000", "4000000"},
};

enum HerdMaterial : uint32_t { kCoatMaterial, kGrassMaterial };

// How many animals run side by side.
uint32_t herd_columns(uint32_t count) {
  return std::max(1u,
                  static_cast<uint32_t>(std::lround(std::sqrt(0.8f * static_cast<float>(count)))));
}

// The origin of a horse that runs `aside` of the valley's middle at z: on the ground, level across,
// and pitched like the ground beneath it.
JointFrame on_ground(float aside, float z, float turn, float scale) {
  const float x = valley_middle(z) + aside;
  const vec2 heading = normalize(vec2(valley_slope(z) + turn, 1.0f));
  const vec2 fore = vec2(x, z) + 0.45f * scale * heading,
             hind = vec2(x, z) - 0.65f * scale * heading;
  const float fore_height = terrain_height(fore.x, fore.y),
              hind_height = terrain_height(hind.x, hind.y);
  const vec3 along(fore.x - hind.x, fore_height - hind_height, fore.y - hind.y);
  const float share = 0.65f / 1.10f;  // of the way from the hind to the fore hooves
  return {facing(-along), vec3(x, glm::mix(hind_height, fore_height, share), z)};
}

void add_animal(Scene& scene, Clip& clip, uint32_t index, const Gallop& gallop, uint32_t mesh,
                const std::vector<HorsePose>& poses, const std::vector<float>& times) {
  const std::string name = "horse " + std::to_string(index + 1);
  const uint32_t root = add_node(scene, name);
  scene.nodes[root].scale = vec3(gallop.scale);
  const uint32_t joints = add_skeleton(scene, horse_skeleton(), name, static_cast<int32_t>(root));
  const uint32_t body = add_node(scene, name + " body");
  scene.nodes[body].mesh = static_cast<int32_t>(mesh);
  scene.nodes[body].skin = static_cast<int32_t>(scene.skins.size() - 1);

  std::vector<vec3> places, croups;
  std::vector<quat> turns;
  for (size_t k = 0; k < times.size(); ++k) {
    const JointFrame frame = gallop.way(times[k]);
    places.push_back(frame.position);
    turns.push_back(frame.rotation);
    croups.push_back(poses[k].croup);
  }
  clip.channels.push_back(translation_channel(root, times, places));
  clip.channels.push_back(rotation_channel(root, times, turns));
  clip.channels.push_back(translation_channel(joints + kCroup, times, croups));
  for (uint32_t j = 0; j < kHorseJoints; ++j) {
    std::vector<quat> rotations;
    for (const HorsePose& pose : poses) rotations.push_back(pose.rotation[j]);
    clip.channels.push_back(rotation_channel(joints + j, times, rotations));
  }
}

void add_animals(Scene& scene, Clip& clip, uint32_t count, uint32_t triangles) {
  const auto first_mesh = static_cast<uint32_t>(scene.meshes.size());
  const uint32_t coats = std::min(count, kCoats);
  std::vector<Mesh> horses = make_horses(triangles, kCoatMaterial);
  for (uint32_t coat = 0; coat < coats; ++coat) scene.meshes.push_back(std::move(horses[coat]));

  const std::vector<float> times = even_times(kKeysAFrame * kHerdFrames, kSeconds);
  std::vector<Gallop> gallops;
  for (uint32_t i = 0; i < count; ++i) gallops.push_back(herd_gallop(i, count));
  std::vector<std::vector<HorsePose>> poses(count, std::vector<HorsePose>(times.size()));
  parallel_for(count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      for (size_t k = 0; k < times.size(); ++k) poses[i][k] = gallop_pose(gallops[i], times[k]);
    }
  });
  for (uint32_t i = 0; i < count; ++i) {
    // The first animals show every coat once, the others any.
    const uint32_t coat = i < coats ? i : hash_combine(77, i) % coats;
    add_animal(scene, clip, i, gallops[i], first_mesh + coat, poses[i], times);
  }
}

// Cameras travel with the herd.
void add_cameras(Scene& scene, Clip& clip, uint32_t count) {
  const float rows = static_cast<float>(count) / static_cast<float>(herd_columns(count));
  const float front = 0.5f * kBehind * rows,
              side = 0.5f * kBetween * static_cast<float>(herd_columns(count));
  struct View {
    const char* name;
    vec3 eye;     // aside of the valley's middle, above the ground, ahead of the herd's middle
    vec3 target;  // the same
    float yfov;
  };
  const std::array<View, 2> views{{
      {"Beside", {side + 5.0f, 2.5f, front + 6.0f}, {0.0f, 1.2f, front - 7.5f}, 0.52f},
      {"Above", {side + 16.0f, 20.0f, front + 14.0f}, {0.0f, 0.0f, 0.15f * front}, 0.70f},
  }};
  const std::vector<float> times = even_times(kHerdFrames, kSeconds);
  for (const View& view : views) {
    const auto at = [&](vec3 offset, float time) {
      const float z = kSpeed * (time - 0.5f * static_cast<float>(kSeconds)) + offset.z;
      const float x = valley_middle(z) + offset.x;
      return vec3(x, terrain_height(valley_middle(z), z) + offset.y, z);
    };
    std::vector<vec3> eyes;
    std::vector<quat> turns;
    for (const float time : times) {
      eyes.push_back(at(view.eye, time));
      turns.push_back(facing(at(view.target, time) - eyes.back()));
    }
    const uint32_t camera =
        add_camera(scene, view.name, {eyes[0], at(view.target, 0.0f), view.yfov});
    clip.channels.push_back(translation_channel(camera, times, eyes));
    clip.channels.push_back(rotation_channel(camera, times, turns));
  }
}

}  // namespace

Gallop herd_gallop(uint32_t index, uint32_t count) {
  const uint32_t columns = herd_columns(count), row = index / columns, column = index % columns;
  const float rows = std::ceil(static_cast<float>(count) / static_cast<float>(columns));
  Random random(hash_combine(41, index));
  Gallop gallop;
  gallop.scale = random.uniform(0.90f, 1.06f);
  if (random.uniform() < 0.12f) gallop.scale *= 0.66f;  // a foal
  gallop.stride_seconds = random.uniform(0.47f, 0.53f) * std::sqrt(gallop.scale);
  gallop.phase = random.uniform();
  gallop.right_lead = random.uniform() < 0.5f;
  gallop.speed = kSpeed;
  // A loose lattice, its front bent to a point.
  const float middle = 0.5f * static_cast<float>(columns - 1);
  const float across = static_cast<float>(column) - middle + (row % 2 == 0 ? 0.25f : -0.25f);
  const float aside = kBetween * (across + random.uniform(-0.24f, 0.24f));
  const float bend = 0.022f * aside * aside;
  const float ahead =
      kBehind * (0.5f * (rows - 1.0f) - static_cast<float>(row) + random.uniform(-0.26f, 0.26f)) -
      bend;
  const float drift = random.uniform(0.15f, 0.40f), gain = random.uniform(0.15f, 0.45f);
  const float drift_phase = random.uniform(), gain_phase = random.uniform();
  const float scale = gallop.scale;
  gallop.way = [=](double time) {
    const auto t = static_cast<float>(time - 0.5 * kSeconds);
    const float sway = kTwoPi * (0.16f * t + drift_phase), pace = kTwoPi * (0.20f * t + gain_phase);
    const float z = ahead + kSpeed * t + gain * std::sin(pace);
    const float turn = drift * kTwoPi * 0.16f * std::cos(sway) / kSpeed;
    return on_ground(aside + drift * std::sin(sway), z, turn, scale);
  };
  gallop.ground = terrain_height;
  return gallop;
}

const StudyInfo herd_info{
    "herd",
    "100 galloping horses of 40,000 triangles in a valley of 4 million; small: "
    "herd,count=12,triangles=5000,terrain=100000; mostly static: "
    "herd,count=8,terrain=7700000",
    kParameters};

Result<Scene> make_herd(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t count, arguments.integer("count", 1, 1000));
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 2000, 200000));
  SINEW_TRY(const uint32_t terrain, arguments.integer("terrain", 1000, 20000000));
  Scene scene;
  Material coat = colored_material("coat", vec3(1.0f), 0.85f);
  coat.specular_color = vec3(0.25f);
  scene.materials.push_back(std::move(coat));
  scene.images.push_back(paint_grass(512));
  Material grass = colored_material("grass", vec3(1.0f), 0.95f);
  grass.base_color_texture.image = 0;
  grass.specular_color = vec3(0.2f);
  scene.materials.push_back(std::move(grass));
  Clip clip;
  clip.name = "Run";
  clip.end = kSeconds;
  add_mesh_node(scene, make_terrain(terrain, kTile, kGrassMaterial));
  add_animals(scene, clip, count, triangles);
  add_cameras(scene, clip, count);
  add_sun(scene, "sun", {{0.75f, 0.62f, 0.55f}, {1.0f, 0.88f, 0.70f}, 3.7f});
  add_sun(scene, "sky", {{-0.4f, 1.0f, 0.3f}, {0.60f, 0.75f, 1.0f}, 0.5f});
  scene.clips.push_back(std::move(clip));
  scene.environment = {{0.13f, 0.28f, 0.58f}, {0.62f, 0.64f, 0.62f}, {0.14f, 0.12f, 0.08f}};
  scene.default_frames = kHerdFrames;
  scene.default_fps = kHerdFps;
  return scene;
}

}  // namespace sinew
