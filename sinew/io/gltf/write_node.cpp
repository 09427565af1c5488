#include "sinew/io/gltf/write_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "sinew/io/gltf/affine.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/io/gltf/extras.h"

namespace sinew::gltf {
namespace {

// How a node is placed: `inner` stands in a node of its own.
struct Placement {
  Transform outer;
  std::optional<quat> inner;
};

bool is_same(const Affine& a, const Affine& b) {
  constexpr float kTolerance = 1e-6f;  // of the largest element
  float largest = 0.0f, difference = 0.0f;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      largest = std::max(largest, std::abs(a[column][row]));
      difference = std::max(difference, std::abs(a[column][row] - b[column][row]));
    }
  }
  return difference <= kTolerance * largest;
}

quat unit(const quat& q) {
  return quat(normalize(glm::dquat(q)));
}

Placement place(const Node& node, bool animated) {
  const Transform own{node.translation, unit(node.rotation), node.scale};
  if (!node.has_matrix || animated) return {own, std::nullopt};
  const std::optional<Transform> simple = decompose(node.matrix);
  if (simple && is_same(node.matrix, trs(simple->translation, simple->rotation, simple->scale))) {
    return {*simple, std::nullopt};
  }
  const TransformPair pair = decompose_any(node.matrix);
  return {pair.outer, pair.inner};
}

void set_transform(const Transform& transform, JsonOut& out) {
  const Transform plain;
  const quat& q = transform.rotation;
  if (transform.translation != plain.translation)
    out["translation"] = json_of(transform.translation);
  if (q != plain.rotation) out["rotation"] = json_of(vec4(q.x, q.y, q.z, q.w));
  if (transform.scale != plain.scale) out["scale"] = json_of(transform.scale);
}

class NodeWriter {
 public:
  NodeWriter(const WriteContext& context, std::span<const MeshOutput> meshes,
             std::span<const Clip> clips);

  std::vector<NodeOutput> write();

 private:
  void number_nodes();
  void add_chain(size_t index);
  void number_skin(int32_t skin);
  void add_contents(const Node& node, const SceneObject* object, JsonOut& out);
  void add_octree(const Node& node, JsonOut& out);
  void add_skins();
  JsonOut joints_of(const Skin& skin);
  bool needs_common_root() const;
  void add_environment(JsonOut& scene) const;
  void add_scene(const std::vector<uint32_t>& roots);
  void warn_of_visible_skins() const;

  const WriteContext& context_;
  const Scene& scene_;
  std::span<const MeshOutput> meshes_;
  std::vector<bool> animated_, hides_;  // one a scene node
  std::vector<Placement> placements_;   // one a scene node
  std::vector<NodeOutput> places_;      // one a scene node
  std::vector<int32_t> json_skin_;      // one a scene skin; -1: unused
  int32_t skins_ = 0;                   // used
  std::vector<JsonOut> nodes_;
};

NodeWriter::NodeWriter(const WriteContext& context, std::span<const MeshOutput> meshes,
                       std::span<const Clip> clips)
    : context_(context),
      scene_(context.scene),
      meshes_(meshes),
      animated_(scene_.nodes.size(), false),
      hides_(scene_.nodes.size(), false),
      places_(scene_.nodes.size()),
      json_skin_(scene_.skins.size(), -1) {
  for (const Clip& clip : clips) {
    for (const Channel& channel : clip.channels) {
      if (channel.path == ChannelPath::visibility) hides_[channel.node] = true;
      if (channel.path <= ChannelPath::scale) animated_[channel.node] = true;
    }
  }
}

void NodeWriter::number_nodes() {
  uint32_t next = 0;
  for (size_t i = 0; i < scene_.nodes.size(); ++i) {
    const Node& node = scene_.nodes[i];
    placements_.push_back(place(node, animated_[i]));
    if (hides_[i]) places_[i].visibility = static_cast<int32_t>(next++);
    places_[i].outer = next;
    if (placements_[i].inner) ++next;
    places_[i].main = next++;
    if (places_[i].visibility >= 0) places_[i].outer = static_cast<uint32_t>(places_[i].visibility);
  }
  for (const SceneObject& object : scene_.objects) {
    if (meshes_[object.mesh].json_mesh >= 0) number_skin(object.skin);
  }
  if (!context_.embedded) return;
  for (const SceneVoxels& object : scene_.voxels) number_skin(object.skin);
}

void NodeWriter::number_skin(int32_t skin) {
  if (skin < 0) return;
  int32_t& number = json_skin_[static_cast<size_t>(skin)];
  if (number < 0) number = skins_++;
}

// The JSON nodes of a scene node, from the outermost to the one with its contents.
void NodeWriter::add_chain(size_t index) {
  const Node& node = scene_.nodes[index];
  const auto add_with_child = [&](JsonOut json) {
    json["children"].push_back(nodes_.size() + 1);
    nodes_.push_back(std::move(json));
  };
  if (hides_[index]) {
    JsonOut above = named(node.name.empty() ? "" : node.name + " visibility");
    if (!node.visible) above["scale"] = {0, 0, 0};
    above["extras"][kVisibilityExtra] = true;
    add_with_child(std::move(above));
  }
  const Placement& placement = placements_[index];
  JsonOut main = named(node.name);
  if (placement.inner) {
    JsonOut outer = named(node.name.empty() ? "" : node.name + " shear");
    set_transform(placement.outer, outer);
    add_with_child(std::move(outer));
    set_transform({vec3(0.0f), *placement.inner, vec3(1.0f)}, main);
  } else {
    set_transform(placement.outer, main);
  }
  if (!node.visible && !hides_[index]) {
    context_.asset.use_extension("KHR_node_visibility");
    main["extensions"]["KHR_node_visibility"]["visible"] = false;
  }
  nodes_.push_back(std::move(main));
}

void NodeWriter::add_contents(const Node& node, const SceneObject* object, JsonOut& out) {
  if (node.camera >= 0) out["camera"] = node.camera;
  if (node.light >= 0) out["extensions"]["KHR_lights_punctual"]["light"] = node.light;
  if (node.octree >= 0 && context_.embedded) add_octree(node, out);
  if (!object || meshes_[object->mesh].json_mesh < 0) return;
  out["mesh"] = meshes_[object->mesh].json_mesh;
  if (object->skin >= 0) out["skin"] = json_skin_[static_cast<size_t>(object->skin)];
  const Mesh& mesh = scene_.meshes[object->mesh];
  if (mesh.keys > 0 || mesh.vertex_program) return;
  for (const float weight : node.weights) out["weights"].push_back(double{weight});
}

void NodeWriter::add_octree(const Node& node, JsonOut& out) {
  out["extras"][kOctreeExtra] = node.octree;
  const bool skinned =
      node.skin >= 0 && scene_.octrees[static_cast<size_t>(node.octree)].joints > 0;
  if (skinned) out["skin"] = json_skin_[static_cast<size_t>(node.skin)];
  for (const float weight : node.weights) out["weights"].push_back(double{weight});
}

// A skin must not name a node twice, so a node with two bindings gets a child for the second.
JsonOut NodeWriter::joints_of(const Skin& skin) {
  std::vector<uint32_t> sorted = skin.joints;
  std::sort(sorted.begin(), sorted.end());
  const bool unique = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  std::vector<bool> seen(unique ? 0 : scene_.nodes.size(), false);
  JsonOut joints = JsonOut::array();
  for (const uint32_t joint : skin.joints) {
    if (unique || !seen[joint]) {
      if (!unique) seen[joint] = true;
      joints.push_back(places_[joint].main);
      continue;
    }
    nodes_[places_[joint].main]["children"].push_back(nodes_.size());
    joints.push_back(nodes_.size());
    nodes_.push_back(named(scene_.nodes[joint].name));
  }
  return joints;
}

void NodeWriter::add_skins() {
  std::vector<size_t> order(scene_.skins.size());  // scene skin of each JSON skin
  size_t count = 0;
  for (size_t i = 0; i < json_skin_.size(); ++i) {
    if (json_skin_[i] < 0) continue;
    order[static_cast<size_t>(json_skin_[i])] = i;
    ++count;
  }
  for (size_t k = 0; k < count; ++k) {
    const Skin& skin = scene_.skins[order[k]];
    JsonOut json = named(skin.name);
    json["joints"] = joints_of(skin);
    std::vector<float> matrices;
    for (const Affine& m : skin.inverse_bind) {
      for (int column = 0; column < 4; ++column) {
        const float w = column == 3 ? 1.0f : 0.0f;
        matrices.insert(matrices.end(), {m[column].x, m[column].y, m[column].z, w});
      }
    }
    json["inverseBindMatrices"] =
        context_.asset.add_values(Pool::matrices, matrices, {ComponentType::f32, "MAT4", 16});
    context_.asset.add("skins", std::move(json));
  }
}

// glTF wants the joints of a skin in one tree.
bool NodeWriter::needs_common_root() const {
  std::vector<uint32_t> root(scene_.nodes.size());
  for (uint32_t i = 0; i < root.size(); ++i) {
    const int32_t parent = scene_.nodes[i].parent;
    root[i] = parent < 0 ? i : root[static_cast<size_t>(parent)];
  }
  for (size_t i = 0; i < json_skin_.size(); ++i) {
    const std::vector<uint32_t>& joints = scene_.skins[i].joints;
    const bool common = std::all_of(joints.begin(), joints.end(),
                                    [&](uint32_t joint) { return root[joint] == root[joints[0]]; });
    if (json_skin_[i] >= 0 && !common) return true;
  }
  return false;
}

// A skin's own node does not place it, so a scale of 0 there hides it from nobody but load().
void NodeWriter::warn_of_visible_skins() const {
  std::vector<bool> hidden = hides_;
  for (size_t i = 0; i < hidden.size(); ++i) {
    const int32_t parent = scene_.nodes[i].parent;
    hidden[i] = hidden[i] || (parent >= 0 && hidden[static_cast<size_t>(parent)]);
  }
  for (const SceneObject& object : scene_.objects) {
    if (object.skin >= 0 && hidden[object.node]) {
      context_.warnings.add(element("node", scene_.nodes[object.node].name),
                            "appears or vanishes, but has a skin: other programs show it always");
    }
  }
}

void NodeWriter::add_environment(JsonOut& scene) const {
  const Environment& own = scene_.environment;
  const Environment plain;
  if (own.zenith == plain.zenith && own.horizon == plain.horizon && own.nadir == plain.nadir &&
      own.ambient == plain.ambient) {
    return;
  }
  JsonOut json = {{"zenith", json_of(own.zenith)},
                  {"horizon", json_of(own.horizon)},
                  {"nadir", json_of(own.nadir)}};
  if (own.ambient) json["ambient"] = json_of(*own.ambient);
  scene["extras"]["sinew_environment"] = std::move(json);
}

void NodeWriter::add_scene(const std::vector<uint32_t>& roots) {
  JsonOut json = named(scene_.name);
  if (!roots.empty()) json["nodes"] = roots;
  if (scene_.default_fps > 0.0) json["extras"]["sinew_fps"] = scene_.default_fps;
  if (scene_.default_frames > 0) json["extras"]["sinew_frames"] = scene_.default_frames;
  add_environment(json);
  context_.asset.add("scenes", std::move(json));
  context_.asset.root()["scene"] = 0;
}

std::vector<NodeOutput> NodeWriter::write() {
  number_nodes();
  std::vector<uint32_t> roots;
  size_t next_object = 0;
  for (size_t i = 0; i < scene_.nodes.size(); ++i) {
    const Node& node = scene_.nodes[i];
    add_chain(i);
    const bool is_object =
        next_object < scene_.objects.size() && scene_.objects[next_object].node == i;
    add_contents(node, is_object ? &scene_.objects[next_object++] : nullptr, nodes_.back());
    if (node.parent < 0) {
      roots.push_back(places_[i].outer);
    } else {
      const NodeOutput& parent = places_[static_cast<size_t>(node.parent)];
      nodes_[parent.main]["children"].push_back(places_[i].outer);
    }
  }
  add_skins();
  if (needs_common_root()) {
    nodes_.push_back({{"name", "common root"}, {"children", roots}});
    roots = {static_cast<uint32_t>(nodes_.size() - 1)};
  }
  for (JsonOut& node : nodes_) context_.asset.add("nodes", std::move(node));
  add_scene(roots);
  if (!context_.embedded) warn_of_visible_skins();
  return places_;
}

}  // namespace

std::vector<NodeOutput> write_nodes(const WriteContext& context, std::span<const MeshOutput> meshes,
                                    std::span<const Clip> clips) {
  return NodeWriter(context, meshes, clips).write();
}

}  // namespace sinew::gltf
