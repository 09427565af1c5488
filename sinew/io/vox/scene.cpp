// A .vox file as a scene: one octree a model, nodes for its scene graph, materials for what its
// colours are made of, and a clip if it has frames.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>

#include "sinew/base/mapped_file.h"
#include "sinew/io/vox/normals.h"
#include "sinew/io/vox/parse.h"
#include "sinew/io/vox/vox.h"
#include "sinew/math/srgb.h"

namespace sinew {
namespace vox {
namespace {

// (x, y, z) of the file becomes (x, z, -y).
const mat3 kToYUp(vec3(1, 0, 0), vec3(0, 0, -1), vec3(0, 1, 0));

vec3 linear_color(const std::array<uint8_t, 4>& srgb) {
  vec3 color;
  for (int k = 0; k < 3; ++k) {
    color[k] = srgb_to_linear(static_cast<float>(srgb[static_cast<size_t>(k)]) / 255.0f);
  }
  return color;
}

class SceneMaker {
 public:
  SceneMaker(VoxFile file, std::string path, const LoadOptions& options)
      : file_(std::move(file)), path_(std::move(path)), left_(options.memory_limit) {}

  Result<Scene> make();

 private:
  void make_materials();
  Result<void> make_octrees();
  Result<Svo> make_octree(const Model& model);
  Result<void> make_nodes();
  void add_shape(const VoxNode& shape, uint32_t node);
  uint32_t add_transform(const VoxNode* transform, int32_t parent);
  void add_frames_without_graph();
  void animate(const std::vector<TransformKey>& keys, uint32_t node);
  void add_key_channel(uint32_t node, const std::vector<std::pair<int32_t, bool>>& keys);
  Channel& add_channel(uint32_t node, ChannelPath path, uint32_t width);
  Result<void> take(uint64_t bytes);

  VoxFile file_;
  std::string path_;
  uint64_t left_;  // bytes of memory
  Scene scene_;
  Clip clip_;
  int32_t last_frame_ = 0;
  std::array<uint16_t, 256> material_{};  // of each colour
  std::array<uint16_t, 256> color_{};     // packed
  std::vector<int32_t> octree_of_model_;  // -1: it has no voxels
};

Result<void> SceneMaker::take(uint64_t bytes) {
  if (bytes > left_) {
    return fail({ErrorKind::bad_input, path_, "", "needs more memory than is allowed",
                 "raise the memory limit or use a smaller file"});
  }
  left_ -= bytes;
  return {};
}

void SceneMaker::make_materials() {
  std::array<bool, 256> used{};
  for (const Model& model : file_.models) {
    for (const Voxel& v : model.voxels) used[v.color] = true;
  }
  Material plain;
  plain.name = "voxels";
  plain.roughness = 1.0f;
  scene_.materials.push_back(plain);
  std::vector<VoxMaterial> made = {VoxMaterial{}};
  bool glass = false;
  for (size_t color = 1; color <= kVoxColors; ++color) {
    color_[color] = pack_color(linear_color(file_.palette[color]));
    const auto found = file_.materials.find(static_cast<int32_t>(color));
    if (!used[color] || found == file_.materials.end()) continue;
    VoxMaterial wanted = found->second;
    glass |= wanted.glass;
    wanted.glass = false;
    // Light has the colour's colour, so that each colour which shines is a material of its own.
    const auto same = wanted.emission > 0.0f ? made.end() : std::ranges::find(made, wanted);
    material_[color] = static_cast<uint16_t>(same - made.begin());
    if (same != made.end()) continue;
    Material material = plain;
    material.name = fmt::format("voxels of colour {}", color);
    material.metallic = wanted.metal;
    material.roughness = wanted.roughness;
    material.emissive = wanted.emission * linear_color(file_.palette[color]);
    scene_.materials.push_back(material);
    made.push_back(wanted);
  }
  if (glass) scene_.warnings.push_back("voxels of glass are opaque here");
}

Result<Svo> SceneMaker::make_octree(const Model& model) {
  const uvec3 size = model.size;
  VoxelGrid grid;
  grid.voxel = kVoxSide;
  grid.resolution = uvec3(size.x, size.z, size.y);
  // The middle of the model, rounded down, is the node's origin.
  const uvec3 middle = size / 2u;
  grid.origin = -kVoxSide * vec3(uvec3(middle.x, middle.z, size.y - middle.y));
  std::vector<PlainVoxel> voxels;
  voxels.reserve(model.voxels.size());
  for (const Voxel& v : model.voxels) {
    if (v.color == 0) continue;
    voxels.push_back(
        {morton_of(uvec3(v.x, v.z, size.y - 1 - v.y)), 0, color_[v.color], material_[v.color]});
  }
  // Of several voxels at one place the last counts.
  std::ranges::stable_sort(voxels, {}, &PlainVoxel::voxel);
  const auto last = std::unique(voxels.rbegin(), voxels.rend(),
                                [](const auto& a, const auto& b) { return a.voxel == b.voxel; });
  voxels.erase(voxels.begin(), last.base());
  set_normals(grid.resolution, voxels);
  return make_svo(grid, voxels);
}

Result<void> SceneMaker::make_octrees() {
  constexpr uint64_t kBytesPerVoxel = 64;  // of the octree and on its way
  for (size_t i = 0; i < file_.models.size(); ++i) {
    const Model& model = file_.models[i];
    octree_of_model_.push_back(-1);
    const bool empty =
        std::ranges::all_of(model.voxels, [](const Voxel& v) { return v.color == 0; });
    if (empty) continue;
    SINEW_CHECKED(take(kBytesPerVoxel * model.voxels.size() + sizeof(Svo)));
    Result<Svo> octree = make_octree(model);
    if (!octree) {
      Error error = octree.error();
      error.file = path_;
      error.element = fmt::format("model {}", i);
      return fail(std::move(error));
    }
    octree->name = fmt::format("model {}", i);
    octree_of_model_.back() = static_cast<int32_t>(scene_.octrees.size());
    scene_.octrees.push_back(std::move(*octree));
  }
  return {};
}

Channel& SceneMaker::add_channel(uint32_t node, ChannelPath path, uint32_t width) {
  Channel channel;
  channel.node = node;
  channel.path = path;
  channel.interpolation = Interpolation::step;
  channel.width = width;
  return clip_.channels.emplace_back(std::move(channel));
}

float seconds(int32_t frame) {
  return static_cast<float>(frame / kVoxFps);
}

// How a key places its node: a rotation, and whether it mirrors besides.
struct Placed {
  vec3 translation;
  mat3 rotation;
  bool mirrored;
};
Placed placed(const TransformKey& key) {
  const mat3 rotation = kToYUp * key.rotation.matrix() * transpose(kToYUp);
  return {kVoxSide * (kToYUp * vec3(key.translation)), rotation, determinant(rotation) < 0.0f};
}

void SceneMaker::animate(const std::vector<TransformKey>& keys, uint32_t node) {
  last_frame_ = std::max(last_frame_, keys.back().frame);
  const auto mirrored = [](const TransformKey& key) { return placed(key).mirrored; };
  if (std::ranges::any_of(keys, mirrored)) {
    scene_.warnings.push_back(fmt::format("node '{}': is mirrored and moves; left where it begins",
                                          scene_.nodes[node].name));
    return;
  }
  const bool turns = std::ranges::any_of(
      keys, [&](const TransformKey& key) { return key.rotation != keys[0].rotation; });
  Channel& moves = add_channel(node, ChannelPath::translation, 3);
  for (const TransformKey& key : keys) {
    const vec3 t = placed(key).translation;
    moves.times.push_back(seconds(key.frame));
    moves.values.insert(moves.values.end(), {t.x, t.y, t.z});
  }
  if (!turns) return;
  Channel& rotates = add_channel(node, ChannelPath::rotation, 4);
  for (const TransformKey& key : keys) {
    const quat q = glm::quat_cast(placed(key).rotation);
    rotates.times.push_back(seconds(key.frame));
    rotates.values.insert(rotates.values.end(), {q.x, q.y, q.z, q.w});
  }
}

uint32_t SceneMaker::add_transform(const VoxNode* transform, int32_t parent) {
  const auto index = static_cast<uint32_t>(scene_.nodes.size());
  Node node;
  node.parent = parent;
  if (transform != nullptr) {
    node.name = transform->name;
    const auto layer = file_.layer_hidden.find(transform->layer);
    node.visible = !transform->hidden && (layer == file_.layer_hidden.end() || !layer->second);
    const Placed place = placed(transform->places.front());
    node.translation = place.translation;
    if (place.mirrored) {
      node.has_matrix = true;
      node.matrix =
          Affine(place.rotation[0], place.rotation[1], place.rotation[2], place.translation);
    } else {
      node.rotation = glm::quat_cast(place.rotation);
    }
  }
  scene_.nodes.push_back(std::move(node));
  if (transform != nullptr && transform->places.size() > 1) animate(transform->places, index);
  return index;
}

// Shown (true) or hidden from a frame on.
void SceneMaker::add_key_channel(uint32_t node, const std::vector<std::pair<int32_t, bool>>& keys) {
  Channel& channel = add_channel(node, ChannelPath::visibility, 1);
  for (const auto& [frame, shown] : keys) {
    channel.times.push_back(seconds(frame));
    channel.values.push_back(shown ? 1.0f : 0.0f);
    last_frame_ = std::max(last_frame_, frame);
  }
}

// Shows the shape's models at the node; if there are several, each at a node below it in turn.
void SceneMaker::add_shape(const VoxNode& shape, uint32_t node) {
  if (shape.models.size() == 1) {
    scene_.nodes[node].octree = octree_of_model_[shape.models[0].model];
    return;
  }
  for (size_t i = 0; i < shape.models.size(); ++i) {
    const ModelKey& key = shape.models[i];
    last_frame_ = std::max(last_frame_, key.frame);
    const int32_t octree = octree_of_model_[key.model];
    if (octree < 0) continue;
    Node frame;
    frame.name = fmt::format("frame {}", key.frame);
    frame.parent = static_cast<int32_t>(node);
    frame.octree = octree;
    frame.visible = i == 0;
    const auto index = static_cast<uint32_t>(scene_.nodes.size());
    scene_.nodes.push_back(std::move(frame));
    std::vector<std::pair<int32_t, bool>> keys;
    // The first is there from the beginning.
    if (i > 0 && key.frame > 0) keys.push_back({0, false});
    keys.push_back({i == 0 ? 0 : key.frame, true});
    if (i + 1 < shape.models.size()) keys.push_back({shape.models[i + 1].frame, false});
    // A first model whose time ends where it begins.
    if (keys.size() > 1 && keys[keys.size() - 1].first == keys[keys.size() - 2].first) {
      keys.erase(keys.end() - 2);
    }
    add_key_channel(index, keys);
  }
}

// Files of before there were scenes: one model, or one a frame, standing on the ground.
void SceneMaker::add_frames_without_graph() {
  VoxNode shape;
  shape.kind = NodeKind::shape;
  uint32_t height = 0;
  for (uint32_t i = 0; i < file_.models.size(); ++i) {
    shape.models.push_back({static_cast<int32_t>(i), i});
    height = std::max(height, file_.models[i].size.z);
  }
  const uint32_t node = add_transform(nullptr, -1);
  scene_.nodes[node].translation.y = kVoxSide * static_cast<float>(height / 2);
  if (!shape.models.empty()) add_shape(shape, node);
}

Result<void> SceneMaker::make_nodes() {
  if (file_.nodes.empty()) {
    add_frames_without_graph();
    return {};
  }
  struct Pending {
    int32_t id;
    int32_t parent;
  };
  std::vector<Pending> stack = {{file_.nodes.begin()->first, -1}};
  std::set<int32_t> seen;
  while (!stack.empty()) {
    const auto [id, parent] = stack.back();
    stack.pop_back();
    const auto found = file_.nodes.find(id);
    if (found == file_.nodes.end()) {
      return fail({ErrorKind::bad_input, path_, "", fmt::format("there is no node {}", id),
                   "export it again"});
    }
    if (!seen.insert(id).second) {
      return fail({ErrorKind::bad_input, path_, fmt::format("node {}", id),
                   "has two parents, or is its own ancestor", "export it again"});
    }
    const VoxNode& node = found->second;
    int32_t here = parent;
    if (node.kind == NodeKind::transform) {
      here = static_cast<int32_t>(add_transform(&node, parent));
    } else if (node.kind == NodeKind::shape) {
      // A shape stands below a transform, which becomes its node; else it gets one.
      const bool own = parent < 0 || scene_.nodes[static_cast<size_t>(parent)].octree >= 0;
      add_shape(node, own ? add_transform(nullptr, parent) : static_cast<uint32_t>(parent));
    }
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
      stack.push_back({*child, here});
    }
  }
  return {};
}

Result<Scene> SceneMaker::make() {
  make_materials();
  SINEW_CHECKED(make_octrees());
  SINEW_CHECKED(take(file_.nodes.size() * (sizeof(Node) + sizeof(Channel))));
  SINEW_CHECKED(make_nodes());
  if (!clip_.channels.empty()) {
    clip_.name = "frames";
    clip_.end = (last_frame_ + 1) / kVoxFps;
    scene_.default_fps = kVoxFps;
    scene_.clips.push_back(std::move(clip_));
  }
  list_objects(scene_);
  return std::move(scene_);
}

}  // namespace
}  // namespace vox

Result<Scene> parse_vox(std::span<const uint8_t> bytes, const std::string& path,
                        const LoadOptions& options) {
  SINEW_TRY(vox::VoxFile file, vox::parse_file(bytes, path));
  SINEW_TRY(Scene scene, vox::SceneMaker(std::move(file), path, options).make());
  if (options.strict && !scene.warnings.empty()) {
    return fail({ErrorKind::bad_input, path, "", scene.warnings.front(),
                 "load without --strict to ignore this"});
  }
  return scene;
}

Result<Scene> load_vox(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(const MappedFile file, MappedFile::open(path, options.memory_limit));
  return parse_vox(file.bytes(), path, options);
}

}  // namespace sinew
