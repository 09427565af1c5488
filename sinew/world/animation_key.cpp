#include "sinew/world/animation_key.h"

#include <array>
#include <memory>
#include <span>
#include <type_traits>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace sinew {
namespace {

class Hash {
 public:
  Hash() { XXH3_64bits_reset(&state_); }

  template <class T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    XXH3_64bits_update(&state_, &value, sizeof(T));
  }
  // Of vectors and matrices of floats too: none of those has padding.
  template <class T>
  void add_all(const std::vector<T>& values) {
    add(values.size());
    if (!values.empty()) XXH3_64bits_update(&state_, values.data(), values.size() * sizeof(T));
  }
  void add_floats(std::span<const float> values) {
    XXH3_64bits_update(&state_, values.data(), values.size_bytes());
  }
  uint64_t value() const { return XXH3_64bits_digest(&state_); }

 private:
  XXH3_state_t state_;
};

// Times of the first clip at which vertex programs are asked.
std::array<double, 3> times_of(const Scene& scene) {
  if (scene.clips.empty()) return {0.0, 0.5, 1.0};
  const Clip& clip = scene.clips.front();
  return {clip.start, 0.37 * clip.start + 0.63 * clip.end, clip.end};
}

void add(const Scene& scene, const Mesh& mesh, Hash& hash) {
  hash.add_all(mesh.positions);
  hash.add_all(mesh.triangles);
  hash.add(mesh.influences);
  hash.add_all(mesh.joints);
  hash.add_all(mesh.weights);
  hash.add(mesh.morph_targets);
  hash.add_all(mesh.morph_positions);
  hash.add_all(mesh.morph_weights);
  hash.add(mesh.keys);
  hash.add_all(mesh.key_positions);
  if (!mesh.vertex_program) return;
  std::vector<vec3> at(mesh.positions.size());
  for (const double time : times_of(scene)) {
    mesh.vertex_program(time, at);
    hash.add_all(at);
  }
}

void add(const Node& node, Hash& hash) {
  hash.add(node.parent);
  for (const vec3& v : {node.translation, node.scale}) hash.add_floats({&v.x, 3});
  const float rotation[] = {node.rotation.x, node.rotation.y, node.rotation.z, node.rotation.w};
  hash.add_floats(rotation);
  hash.add(node.has_matrix);
  if (node.has_matrix) hash.add_floats({&node.matrix[0][0], 12});
  hash.add(node.mesh);
  hash.add(node.skin);
  hash.add_all(node.weights);
}

void add(const Clip& clip, Hash& hash) {
  hash.add(clip.start);
  hash.add(clip.end);
  hash.add(clip.channels.size());
  for (const Channel& channel : clip.channels) {
    hash.add(channel.node);
    hash.add(channel.path);
    hash.add(channel.interpolation);
    hash.add_all(channel.times);
    hash.add_all(channel.values);
  }
}

}  // namespace

uint64_t animation_key(const Scene& scene) {
  const auto hash = std::make_unique<Hash>();  // its state is large for a stack, and aligned
  // With every list goes its length, so that no two scenes give the same bytes.
  for (const size_t count : {scene.meshes.size(), scene.nodes.size(), scene.skins.size(),
                             scene.clips.size(), scene.objects.size()}) {
    hash->add(count);
  }
  for (const Mesh& mesh : scene.meshes) add(scene, mesh, *hash);
  for (const Node& node : scene.nodes) add(node, *hash);
  for (const Skin& skin : scene.skins) {
    hash->add_all(skin.joints);
    hash->add_all(skin.inverse_bind);
  }
  for (const Clip& clip : scene.clips) add(clip, *hash);
  for (const SceneObject& object : scene.objects) {
    hash->add(object.node);
    hash->add(object.mesh);
    hash->add(object.skin);
  }
  return hash->value();
}

}  // namespace sinew
