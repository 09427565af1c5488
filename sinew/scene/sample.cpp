// The scene at one time: rest values, then channels, then world transforms from parents to
// children, then what each object's motion needs.
// Based on: glTF 2.0 specification, sections 3.5 (nodes), 3.7.3 (skins), 3.11 (animations).
#include "sinew/scene/sample.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew {
namespace {

// Sizes the arrays and hands every object its part of them.
void lay_out(const Scene& scene, ScenePose& out) {
  size_t joints = 0, weights = 0, vertices = 0;
  for (const Skin& skin : scene.skins) joints += skin.joints.size();
  for (const SceneObject& object : scene.objects) {
    const Mesh& mesh = scene.meshes[object.mesh];
    weights += mesh.morph_targets;
    if (mesh.vertex_program) vertices += mesh.positions.size();
  }
  for (const SceneVoxels& object : scene.voxels) {
    weights += scene.octrees[object.octree].morph_targets;
  }
  out.nodes.resize(scene.nodes.size());
  out.visible.resize(scene.nodes.size());
  out.local.resize(scene.nodes.size());
  out.objects.resize(scene.objects.size());
  out.voxels.resize(scene.voxels.size());
  out.joints.resize(joints);
  out.skin_begin.resize(scene.skins.size());
  out.weights.resize(weights);
  out.free.resize(vertices);
}

// Takes the next weights of `out` for the pose, at rest.
void set_rest_weights(const Node& node, std::span<const float> defaults, size_t& begin,
                      ScenePose& out, Pose& pose) {
  const std::span<float> weights(out.weights.data() + begin, defaults.size());
  std::ranges::copy(node.weights.empty() ? defaults : std::span<const float>(node.weights),
                    weights.begin());
  pose = {};
  pose.weights = weights;
  begin += weights.size();
}

void set_rest(const Scene& scene, ScenePose& out) {
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    out.local[i] = {node.translation, glm::normalize(node.rotation), node.scale, node.has_matrix,
                    node.visible};
  }
  size_t weight_begin = 0, vertex_begin = 0;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const Mesh& mesh = scene.meshes[object.mesh];
    Pose& pose = out.objects[i];
    set_rest_weights(scene.nodes[object.node], mesh.morph_weights, weight_begin, out, pose);
    if (!mesh.vertex_program) continue;
    pose.positions = {out.free.data() + vertex_begin, mesh.positions.size()};
    vertex_begin += mesh.positions.size();
  }
  for (size_t i = 0; i < scene.voxels.size(); ++i) {
    const SceneVoxels& object = scene.voxels[i];
    set_rest_weights(scene.nodes[object.node], scene.octrees[object.octree].morph_weights,
                     weight_begin, out, out.voxels[i]);
  }
}

// Index of the object (of Scene::objects or ::voxels) that the node shows; both are in node order.
template <class Object>
size_t object_of(const std::vector<Object>& objects, uint32_t node) {
  const auto found = std::ranges::lower_bound(objects, node, {}, &Object::node);
  SINEW_CHECK(found != objects.end() && found->node == node);
  return static_cast<size_t>(found - objects.begin());
}

void set_cache_key(const Mesh& mesh, float position, Pose& pose) {
  if (mesh.keys == 0) return;
  const float last = static_cast<float>(mesh.keys - 1);
  const float clamped = position > 0.0f ? std::min(position, last) : 0.0f;
  pose.key = std::min(static_cast<uint32_t>(clamped), mesh.keys - 1);
  pose.key_fraction = clamped - static_cast<float>(pose.key);
}

void apply_channel(const Scene& scene, const Channel& channel, double time, ScenePose& out) {
  if (channel.path == ChannelPath::weights) {
    const Pose& pose = scene.nodes[channel.node].octree >= 0
                           ? out.voxels[object_of(scene.voxels, channel.node)]
                           : out.objects[object_of(scene.objects, channel.node)];
    const std::span<const float> weights = pose.weights;
    const size_t begin = static_cast<size_t>(weights.data() - out.weights.data());
    sample_channel(channel, time, std::span(out.weights).subspan(begin, weights.size()));
    return;
  }
  std::array<float, 4> value{};
  sample_channel(channel, time, std::span(value).first(channel.width));
  LocalTransform& local = out.local[channel.node];
  switch (channel.path) {
    case ChannelPath::translation:
      local.translation = vec3(value[0], value[1], value[2]);
      local.has_matrix = false;
      break;
    case ChannelPath::rotation:
      local.rotation = quat(value[3], value[0], value[1], value[2]);
      local.has_matrix = false;
      break;
    case ChannelPath::scale:
      local.scale = vec3(value[0], value[1], value[2]);
      local.has_matrix = false;
      break;
    case ChannelPath::cache_key: {
      const size_t object = object_of(scene.objects, channel.node);
      set_cache_key(scene.meshes[scene.objects[object].mesh], value[0], out.objects[object]);
      break;
    }
    case ChannelPath::visibility:
      local.visible = value[0] > 0.5f;
      break;
    case ChannelPath::weights:
      break;
  }
}

void compose_nodes(const Scene& scene, ScenePose& out) {
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    const LocalTransform& local = out.local[i];
    const Affine to_parent =
        local.has_matrix ? node.matrix : trs(local.translation, local.rotation, local.scale);
    const bool root = node.parent < 0;
    out.nodes[i] = root ? to_parent : compose(out.nodes[node.parent], to_parent);
    out.visible[i] = local.visible && (root || out.visible[node.parent]);
  }
}

// Joint matrices of all skins, one after another.
void compose_joints(const Scene& scene, ScenePose& out) {
  size_t next = 0;
  for (size_t i = 0; i < scene.skins.size(); ++i) {
    const Skin& skin = scene.skins[i];
    out.skin_begin[i] = next;
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      out.joints[next++] = compose(out.nodes[skin.joints[j]], skin.inverse_bind[j]);
    }
  }
}

bool is_finite(const Affine& m) {
  return std::isfinite(m[0].x + m[0].y + m[0].z + m[1].x + m[1].y + m[1].z + m[2].x + m[2].y +
                       m[2].z + m[3].x + m[3].y + m[3].z);
}

// Whether rays and motions can work with the pose.
bool is_sound(const Pose& pose) {
  return !is_singular(pose.placement) && std::ranges::all_of(pose.joints, is_finite) &&
         std::ranges::all_of(pose.weights, [](float w) { return std::isfinite(w); });
}

template <class Object>
void place(const Scene& scene, const std::vector<Object>& objects, std::vector<Pose>& poses,
           ScenePose& out) {
  for (size_t i = 0; i < objects.size(); ++i) {
    const Object& object = objects[i];
    Pose& pose = poses[i];
    if (object.skin < 0) {
      pose.placement = out.nodes[object.node];
    } else {
      pose.joints = {out.joints.data() + out.skin_begin[object.skin],
                     scene.skins[object.skin].joints.size()};
    }
    pose.present = out.visible[object.node] != 0;
    if (pose.present && !is_sound(pose)) {
      pose.present = false;
      ++out.absent;
    }
  }
}

void place_objects(const Scene& scene, ScenePose& out) {
  out.absent = 0;
  place(scene, scene.objects, out.objects, out);
  place(scene, scene.voxels, out.voxels, out);
}

void run_vertex_programs(const Scene& scene, double time, ScenePose& out) {
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.objects[i].mesh];
    const std::span<const vec3> positions = out.objects[i].positions;
    if (!mesh.vertex_program || !out.objects[i].present) continue;
    const size_t begin = static_cast<size_t>(positions.data() - out.free.data());
    mesh.vertex_program(time, std::span(out.free).subspan(begin, positions.size()));
  }
}

}  // namespace

void sample(const Scene& scene, int clip, double time, ScenePose& out) {
  SINEW_CHECK(clip == kRestPose || (clip >= 0 && size_t(clip) < scene.clips.size()));
  lay_out(scene, out);
  set_rest(scene, out);
  if (clip != kRestPose) {
    for (const Channel& channel : scene.clips[clip].channels) {
      apply_channel(scene, channel, time, out);
    }
  }
  compose_nodes(scene, out);
  compose_joints(scene, out);
  place_objects(scene, out);
  run_vertex_programs(scene, time, out);
  out.time = time;
}

}  // namespace sinew
