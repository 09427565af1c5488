// study:creature: a small dragon that walks on a turning disc. Its body is an implicit surface
// around a skeleton (creature_body.h), its skin is painted in space (creature_paint.h), and its
// walk is planned from its feet (creature_walk.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/creature_body.h"
#include "sinew/scene/procedural/creature_paint.h"
#include "sinew/scene/procedural/creature_parts.h"
#include "sinew/scene/procedural/creature_skeleton.h"
#include "sinew/scene/procedural/creature_walk.h"
#include "sinew/scene/procedural/implicit_mesh.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"
#include "sinew/scene/procedural/unwrap.h"

namespace sinew {
namespace {

constexpr uint32_t kFrames = 48;
constexpr double kFps = 24.0;

constexpr StudyParameter kParameters[] = {
    {"triangles", "about how many triangles the creature has, 8000 to 2000000", "40000"},
    {"texture", "side of the skin's textures in texels, 256 to 4096", "1024"},
};

enum CreatureMaterial : uint32_t {
  kSkinMaterial,
  kHornMaterial,
  kPlateMaterial,
  kEyeMaterial,
  kGroundMaterial
};

// Shares of the triangles, about; the body takes the rest.
constexpr float kArmourShare = 0.16f, kEyesShare = 0.04f;

Mesh make_body(const CreatureBody& body, uint32_t triangles, uint32_t texture, Scene& scene) {
  const Field field = [&](vec3 p) { return body.field(p); };
  ImplicitMeshConfig config;
  config.box = body.box();
  config.cell = cell_for_triangles(field, config.box, triangles);
  const ImplicitMesh shape = mesh_implicit(field, config);

  std::vector<SkinWeights> weights(shape.normals.size());
  parallel_for(weights.size(), 512, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) weights[v] = body.skin_weights(shape.surface.positions[v]);
  });
  const Unwrapping unwrapping =
      unwrap(shape.surface.positions, shape.normals, shape.surface.triangles, texture);
  PaintedTextures textures = paint_skin(shape, skin_regions(shape, weights), unwrapping, texture);
  scene.images.push_back(std::move(textures.color));
  scene.images.push_back(std::move(textures.normal));

  Mesh mesh = single_part_mesh(shape.surface, kSkinMaterial);
  mesh.name = "body";
  mesh.corners = unwrapping.corners;
  mesh.texcoords[0] = unwrapping.texcoords;
  for (const uint32_t v : unwrapping.vertices) mesh.normals.push_back(shape.normals[v]);
  mesh.influences = SkinWeights::kInfluences;
  for (const SkinWeights& w : weights) {
    mesh.joints.insert(mesh.joints.end(), w.joints.begin(), w.joints.end());
    mesh.weights.insert(mesh.weights.end(), w.weights.begin(), w.weights.end());
  }
  return mesh;
}

// Flagstones in rings: two by two of them in the texture.
vec3 flagstones(float u, float v) {
  const float row = std::floor(2.0f * v);
  const float x = 2.0f * u + 0.5f * row, y = 2.0f * v - row;
  const float column = std::fmod(std::floor(x), 2.0f);
  const float fx = x - std::floor(x);
  const float wobble = 0.02f * fractal_noise(vec3(6.0f * u, 6.0f * v, 1.0f), 2, 6);
  const float edge = std::min(std::min(fx, 1.0f - fx), std::min(y, 1.0f - y)) + wobble;
  const float stone = glm::smoothstep(0.015f, 0.045f, edge);
  const float tone =
      0.88f + 0.18f * unit_float(hash_u32(static_cast<uint32_t>(2.0f * row + column)));
  const float grain = fractal_noise(vec3(14.0f * u, 14.0f * v, 2.0f), 5, 7);
  const vec3 face = vec3(0.34f, 0.275f, 0.21f) * tone * (1.0f + 0.35f * grain);
  return glm::mix(vec3(0.12f, 0.105f, 0.08f), face, stone);
}

uint32_t add_ground(Scene& scene, const Treadmill& treadmill) {
  scene.images.push_back(paint_image(512, 512, flagstones));
  Material ground = colored_material("flagstones", vec3(1.0f), 0.85f);
  ground.base_color_texture.image = static_cast<int32_t>(scene.images.size() - 1);
  scene.materials.push_back(std::move(ground));
  DiscConfig disc;
  disc.radius = 8.0f;
  disc.rings = 16;
  disc.sectors = 8 * treadmill.loops_a_turn;
  disc.turns = 2.0f * static_cast<float>(treadmill.loops_a_turn);
  disc.ring_height = 0.5f;
  disc.rim = 0.25f;
  Mesh mesh = make_disc(disc, kGroundMaterial);
  mesh.name = "ground";
  const uint32_t node = add_mesh_node(scene, std::move(mesh));
  scene.nodes[node].translation = treadmill.center;
  return node;
}

void add_materials(Scene& scene) {
  Material skin = colored_material("skin", vec3(1.0f), 0.55f);
  skin.base_color_texture.image = 0;
  skin.normal_texture.image = 1;
  scene.materials.push_back(std::move(skin));
  scene.materials.push_back(colored_material("horn", vec3(1.0f), 0.35f));
  scene.materials.push_back(colored_material("plate", vec3(1.0f), 0.45f));
  Material eye = colored_material("eye", vec3(1.0f), 0.06f);
  eye.base_color_texture.image = 2;
  eye.base_color_texture.wrap_s = eye.base_color_texture.wrap_t = Wrap::clamp;
  scene.materials.push_back(std::move(eye));
}

void add_views(Scene& scene) {
  add_sun(scene, "key", {{0.95f, 1.15f, 0.55f}, {1.0f, 0.90f, 0.74f}, 4.2f});
  add_sun(scene, "fill", {{-0.3f, 0.55f, 1.2f}, {0.62f, 0.78f, 1.0f}, 0.75f});
  add_camera(scene, "Three-quarter", {{2.75f, 1.30f, 2.75f}, {0.0f, 0.50f, -0.24f}, 0.52f});
  add_camera(scene, "Side", {{5.1f, 1.05f, -0.40f}, {0.0f, 0.55f, -0.40f}, 0.52f});
  add_camera(scene, "Portrait", {{1.15f, 1.15f, 2.05f}, {0.0f, 0.88f, 0.72f}, 0.50f});
  scene.environment = {{0.10f, 0.22f, 0.46f}, {0.50f, 0.58f, 0.62f}, {0.16f, 0.13f, 0.10f}};
}

}  // namespace

const StudyInfo creature_info{
    "creature", "a textured little dragon with 33 joints that walks (clips Walk and Look)",
    kParameters};

Result<Scene> make_creature(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 8000, 2000000));
  SINEW_TRY(const uint32_t texture, arguments.integer("texture", 256, 4096));
  Scene scene;
  add_materials(scene);
  const uint32_t first_joint = add_skeleton(scene, creature_skeleton(), "creature");
  const CreatureBody body;
  const float count = static_cast<float>(triangles);
  std::array<Mesh, 3> meshes;
  meshes[1] = make_creature_armour(body, static_cast<uint32_t>(kArmourShare * count), kHornMaterial,
                                   kPlateMaterial);
  meshes[2] = make_creature_eyes(static_cast<uint32_t>(kEyesShare * count), kEyeMaterial);
  const size_t worn = meshes[1].triangles.size() + meshes[2].triangles.size();
  meshes[0] = make_body(body, triangles - static_cast<uint32_t>(worn), texture, scene);
  scene.images.push_back(paint_eye(256));
  for (Mesh& mesh : meshes) {
    const uint32_t node = add_mesh_node(scene, std::move(mesh));
    scene.nodes[node].skin = 0;
  }
  const Treadmill treadmill;
  const uint32_t disc = add_ground(scene, treadmill);
  add_views(scene);
  scene.clips.push_back(walk_clip(treadmill, first_joint, disc));
  scene.clips.push_back(look_clip(first_joint, disc));
  scene.default_frames = kFrames;
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
