#include "sinew/io/gltf/node.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/io/gltf/affine.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/io/gltf/extras.h"

namespace sinew::gltf {
namespace {

// Whether the node only shows and hides the one below it (see kVisibilityExtra).
Result<bool> is_visibility(const NodeGraph& graph, const Json& json) {
  if (!has_flag(json, kVisibilityExtra)) return false;
  SINEW_TRY(const std::vector<uint32_t> children, json.indices("children", graph.nodes.size()));
  if (children.size() != 1 || json.has("mesh") || json.has("camera") || json.has("matrix")) {
    return json.error("is marked to show and hide one node, but is more than that");
  }
  return true;
}

// Unit length, unless the file's rotation has none at all.
quat rotation_of(const Reader& reader, const Json& json, vec4 xyzw) {
  const double size = length(glm::dvec4(xyzw));
  if (!(size > 1e-12)) {
    reader.warnings.add(json.element(), "a rotation has no length; taken as no rotation");
    return glm::identity<quat>();
  }
  const glm::dvec4 unit = glm::dvec4(xyzw) / size;
  return quat(vec4(unit).w, vec4(unit).x, vec4(unit).y, vec4(unit).z);
}

Result<void> read_transform(const Reader& reader, const Json& json, Node& out) {
  std::array<float, 16> matrix{};
  SINEW_TRY(out.has_matrix, json.numbers("matrix", matrix));
  if (out.has_matrix) {
    const auto affine = affine_of(matrix);
    if (!affine) return json.error("\"matrix\" is not affine: its last row must be 0, 0, 0, 1");
    out.matrix = *affine;
    return {};
  }
  vec4 rotation(0, 0, 0, 1);
  SINEW_CHECKED(json.numbers("translation", {&out.translation.x, 3}));
  SINEW_CHECKED(json.numbers("rotation", {&rotation.x, 4}));
  SINEW_CHECKED(json.numbers("scale", {&out.scale.x, 3}));
  out.rotation = rotation_of(reader, json, rotation);
  return {};
}

// One rigid child of node `parent` for each instance (EXT_mesh_gpu_instancing).
Result<std::vector<Node>> read_instances(const Reader& reader, const Json& json, const Node& parent,
                                         int32_t parent_index) {
  SINEW_TRY(const Json extensions, json.object("extensions"));
  SINEW_TRY(const Json extension, extensions.object("EXT_mesh_gpu_instancing"));
  SINEW_TRY(const Json attributes, extension.object("attributes"));
  std::vector<vec3> translations, scales;
  std::vector<vec4> rotations;
  if (attributes.has("TRANSLATION")) {
    SINEW_TRY(const Accessor accessor,
              reader.accessors.find(attributes, "TRANSLATION", 3, Numbers::real));
    SINEW_TRY(translations, read_vector<vec3>(reader, accessor));
  }
  if (attributes.has("ROTATION")) {
    SINEW_TRY(const Accessor accessor,
              reader.accessors.find(attributes, "ROTATION", 4, Numbers::real_or_normalized));
    SINEW_TRY(rotations, read_vector<vec4>(reader, accessor));
  }
  if (attributes.has("SCALE")) {
    SINEW_TRY(const Accessor accessor,
              reader.accessors.find(attributes, "SCALE", 3, Numbers::real));
    SINEW_TRY(scales, read_vector<vec3>(reader, accessor));
  }
  const size_t count = std::max({translations.size(), rotations.size(), scales.size()});
  for (const size_t size : {translations.size(), rotations.size(), scales.size()}) {
    if (size != 0 && size != count) {
      return json.error("its instances have different numbers of translations, rotations, scales");
    }
  }
  const uint64_t each =
      2 * sizeof(Node) + parent.name.size() + sizeof(float) * parent.weights.size();
  SINEW_CHECKED(reader.budget.take(json, count, each));
  std::vector<Node> result(count);
  for (size_t i = 0; i < count; ++i) {
    Node& node = result[i];
    node.name = fmt::format("{} {}", parent.name, i);
    node.parent = parent_index;
    node.mesh = parent.mesh;
    node.weights = parent.weights;
    if (!translations.empty()) node.translation = translations[i];
    if (!rotations.empty()) node.rotation = rotation_of(reader, json, rotations[i]);
    if (!scales.empty()) node.scale = scales[i];
  }
  return result;
}

Result<void> read_links(const Json& json, std::span<const int32_t> meshes, const Scene& scene,
                        Node& out) {
  SINEW_TRY(const auto mesh, json.index("mesh", meshes.size()));
  if (mesh) out.mesh = meshes[*mesh];
  if (!scene.octrees.empty()) {
    SINEW_TRY(const auto octree, extras_of(json).index(kOctreeExtra, scene.octrees.size()));
    if (octree && mesh) return json.error("has both a mesh and an octree");
    if (octree) out.octree = static_cast<int32_t>(*octree);
  }
  SINEW_TRY(const auto camera, json.index("camera", scene.cameras.size()));
  if (camera) out.camera = static_cast<int32_t>(*camera);
  SINEW_TRY(const Json extensions, json.object("extensions"));
  SINEW_TRY(const Json lights, extensions.object("KHR_lights_punctual"));
  SINEW_TRY(const auto light, lights.index("light", scene.lights.size()));
  if (light) out.light = static_cast<int32_t>(*light);
  SINEW_TRY(const Json visibility, extensions.object("KHR_node_visibility"));
  SINEW_TRY(out.visible, visibility.boolean("visible", true));
  SINEW_TRY(out.weights, json.number_list("weights"));
  const size_t targets = targets_of(scene, out);
  if (targets == 0) out.weights.clear();
  if (!out.weights.empty() && out.weights.size() != targets) {
    return json.error(
        fmt::format("has {} weights for {} morph targets", out.weights.size(), targets));
  }
  return {};
}

}  // namespace

size_t targets_of(const Scene& scene, const Node& node) {
  if (node.octree >= 0) return scene.octrees[static_cast<size_t>(node.octree)].morph_targets;
  return node.mesh < 0 ? 0 : scene.meshes[static_cast<size_t>(node.mesh)].morph_targets;
}

Result<std::vector<NodePlace>> read_nodes(const Reader& reader, const NodeGraph& graph,
                                          std::span<const int32_t> meshes, Scene& scene) {
  SINEW_CHECKED(reader.budget.take(reader.asset.root(), graph.order.size(), 2 * sizeof(Node)));
  std::vector<NodePlace> places(graph.nodes.size());
  std::vector<int32_t> parent(graph.nodes.size(), -1);  // one a JSON node: in scene.nodes
  bool hidden = false;                                  // by the node just above
  for (const uint32_t index : graph.order) {
    const Json& json = graph.nodes[index];
    const uint32_t here = static_cast<uint32_t>(scene.nodes.size());
    Node node;
    SINEW_TRY(node.name, json.text("name"));
    const int32_t above = graph.parent[index];
    if (above >= 0) node.parent = places[above].visibility ? parent[above] : places[above].node;
    parent[index] = node.parent;
    SINEW_CHECKED(read_transform(reader, json, node));
    SINEW_TRY(const bool visibility, is_visibility(graph, json));
    if (visibility) {  // its child comes next
      hidden = hidden || node.scale.x <= 0.5f;
      places[index] = {static_cast<int32_t>(here), here, 0, true};
      continue;
    }
    SINEW_CHECKED(read_links(json, meshes, scene, node));
    if (std::exchange(hidden, false)) node.visible = false;
    std::vector<Node> instances;
    if (node.mesh >= 0) {
      SINEW_TRY(instances, read_instances(reader, json, node, static_cast<int32_t>(here)));
    }
    places[index] = {static_cast<int32_t>(here), here, 1, false};
    if (!instances.empty()) {
      places[index].first_mesh = here + 1;
      places[index].mesh_count = static_cast<uint32_t>(instances.size());
      node.mesh = -1;
      node.weights.clear();
    }
    scene.nodes.push_back(std::move(node));
    std::move(instances.begin(), instances.end(), std::back_inserter(scene.nodes));
  }
  return places;
}

}  // namespace sinew::gltf
