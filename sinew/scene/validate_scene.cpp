// Every invariant that scene.h, material.h and clip.h state.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "sinew/scene/first_problem.h"
#include "sinew/scene/scene.h"

namespace sinew {
namespace {

// Whether `index` names one of `count` things, or none (-1).
bool is_optional_index(int32_t index, size_t count) {
  return index >= -1 && (index < 0 || static_cast<size_t>(index) < count);
}

void check_mesh(const Scene& scene, const Mesh& mesh, FirstProblem& problem) {
  const std::string in_mesh = validate(mesh);
  problem.expect(in_mesh.empty(), "{}", in_mesh);
  for (const MeshPart& part : mesh.parts) {
    problem.expect(part.material < scene.materials.size(), "material {} where {} exist",
                   part.material, scene.materials.size());
  }
}

void check_octree(const Scene& scene, const Svo& octree, FirstProblem& problem) {
  const std::string in_octree = validate(octree);
  problem.expect(in_octree.empty(), "{}", in_octree);
  for (size_t i = 0; i < octree.cells.size() && !problem.found(); ++i) {
    problem.expect(octree.cells[i].material < scene.materials.size(),
                   "cell {}: material {} where {} exist", i, octree.cells[i].material,
                   scene.materials.size());
  }
}

void check_image(const Image8& image, FirstProblem& problem) {
  problem.expect(image.width > 0 && image.height > 0, "no pixels");
  problem.expect_size("pixels", image.pixels.size(), size_t{4} * image.width * image.height);
}

void check_texture(const Scene& scene, const TextureRef& texture, FirstProblem& problem) {
  problem.expect(is_optional_index(texture.image, scene.images.size()), "image {} where {} exist",
                 texture.image, scene.images.size());
  problem.expect(texture.texcoord < std::extent_v<decltype(Mesh::texcoords)>,
                 "texture coordinate set {}", texture.texcoord);
  problem.expect_finite("texture offset", texture.offset);
  problem.expect_finite("texture rotation", texture.rotation);
  problem.expect_finite("texture scale", texture.scale);
}

void check_material(const Scene& scene, const Material& material, FirstProblem& problem) {
  check_texture(scene, material.base_color_texture, problem);
  check_texture(scene, material.metallic_roughness_texture, problem);
  check_texture(scene, material.normal_texture, problem);
  check_texture(scene, material.occlusion_texture, problem);
  check_texture(scene, material.emissive_texture, problem);
  problem.expect_finite("base colour", material.base_color);
  problem.expect_finite("metallic", material.metallic);
  problem.expect_finite("roughness", material.roughness);
  problem.expect_finite("normal scale", material.normal_scale);
  problem.expect_finite("occlusion strength", material.occlusion_strength);
  problem.expect_finite("emissive", material.emissive);
  problem.expect_finite("alpha cutoff", material.alpha_cutoff);
  check_texture(scene, material.transmission_texture, problem);
  problem.expect_finite("specular", material.specular);
  problem.expect_finite("specular colour", material.specular_color);
  problem.expect(material.ior >= 1.0f && material.ior < 1e3f, "index of refraction {}",
                 material.ior);
  problem.expect(material.transmission >= 0.0f && material.transmission <= 1.0f, "transmission {}",
                 material.transmission);
  problem.expect_finite("attenuation colour", material.attenuation_color);
  problem.expect(material.attenuation_distance >= 0.0f && material.attenuation_distance < 1e30f,
                 "attenuation distance {}", material.attenuation_distance);
}

// Morph targets of what the node shows.
size_t targets_of(const Scene& scene, const Node& node) {
  if (node.octree >= 0) return scene.octrees[node.octree].morph_targets;
  return node.mesh < 0 ? 0 : scene.meshes[node.mesh].morph_targets;
}

void check_node(const Scene& scene, const Node& node, FirstProblem& problem) {
  const size_t index = static_cast<size_t>(&node - scene.nodes.data());
  problem.expect(is_optional_index(node.parent, index), "parent {} is no earlier node",
                 node.parent);
  problem.expect(is_optional_index(node.mesh, scene.meshes.size()), "no mesh {}", node.mesh);
  problem.expect(is_optional_index(node.octree, scene.octrees.size()), "no octree {}", node.octree);
  problem.expect(node.mesh < 0 || node.octree < 0, "both mesh {} and octree {}", node.mesh,
                 node.octree);
  problem.expect(is_optional_index(node.skin, scene.skins.size()), "no skin {}", node.skin);
  problem.expect(is_optional_index(node.camera, scene.cameras.size()), "no camera {}", node.camera);
  problem.expect(is_optional_index(node.light, scene.lights.size()), "no light {}", node.light);
  problem.expect_finite("translation", node.translation);
  problem.expect_finite("rotation", node.rotation);
  problem.expect(length(node.rotation) > 0.0f, "rotation is zero");
  problem.expect_finite("scale", node.scale);
  problem.expect_finite("matrix", node.matrix);
  problem.expect_finite("weights", node.weights);
  if (!problem.found() && !node.weights.empty()) {
    problem.expect_size("weights", node.weights.size(), targets_of(scene, node));
  }
}

void check_skin(const Scene& scene, const Skin& skin, FirstProblem& problem) {
  problem.expect_below("joints", skin.joints, scene.nodes.size());
  problem.expect_size("inverse_bind", skin.inverse_bind.size(), skin.joints.size());
  problem.expect_finite("inverse_bind", skin.inverse_bind);
}

void check_camera(const Camera& camera, FirstProblem& problem) {
  problem.expect(camera.yfov > 0.0f && camera.yfov < 3.14159266f, "yfov is {}", camera.yfov);
  problem.expect_finite("ymag", camera.ymag);
  problem.expect(camera.ymag > 0.0f, "ymag is {}", camera.ymag);
  problem.expect_finite("znear", camera.znear);
  problem.expect(camera.znear >= 0.0f, "znear is {}", camera.znear);
}

void check_light(const Light& light, FirstProblem& problem) {
  problem.expect_finite("colour", light.color);
  problem.expect_finite("intensity", light.intensity);
  problem.expect_finite("range", light.range);
  problem.expect_finite("inner cone", light.inner_cone);
  problem.expect_finite("outer cone", light.outer_cone);
}

void check_objects(const Scene& scene, FirstProblem& problem) {
  size_t with_mesh = 0;
  for (const Node& node : scene.nodes) with_mesh += node.mesh >= 0;
  problem.expect_size("objects", scene.objects.size(), with_mesh);
  for (size_t i = 0; i < scene.objects.size() && !problem.found(); ++i) {
    const SceneObject& object = scene.objects[i];
    problem.expect(object.node < scene.nodes.size(), "object {}: no node {}", i, object.node);
    problem.expect(i == 0 || object.node > scene.objects[i - 1].node,
                   "object {}: not in node order", i);
    if (problem.found()) return;
    const Node& node = scene.nodes[object.node];
    problem.expect(node.mesh >= 0 && object.mesh == static_cast<uint32_t>(node.mesh),
                   "object {}: its mesh is not its node's", i);
    if (problem.found() || object.skin < 0) continue;
    const Mesh& mesh = scene.meshes[object.mesh];
    problem.expect(object.skin == node.skin && mesh.skinnable(),
                   "object {}: its skin is not its node's", i);
    if (problem.found()) return;
    problem.expect_below(fmt::format("object {}: joints of mesh '{}'", i, mesh.name), mesh.joints,
                         scene.skins[object.skin].joints.size());
  }
}

void check_voxels(const Scene& scene, FirstProblem& problem) {
  size_t with_octree = 0;
  for (const Node& node : scene.nodes) with_octree += node.octree >= 0;
  problem.expect_size("voxel objects", scene.voxels.size(), with_octree);
  for (size_t i = 0; i < scene.voxels.size() && !problem.found(); ++i) {
    const SceneVoxels& object = scene.voxels[i];
    problem.expect(object.node < scene.nodes.size(), "voxel object {}: no node {}", i, object.node);
    problem.expect(i == 0 || object.node > scene.voxels[i - 1].node,
                   "voxel object {}: not in node order", i);
    if (problem.found()) return;
    const Node& node = scene.nodes[object.node];
    problem.expect(node.octree >= 0 && object.octree == static_cast<uint32_t>(node.octree),
                   "voxel object {}: its octree is not its node's", i);
    if (problem.found()) return;
    const Svo& octree = scene.octrees[object.octree];
    problem.expect(octree.joints == 0 || object.skin >= 0,
                   "voxel object {}: its octree has joints, but it has no skin", i);
    if (problem.found() || object.skin < 0) continue;
    problem.expect(object.skin == node.skin && octree.joints > 0,
                   "voxel object {}: its skin is not its node's", i);
    if (problem.found()) return;
    const size_t joints = scene.skins[object.skin].joints.size();
    problem.expect(octree.joints <= joints,
                   "voxel object {}: its octree has {} joints where {} exist", i, octree.joints,
                   joints);
  }
}

// Values in one key of a channel; 0 if the node cannot have such a channel.
size_t width_of(const Scene& scene, const Channel& channel) {
  const int32_t mesh = scene.nodes[channel.node].mesh;
  switch (channel.path) {
    case ChannelPath::translation:
    case ChannelPath::scale:
      return 3;
    case ChannelPath::rotation:
      return 4;
    case ChannelPath::weights:
      return targets_of(scene, scene.nodes[channel.node]);
    case ChannelPath::cache_key:
      return mesh < 0 || scene.meshes[mesh].keys == 0 ? 0 : 1;
    case ChannelPath::visibility:
      return 1;
  }
  return 0;
}

void check_channel(const Scene& scene, const Channel& channel, FirstProblem& problem) {
  problem.expect(channel.node < scene.nodes.size(), "no node {}", channel.node);
  if (problem.found()) return;
  const size_t width = width_of(scene, channel);
  problem.expect(width > 0, "node {} has nothing such to animate", channel.node);
  problem.expect_size("width", channel.width, width);
  problem.expect(!channel.times.empty(), "no keys");
  problem.expect_finite("times", channel.times);
  problem.expect(std::ranges::adjacent_find(channel.times, std::ranges::greater_equal{}) ==
                     channel.times.end(),
                 "times do not increase");
  const size_t parts = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
  problem.expect_size("values", channel.values.size(), channel.times.size() * width * parts);
  problem.expect_finite("values", channel.values);
}

void check_clip(const Scene& scene, const Clip& clip, FirstProblem& problem) {
  problem.expect(std::isfinite(clip.start) && std::isfinite(clip.end) && clip.start <= clip.end,
                 "runs from {} to {}", clip.start, clip.end);
  problem.expect_each("channel", clip.channels, [&](const Channel& channel, FirstProblem& own) {
    check_channel(scene, channel, own);
  });
}

}  // namespace

std::string validate(const Scene& scene) {
  FirstProblem problem;
  // Checks that also need the rest of the scene.
  const auto within = [&scene](auto* check) {
    return [&scene, check](const auto& element, FirstProblem& own) { check(scene, element, own); };
  };
  problem.expect_each("mesh", scene.meshes, within(check_mesh));
  problem.expect(scene.meshes.empty() || !scene.materials.empty(), "meshes but no material");
  problem.expect_each("octree", scene.octrees, within(check_octree));
  problem.expect(scene.octrees.empty() || !scene.materials.empty(), "octrees but no material");
  problem.expect_each("image", scene.images, check_image);
  problem.expect_each("material", scene.materials, within(check_material));
  problem.expect_each("node", scene.nodes, within(check_node));
  problem.expect_each("skin", scene.skins, within(check_skin));
  problem.expect_each("camera", scene.cameras, check_camera);
  problem.expect_each("light", scene.lights, check_light);
  if (problem.found()) return problem.text();
  check_objects(scene, problem);
  if (!problem.found()) check_voxels(scene, problem);
  problem.expect_each("clip", scene.clips, within(check_clip));
  problem.expect_finite("zenith", scene.environment.zenith);
  problem.expect_finite("horizon", scene.environment.horizon);
  problem.expect_finite("nadir", scene.environment.nadir);
  problem.expect_finite("ambient", scene.environment.ambient.value_or(vec3(0.0f)));
  problem.expect(scene.default_frames >= 0, "{} frames", scene.default_frames);
  problem.expect(scene.default_fps >= 0.0 && scene.default_fps <= kHighestFps, "{} frames a second",
                 scene.default_fps);
  return problem.text();
}

}  // namespace sinew
