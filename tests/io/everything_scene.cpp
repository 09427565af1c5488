#include "io/everything_scene.h"

#include <cmath>

#include "scene/small_scenes.h"

namespace sinew::test {
namespace {

constexpr uint32_t kSide = 4;  // vertices along a side of the grid

// A grid of kSide x kSide vertices in the plane z = 0, slightly uneven.
Mesh grid(const std::string& name) {
  Mesh mesh;
  mesh.name = name;
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const float height = 0.1f * static_cast<float>((x * 7 + y * 3) % 5);
      mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), height});
    }
  }
  for (uint32_t y = 0; y + 1 < kSide; ++y) {
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = y * kSide + x;
      mesh.triangles.push_back({a, a + 1, a + kSide});
      mesh.triangles.push_back({a + 1, a + kSide + 1, a + kSide});
    }
  }
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  mesh.parts = {{}};
  return mesh;
}

// Texture coordinates and colours with a seam between any two triangles, and parts of both kinds
// that take turns.
void add_seams(Mesh& mesh) {
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.corners.push_back(uvec3(3 * t) + uvec3(0, 1, 2));
    for (uint32_t k = 0; k < 3; ++k) {
      const float u = static_cast<float>(t % 3), v = static_cast<float>(k);
      mesh.texcoords[0].push_back({u, v});
      mesh.texcoords[1].push_back({v, -u});
      mesh.colors.push_back({0.25f * u, 0.5f, 1.5f * v, 1.0f});
    }
    mesh.triangle_part[t] = t % 3;
  }
  mesh.parts = {{0, false}, {1, true}, {2, false}};
}

// Six influences a vertex, two of them by one joint, of 300 joints.
void add_skin(Mesh& mesh) {
  mesh.influences = 6;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    for (uint32_t k = 0; k < 6; ++k) {
      mesh.joints.push_back(k == 5 ? static_cast<uint16_t>(v) : static_cast<uint16_t>(v + 50 * k));
      mesh.weights.push_back(k == 5 ? 0.25f : 0.15f);
    }
  }
}

void add_morphs(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), vec3(0, 0, 1));
  mesh.tangents.assign(mesh.positions.size(), vec4(1, 0, 0, -1));
  mesh.morph_targets = 2;
  mesh.morph_weights = {0.5f, 0.0f};
  mesh.morph_names = {"up", "wave \"quoted\""};
  for (uint32_t t = 0; t < 2; ++t) {
    for (const vec3& p : mesh.positions) {
      mesh.morph_positions.push_back(t == 0 ? vec3(0, 0, 1) : vec3(0, 0, std::sin(p.x)));
      mesh.morph_normals.push_back(t == 0 ? vec3(0) : vec3(-std::cos(p.x), 0, 0));
    }
  }
}

void add_keys(Mesh& mesh) {
  mesh.keys = 5;
  for (uint32_t key = 0; key < mesh.keys; ++key) {
    for (const vec3& p : mesh.positions) {
      const float turn = static_cast<float>(key) + p.x;
      mesh.key_positions.push_back(p + vec3(0, 0, std::sin(turn)));
    }
  }
}

Channel with(Interpolation interpolation, Channel channel) {
  channel.interpolation = interpolation;
  return channel;
}

void add_materials(Scene& scene) {
  scene.images = {Image8{2, 2, std::vector<uint8_t>(16, 200)}, Image8{3, 1, {}}};
  scene.images[1].pixels = {255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 0};
  scene.materials.resize(4);
  Material& glass = scene.materials[0];
  glass.name = "gl\xc3\xa4sern \xff";  // the last byte is no UTF-8
  glass.transmission = 0.9f;
  glass.transmission_texture.image = 0;
  glass.thin = false;
  glass.ior = 1.33f;
  glass.attenuation_color = {0.5f, 0.75f, 1.0f};
  glass.attenuation_distance = 2.0f;
  glass.double_sided = false;
  Material& paint = scene.materials[1];
  paint.name = "paint";
  paint.base_color = {0.5f, 0.25f, 0.125f, 0.75f};
  paint.base_color_texture = {1, 1, Wrap::mirror, Wrap::clamp, true, {0.5f, 0.25f}, 0.5f, {2, 3}};
  paint.normal_texture = {0, 0, Wrap::clamp, Wrap::repeat, false, {0, 0}, 0.0f, {1, 1}};
  paint.normal_scale = 0.5f;
  paint.occlusion_texture.image = 0;
  paint.occlusion_strength = 0.25f;
  paint.emissive = {4.0f, 2.0f, 0.0f};
  paint.alpha_mode = AlphaMode::mask;
  paint.alpha_cutoff = 0.25f;
  paint.specular = 0.5f;
  paint.specular_color = {2.0f, 1.0f, 0.5f};
  scene.materials[2].unlit = true;
  scene.materials[2].alpha_mode = AlphaMode::blend;
  scene.materials[2].emissive = {0.5f, 0.5f, 0.5f};
  scene.materials[3].metallic = 1.0f;
  scene.materials[3].metallic_roughness_texture.image = 1;
}

void add_views(Scene& scene) {
  scene.cameras = {{"eye", false, 0.8f, 1.0f, 0.0f}, {"plan", true, 0.8f, 5.0f, 0.0f}};
  scene.lights.resize(4);
  scene.lights[0] = {"sun", LightType::directional, {1.0f, 0.9f, 0.8f}, 3.0f, 0.0f, true, 0, 0.7f};
  scene.lights[1] = {"lamp", LightType::point, {2.0f, 1.0f, 0.5f}, 10.0f, 50.0f, true, 0, 0.7f};
  scene.lights[2] = {"spot", LightType::spot, {1, 1, 1}, 10.0f, 0.0f, true, 0.5f, 0.5f};
  scene.lights[3] = {"even", LightType::point, {1, 1, 1}, 2.5f, 0.0f, false, 0, 0.7f};
  for (int32_t i = 0; i < 4; ++i) {
    scene.nodes.push_back(node(-1, vec3(static_cast<float>(i), 5.0f, 2.0f)));
    scene.nodes.back().light = i;
    scene.nodes.back().camera = i < 2 ? i : -1;
  }
}

// 300 joints in two trees; joint 299 is node of joint 0 once more, bound elsewhere.
void add_skeleton(Scene& scene) {
  Skin skin{"bones", {}, {}};
  const uint32_t first = static_cast<uint32_t>(scene.nodes.size());
  for (uint32_t j = 0; j < 299; ++j) {
    const bool root = j == 0 || j == 150;
    scene.nodes.push_back(node(root ? -1 : static_cast<int32_t>(first + j - 1), vec3(0, 0, 0.01f)));
    skin.joints.push_back(first + j);
  }
  skin.joints.push_back(first);
  skin.inverse_bind.assign(300, identity_affine());
  skin.inverse_bind[299][3] = vec3(0.5f, 0, 0);
  scene.skins = {skin, {"unused", {first}, {identity_affine()}}};
}

enum Index : uint32_t { kSeams, kSkinned, kMorphed, kCached, kProgram, kFlattened, kHidden };

// Every interpolation, some keys before 0, two channels for one property.
Clip motion_clip(const Scene& scene) {
  const uint32_t joint = scene.skins[0].joints[10];
  Clip clip{"all at once", -0.5, 2.0, {}};
  clip.channels = {
      channel(joint, ChannelPath::rotation, 4, {-0.5f, 1.0f}, {0, 0, 0, 2, 0, 0, 0.6f, 0.8f}),
      with(Interpolation::step, channel(joint, ChannelPath::scale, 3, {0, 1}, {1, 1, 1, 2, 1, 3})),
      with(Interpolation::cubic_spline,
           channel(joint, ChannelPath::translation, 3, {0.25f, 1.5f},
                   {0, 0, 0, 1, 0, 0, 0, 2, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1})),
      with(Interpolation::cubic_spline, channel(joint + 1, ChannelPath::rotation, 4, {0.5f},
                                                {0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0})),
      channel(kMorphed, ChannelPath::weights, 2, {0, 2}, {0, 1, 1, 0}),
      channel(kMorphed, ChannelPath::translation, 3, {0, 2}, {9, 9, 9, 9, 9, 9}),
      channel(kMorphed, ChannelPath::translation, 3, {0, 2}, {0, 0, 0, 1, 2, 3}),
      with(Interpolation::step,
           channel(kSeams, ChannelPath::visibility, 1, {0, 0.5f, 1.5f}, {1, 0, 1})),
      channel(kHidden, ChannelPath::visibility, 1, {0, 2}, {0, 1}),
      channel(kCached, ChannelPath::cache_key, 1, {0, 0.5f, 2.0f}, {0, 4, 1}),
  };
  return clip;
}

}  // namespace

Scene everything_scene() {
  Scene scene;
  for (const char* name : {"seams", "skinned", "morphed", "cached", "program", "", "shared"}) {
    scene.meshes.push_back(grid(name));
  }
  add_seams(scene.meshes[kSeams]);
  add_skin(scene.meshes[kSkinned]);
  add_morphs(scene.meshes[kMorphed]);
  add_keys(scene.meshes[kCached]);
  add_seams(scene.meshes[kCached]);
  const std::vector<vec3> rest = scene.meshes[kProgram].positions;
  scene.meshes[kProgram].vertex_program = [rest](double time, std::span<vec3> out) {
    for (size_t v = 0; v < rest.size(); ++v) {
      out[v] = rest[v] + vec3(0, 0, static_cast<float>(std::sin(3.0 * time + double{rest[v].x})));
    }
  };
  scene.meshes[kFlattened].parts[0].flat = true;
  for (int32_t i = 0; i < 7; ++i) {
    scene.nodes.push_back(node(i == kSeams ? -1 : i / 3, vec3(0.5f * static_cast<float>(i), 1, 0)));
    scene.nodes.back().name = "node " + std::to_string(i);
    scene.nodes.back().mesh = i;
  }
  scene.nodes[kSkinned].skin = 0;
  scene.nodes[kMorphed].weights = {0.25f, 0.5f};
  scene.nodes[kCached].has_matrix = true;  // shears and mirrors
  scene.nodes[kCached].matrix = Affine(1, 0.5f, 0, 0.25f, -2, 0, 0, 0.75f, 1, 4, 5, 6);
  scene.nodes[kFlattened].has_matrix = true;
  scene.nodes[kFlattened].matrix = Affine(1, 1, 0, 2, 2, 0, 0, 0, 0, 1, 2, 3);
  scene.nodes[kHidden].visible = false;
  add_materials(scene);
  add_views(scene);
  add_skeleton(scene);
  scene.clips = {motion_clip(scene), {"cache only", 0.0, 1.0, {}}, {"still", 0.0, 0.0, {}}};
  scene.clips[1].channels = {channel(kCached, ChannelPath::cache_key, 1, {0, 1}, {0, 4})};
  scene.environment.zenith = {0.1f, 0.2f, 0.3f};
  scene.environment.ambient = vec3(0.5f);
  scene.default_fps = 12.0;
  scene.default_frames = 30;
  scene.name = "everything";
  list_objects(scene);
  return scene;
}

}  // namespace sinew::test
