#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sinew/io/gltf/affine.h"
#include "sinew/io/gltf/node.h"

namespace sinew::gltf {
namespace {

Result<std::vector<Affine>> read_inverse_bind(const Reader& reader, const Json& json,
                                              size_t joint_count) {
  std::vector<Affine> result(joint_count, identity_affine());
  if (!json.has("inverseBindMatrices")) return result;
  SINEW_TRY(const Accessor accessor,
            reader.accessors.find(json, "inverseBindMatrices", kMatrixComponents, Numbers::real));
  if (accessor.count < joint_count) {
    return json.error(
        fmt::format("has {} inverse bind matrices for {} joints", accessor.count, joint_count));
  }
  SINEW_TRY(const std::vector<mat4> matrices, read_vector<mat4>(reader, accessor));
  for (size_t i = 0; i < joint_count; ++i) {
    const auto affine = affine_of(std::span<const float>(glm::value_ptr(matrices[i]), 16));
    if (!affine) {
      return accessor.json.error(
          fmt::format("its matrix {} is not affine: the last row must be 0, 0, 0, 1", i));
    }
    result[i] = *affine;
  }
  return result;
}

Result<Skin> read_skin(const Reader& reader, const Json& json, size_t json_node_count,
                       std::span<const NodePlace> places) {
  Skin skin;
  SINEW_TRY(skin.name, json.text("name"));
  SINEW_TRY(skin.joints, json.indices("joints", json_node_count));
  if (skin.joints.empty()) return json.error("has no joints");
  for (uint32_t& joint : skin.joints) {
    if (places[joint].node < 0) {
      return json.error(fmt::format("its joint, node {}, is not part of the scene", joint));
    }
    joint = static_cast<uint32_t>(places[joint].node);
  }
  SINEW_TRY(skin.inverse_bind, read_inverse_bind(reader, json, skin.joints.size()));
  return skin;
}

// Files often repeat one skin for each mesh.
uint32_t find_or_add(Skin skin, std::vector<Skin>& skins) {
  const auto same = std::find_if(skins.begin(), skins.end(), [&](const Skin& other) {
    return other.joints == skin.joints && other.inverse_bind == skin.inverse_bind;
  });
  if (same != skins.end()) return static_cast<uint32_t>(same - skins.begin());
  skins.push_back(std::move(skin));
  return static_cast<uint32_t>(skins.size() - 1);
}

// How many joints what nodes show needs: 1 + the highest that it uses.
class JointLimits {
 public:
  explicit JointLimits(const Scene& scene) : scene_(scene), of_mesh_(scene.meshes.size(), 0) {}

  bool has_joints(const Node& node) const {
    return node.octree >= 0 ? octree(node).joints > 0 : mesh(node).influences > 0;
  }
  size_t of(const Node& node) {
    if (node.octree >= 0) return octree(node).joints;
    size_t& limit = of_mesh_[static_cast<size_t>(node.mesh)];
    if (limit == 0) limit = size_t{1} + *std::ranges::max_element(mesh(node).joints);
    return limit;
  }

 private:
  const Mesh& mesh(const Node& node) const { return scene_.meshes[static_cast<size_t>(node.mesh)]; }
  const Svo& octree(const Node& node) const {
    return scene_.octrees[static_cast<size_t>(node.octree)];
  }

  const Scene& scene_;
  std::vector<size_t> of_mesh_;  // 0: not known yet
};

}  // namespace

Result<void> read_skins(const Reader& reader, const NodeGraph& graph,
                        std::span<const NodePlace> places, Scene& scene) {
  SINEW_TRY(const std::vector<Json> skins, reader.asset.root().objects("skins", "skin"));
  std::vector<int32_t> scene_skin(skins.size(), -1);
  JointLimits limits(scene);
  for (const uint32_t index : graph.order) {
    SINEW_TRY(const auto skin, graph.nodes[index].index("skin", skins.size()));
    Node& node = scene.nodes[static_cast<size_t>(places[index].node)];
    if (!skin || (node.mesh < 0 && node.octree < 0)) continue;
    if (!limits.has_joints(node)) {
      reader.warnings.add(graph.nodes[index].element(),
                          "has a skin, but its mesh has no joints; left rigid");
      continue;
    }
    if (scene_skin[*skin] < 0) {
      SINEW_TRY(Skin read, read_skin(reader, skins[*skin], graph.nodes.size(), places));
      scene_skin[*skin] = static_cast<int32_t>(find_or_add(std::move(read), scene.skins));
    }
    node.skin = scene_skin[*skin];
    const size_t joints = scene.skins[static_cast<size_t>(node.skin)].joints.size();
    if (const size_t limit = limits.of(node); limit > joints) {
      return graph.nodes[index].error(
          fmt::format("its mesh uses joint {}, but its skin has only {}", limit - 1, joints),
          "export the file again");
    }
  }
  return {};
}

}  // namespace sinew::gltf
