#include "sinew/render/attributes.h"

#include <algorithm>
#include <variant>

#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kGrain = 2048;

vec3 unit_or_zero(vec3 v) {
  const float l2 = dot(v, v);
  return l2 > 0.0f ? v / std::sqrt(l2) : vec3(0.0f);
}

bool is_skinned(const Motion& motion) {
  if (const auto* morph = std::get_if<MorphMotion>(&motion)) return morph->skin.influences > 0;
  return std::holds_alternative<SkinMotion>(motion);
}

bool wants_normals(const Mesh& mesh) {
  return std::any_of(mesh.parts.begin(), mesh.parts.end(),
                     [](const MeshPart& part) { return !part.flat; });
}

bool wants_tangents(const Scene& scene, const Mesh& mesh) {
  return !mesh.tangents.empty() &&
         std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
           return scene.materials[part.material].normal_texture.image >= 0;
         });
}

// Tells scenes apart by where their data lie and how large they are.
uint64_t identity_of(const Scene& scene) {
  uint64_t h = 0xcbf29ce484222325u;
  const auto mix = [&](uint64_t x) { h = (h ^ x) * 0x100000001b3u; };
  const auto mix_address = [&](const void* p) { mix(reinterpret_cast<uintptr_t>(p)); };
  mix_address(&scene);
  mix(scene.objects.size());
  mix(scene.materials.size());
  mix(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) {
    mix_address(mesh.triangles.data());
    mix_address(mesh.positions.data());
    mix(mesh.triangles.size());
    mix(mesh.normals.size());
  }
  return h;
}

// Stored normals and tangents in the pose: morph deltas, then the skin. `tangents` may be empty.
void deform_attributes(const Mesh& mesh, const Motion& motion, const Pose& pose,
                       std::span<vec3> normals, std::span<vec4> tangents) {
  const bool skinned = is_skinned(motion);
  const bool morphed = !mesh.morph_normals.empty() && !pose.weights.empty();
  const size_t count = mesh.normals.size();
  parallel_for(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      vec3 normal = mesh.normals[i];
      if (morphed) {
        for (size_t t = 0; t < mesh.morph_targets; ++t) {
          if (pose.weights[t] != 0.0f) {
            normal += pose.weights[t] * mesh.morph_normals[t * count + i];
          }
        }
      }
      const mat3 map = skinned ? local_map(motion, pose, static_cast<uint32_t>(i)) : mat3(1.0f);
      const Affine affine(map[0], map[1], map[2], vec3(0.0f));
      normals[i] = unit_or_zero(skinned ? cofactor(affine) * normal : normal);
      if (!tangents.empty()) {
        tangents[i] = vec4(unit_or_zero(map * vec3(mesh.tangents[i])), mesh.tangents[i].w);
      }
    }
  });
}

}  // namespace

void AttributeTable::begin_frame(const World& world, const Scene& scene, const ScenePose& pose) {
  const uint64_t identity = identity_of(scene);
  if (identity != scene_identity_) {
    bind(scene);
    scene_identity_ = identity;
  }
  world_ = &world;
  scene_ = &scene;
  pose_ = &pose;
  ++frame_;
  for (size_t i = 0; i < objects_.size(); ++i) touched_[i].store(0, std::memory_order_relaxed);
}

void AttributeTable::bind(const Scene& scene) {
  meshes_.clear();
  meshes_.resize(scene.meshes.size());
  for (size_t i = 0; i < meshes_.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    meshes_[i].wants_tangents = wants_tangents(scene, mesh);
    if (wants_normals(mesh)) {
      meshes_[i].rest = mesh.normals.empty() ? Source::computed : Source::stored;
    }
  }
  objects_.clear();
  objects_.resize(scene.objects.size());
  touched_ = std::make_unique<std::atomic<uint8_t>[]>(objects_.size());
  for (size_t i = 0; i < objects_.size(); ++i) {
    ObjectEntry& object = objects_[i];
    const Mesh& mesh = scene.meshes[scene.objects[i].mesh];
    object.motion = motion_of(mesh, scene.objects[i].skin >= 0);
    object.source = meshes_[scene.objects[i].mesh].rest;
    if (object.source == Source::none || !deforms(object.motion)) continue;
    // Stored normals can follow a deformation only if each belongs to one vertex.
    const bool follows = object.source == Source::stored && mesh.corners.empty() &&
                         !std::holds_alternative<KeyframeMotion>(object.motion) &&
                         !std::holds_alternative<FreeMotion>(object.motion);
    object.source = follows ? Source::deformed : Source::computed;
  }
}

void AttributeTable::refresh() {
  for (uint32_t i = 0; i < objects_.size(); ++i) {
    if (touched_[i].load(std::memory_order_relaxed) != 0 && objects_[i].frame != frame_) {
      refresh_object(i);
    }
  }
}

void AttributeTable::refresh_object(uint32_t index) {
  ObjectEntry& object = objects_[index];
  const uint32_t mesh_index = scene_->objects[index].mesh;
  const Mesh& mesh = scene_->meshes[mesh_index];
  MeshEntry& shared = meshes_[mesh_index];
  ObjectAttributes& out = object.attributes;
  out = {};
  out.mesh = &mesh;
  out.placement = world_->placement(index);
  out.mirrored = world_->mirrored(index);
  out.normal_map = cofactor(out.placement);
  out.positions = world_->positions(index);
  object.frame = frame_;
  switch (object.source) {
    case Source::none:
      break;
    case Source::stored:
      out.normals = mesh.normals;
      if (shared.wants_tangents) out.tangents = mesh.tangents;
      break;
    case Source::deformed:
      object.normals.resize(mesh.normals.size());
      object.tangents.resize(shared.wants_tangents ? mesh.tangents.size() : 0);
      deform_attributes(mesh, object.motion, pose_->objects[index], object.normals,
                        object.tangents);
      out.normals = object.normals;
      out.tangents = object.tangents;
      break;
    case Source::computed: {
      const bool rigid = !deforms(object.motion);
      std::vector<vec3>& normals = rigid ? shared.normals : object.normals;
      if (!rigid || normals.empty()) compute_normals(shared, mesh, out.positions, normals);
      out.normals = normals;
      out.normals_by_vertex = true;
      break;
    }
  }
}

void AttributeTable::compute_normals(MeshEntry& entry, const Mesh& mesh,
                                     std::span<const vec3> positions, std::vector<vec3>& out) {
  if (!entry.has_adjacency) {
    entry.first.assign(positions.size() + 1, 0);
    entry.triangles.resize(3 * mesh.triangles.size());
    for (const uvec3& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) ++entry.first[t[k] + 1];
    }
    for (size_t v = 1; v < entry.first.size(); ++v) entry.first[v] += entry.first[v - 1];
    std::vector<uint32_t> next(entry.first.begin(), entry.first.end() - 1);
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) entry.triangles[next[mesh.triangles[i][k]]++] = i;
    }
    entry.has_adjacency = true;
  }
  // A cross product is twice the triangle's area long, so the sum weighs by area.
  face_normals_.resize(mesh.triangles.size());
  parallel_for(mesh.triangles.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uvec3 t = mesh.triangles[i];
      face_normals_[i] = cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
    }
  });
  out.resize(positions.size());
  parallel_for(positions.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      vec3 sum(0.0f);
      for (uint32_t k = entry.first[v]; k < entry.first[v + 1]; ++k) {
        sum += face_normals_[entry.triangles[k]];
      }
      out[v] = unit_or_zero(sum);
    }
  });
}

}  // namespace sinew
