// study:bodies: wobbling mirror balls that float in the air, flown around by the camera.
// Based on: T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy Updates for
// Ray Tracing of Deformable Models", 2003, section 4, first experiment (nine bodies of 81,920
// triangles, two lights, all bodies reflective, 280 frames, frame 200 the cheapest). The paper does
// not give its shapes and paths; these are our own.
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

constexpr uint32_t kFrames = 280;
constexpr double kFps = 25.0;
constexpr uint32_t kShapes = 9;  // bodies beyond nine reuse the shapes, not the movement
constexpr uint32_t kTargets = 6;
constexpr float kSpacing = 3.2f;  // metres between bodies of radius 1
constexpr float kTwoPi = 6.28318531f;

constexpr StudyParameter kParameters[] = {
    {"subdivisions", "how often the icosahedron is subdivided, 2 to 7; 20 * 4^n triangles a body",
     "6"},
    {"bodies", "number of bodies, 1 to 64", "9"},
    {"motion", "morph: morph targets; free: new vertices each frame, of the same shape", "morph"},
};

// How target `target` displaces the point p of the unit sphere: low spherical harmonics, ripples,
// and a twist.
vec3 displacement(uint32_t target, vec3 p) {
  switch (target) {
    case 0:
      return p * (0.20f * (3.0f * p.x * p.x - 1.0f));
    case 1:
      return p * (0.70f * p.y * p.z);
    case 2:
      return p * (0.16f * (5.0f * p.y * p.y * p.y - 3.0f * p.y));
    case 3: {
      const vec3 q = p * p;
      return p * (0.70f * (dot(q, q) - 0.6f));
    }
    case 4:
      return p * (0.075f * std::sin(6.0f * p.x) * std::cos(5.0f * p.y + 1.0f) *
                  std::sin(7.0f * p.z + 2.0f));
    default:
      return 0.45f * p.x * cross(vec3(1.0f, 0.0f, 0.0f), p);
  }
}

// The orientation of the targets in shape `shape`.
mat3 shape_frame(uint32_t shape) {
  Random random(hash_combine(11, shape));
  const vec3 axis = random.direction();
  return glm::mat3_cast(glm::angleAxis(random.uniform(0.0f, kTwoPi), axis));
}

// Computes the vertices that the morph targets with these weights give.
struct Wobble {
  mat3 frame;
  Channel weights;
  std::vector<vec3> sphere;

  void operator()(double time, std::span<vec3> out) const {
    std::array<float, kTargets> weight;
    sample_channel(weights, time, weight);
    parallel_for(out.size(), 4096, [&](size_t begin, size_t end) {
      const mat3 to_shape = glm::transpose(frame);
      for (size_t i = begin; i < end; ++i) {
        const vec3 p = to_shape * sphere[i];
        vec3 moved(0.0f);
        for (uint32_t t = 0; t < kTargets; ++t) moved += weight[t] * displacement(t, p);
        out[i] = sphere[i] + frame * moved;
      }
    });
  }
};

void add_targets(Mesh& mesh, const mat3& frame) {
  const size_t count = mesh.positions.size();
  mesh.normals = mesh.positions;  // of a sphere
  mesh.morph_targets = kTargets;
  mesh.morph_weights.assign(kTargets, 0.0f);
  mesh.morph_positions.resize(kTargets * count);
  mesh.morph_normals.resize(kTargets * count);
  mesh.morph_names = {"stretch", "shear", "pear", "cube", "ripples", "twist"};
  parallel_for(kTargets, 1, [&](size_t target, size_t) {
    const std::span<vec3> deltas(&mesh.morph_positions[target * count], count);
    std::vector<vec3> moved(count);
    for (size_t i = 0; i < count; ++i) {
      const vec3 p = glm::transpose(frame) * mesh.positions[i];
      deltas[i] = frame * displacement(static_cast<uint32_t>(target), p);
      moved[i] = mesh.positions[i] + deltas[i];
    }
    const std::vector<vec3> normals = vertex_normals(moved, mesh.triangles);
    for (size_t i = 0; i < count; ++i) {
      mesh.morph_normals[target * count + i] = normals[i] - mesh.normals[i];
    }
  });
}

// Weights of one body: every target swings with two frequencies that fit the clip.
Channel weights_channel(uint32_t node, uint32_t body) {
  Random random(hash_combine(23, body));
  const std::vector<float> times = even_times(kFrames, kFrames / kFps);
  std::vector<float> values(times.size() * kTargets);
  for (uint32_t t = 0; t < kTargets; ++t) {
    const float slow = 3.0f + std::floor(random.uniform(0.0f, 3.0f));
    const float fast = 7.0f + std::floor(random.uniform(0.0f, 5.0f));
    const float slow_phase = random.uniform(), fast_phase = random.uniform();
    for (size_t k = 0; k < times.size(); ++k) {
      const float u = static_cast<float>(k % kFrames) / kFrames;
      values[k * kTargets + t] = 0.65f * std::sin(kTwoPi * (slow * u + slow_phase)) +
                                 0.35f * std::sin(kTwoPi * (fast * u + fast_phase));
    }
  }
  return value_channel(node, ChannelPath::weights, kTargets, times, std::move(values));
}

// A square arrangement in the plane y = 0, with some height to it.
vec3 body_position(uint32_t body, uint32_t bodies) {
  const uint32_t side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<float>(bodies))));
  const uint32_t rows = (bodies + side - 1) / side;
  Random random(hash_combine(37, body));
  const float half_width = 0.5f * static_cast<float>(side - 1);
  const float half_depth = 0.5f * static_cast<float>(rows - 1);
  return vec3(kSpacing * (static_cast<float>(body % side) - half_width),
              random.uniform(-0.9f, 0.9f),
              kSpacing * (static_cast<float>(body / side) - half_depth));
}

void add_materials(Scene& scene) {
  constexpr std::array<vec3, kShapes> colors{
      vec3(0.95f, 0.64f, 0.30f), vec3(0.90f, 0.90f, 0.92f), vec3(0.20f, 0.45f, 0.80f),
      vec3(0.85f, 0.25f, 0.22f), vec3(0.95f, 0.80f, 0.45f), vec3(0.25f, 0.62f, 0.45f),
      vec3(0.55f, 0.40f, 0.75f), vec3(0.93f, 0.50f, 0.40f), vec3(0.30f, 0.68f, 0.75f)};
  for (uint32_t i = 0; i < kShapes; ++i) {
    scene.materials.push_back(
        colored_material("mirror " + std::to_string(i + 1), colors[i], 0.08f, 0.75f));
  }
}

struct CameraKey {
  float frame;
  vec3 eye, target;
};
// Around the nine bodies, in between them, and at frame 200 (index 199) a look past them.
constexpr std::array<CameraKey, 9> kPath{{
    {0, {0.0f, 5.0f, 13.0f}, {0.0f, -0.3f, 0.0f}},
    {45, {9.0f, 3.5f, 9.5f}, {0.0f, 0.0f, 0.0f}},
    {85, {6.5f, 2.6f, 1.6f}, {-1.0f, -0.3f, -0.4f}},
    {120, {8.5f, 5.0f, -8.5f}, {0.0f, 0.0f, 0.0f}},
    {160, {-3.0f, 4.5f, -11.0f}, {0.0f, 0.0f, 0.0f}},
    {182, {-7.0f, 3.0f, -8.0f}, {-4.0f, 0.3f, 0.0f}},
    {199, {-8.0f, 2.5f, -4.5f}, {-7.9f, 1.4f, 4.5f}},
    {220, {-9.5f, 3.0f, 1.5f}, {-3.0f, 0.2f, 3.0f}},
    {248, {-8.0f, 4.5f, 9.0f}, {0.0f, 0.0f, 0.0f}},
}};

// The closed path at a frame: cubic Hermite pieces with Catmull-Rom tangents.
CameraConfig camera_at(float frame, float scale) {
  const size_t n = kPath.size();
  size_t i = n - 1;
  while (kPath[i].frame > frame) --i;
  const auto key = [&](size_t k) {  // k may be n or n + 1: the next round
    CameraKey result = kPath[k % n];
    result.frame += k >= n ? static_cast<float>(kFrames) : 0.0f;
    return result;
  };
  CameraKey before = key((i + n - 1) % n);
  if (i == 0) before.frame -= static_cast<float>(kFrames);
  const CameraKey from = key(i), to = key(i + 1), after = key(i + 2);
  const float span = to.frame - from.frame, u = (frame - from.frame) / span;
  const auto hermite = [&](vec3 CameraKey::*member) {
    const vec3 a = from.*member, b = to.*member;
    const vec3 ta = (b - before.*member) * (span / (to.frame - before.frame));
    const vec3 tb = (after.*member - a) * (span / (after.frame - from.frame));
    const float u2 = u * u, u3 = u2 * u;
    return (2.0f * u3 - 3.0f * u2 + 1.0f) * a + (u3 - 2.0f * u2 + u) * ta +
           (3.0f * u2 - 2.0f * u3) * b + (u3 - u2) * tb;
  };
  return {scale * hermite(&CameraKey::eye), scale * hermite(&CameraKey::target), 0.75f};
}

void add_camera_path(Scene& scene, Clip& clip, float scale) {
  const uint32_t camera = add_camera(scene, "Flight", camera_at(0.0f, scale));
  const std::vector<float> times = even_times(kFrames, kFrames / kFps);
  std::vector<vec3> eyes;
  std::vector<quat> rotations;
  for (size_t k = 0; k < times.size(); ++k) {
    const CameraConfig view = camera_at(static_cast<float>(k % kFrames), scale);
    eyes.push_back(view.eye);
    rotations.push_back(facing(view.target - view.eye));
  }
  clip.channels.push_back(translation_channel(camera, times, eyes));
  clip.channels.push_back(rotation_channel(camera, times, rotations));
}

}  // namespace

const StudyInfo bodies_info{
    "bodies", "nine wobbling mirror bodies of 81,920 triangles and a camera that flies around them",
    kParameters};

Result<Scene> make_bodies(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t subdivisions, arguments.integer("subdivisions", 2, 7));
  SINEW_TRY(const uint32_t bodies, arguments.integer("bodies", 1, 64));
  SINEW_TRY(const uint32_t motion, arguments.choice("motion", {"morph", "free"}));
  const bool free = motion == 1;

  Scene scene;
  add_materials(scene);
  Clip clip;
  clip.name = "Wobble";
  clip.end = kFrames / kFps;

  const TriangleSurface sphere = geodesic_sphere(1u << subdivisions);
  for (uint32_t body = 0; body < bodies; ++body) {
    const uint32_t shape = body % kShapes;
    const uint32_t node =
        add_node(scene, "body " + std::to_string(body + 1), body_position(body, bodies));
    Channel weights = weights_channel(node, body);
    // Morphing bodies of one shape share its mesh; a program belongs to one body.
    const uint32_t mesh_index = free ? body : shape;
    scene.nodes[node].mesh = static_cast<int32_t>(mesh_index);
    if (mesh_index == scene.meshes.size()) {
      Mesh mesh = single_part_mesh(sphere, shape);
      mesh.name = scene.nodes[node].name;
      if (free) {
        mesh.vertex_program = Wobble{shape_frame(shape), weights, sphere.positions};
      } else {
        add_targets(mesh, shape_frame(shape));
      }
      scene.meshes.push_back(std::move(mesh));
    }
    if (!free) clip.channels.push_back(std::move(weights));
  }

  const float scale = std::max(1.0f, std::sqrt(static_cast<float>(bodies)) / 3.0f);
  add_lamp(scene, "warm lamp", scale * vec3(9.0f, 11.0f, 8.0f), {1.0f, 0.93f, 0.82f},
           700.0f * scale * scale);
  add_lamp(scene, "cool lamp", scale * vec3(-10.0f, 7.0f, -6.0f), {0.75f, 0.86f, 1.0f},
           400.0f * scale * scale);
  add_camera_path(scene, clip, scale);
  scene.clips.push_back(std::move(clip));
  scene.environment = {{0.05f, 0.13f, 0.34f}, {0.50f, 0.55f, 0.62f}, {0.035f, 0.032f, 0.045f}, {}};
  scene.default_frames = kFrames;
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
