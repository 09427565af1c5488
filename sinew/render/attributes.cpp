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
  for (const Image8& image : scene.images) mix_address(image.pixels.data());
  mix(scene.voxels.size());
  for (const Svo& svo : scene.octrees) {
    mix_address(svo.cells.data());
    mix(svo.cells.size());
  }
  return h;
}

// Lists the triangles around each vertex.
void list_neighbours(const Mesh& mesh, std::vector<uint32_t>& first,
                     std::vector<uint32_t>& triangles) {
  first.assign(mesh.positions.size() + 1, 0);
  triangles.resize(3 * mesh.triangles.size());
  for (const uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++first[t[k] + 1];
  }
  for (size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) triangles[next[mesh.triangles[i][k]]++] = i;
  }
}

// The file's normal in the pose: morph deltas, then the skin.
vec3 deformed_normal(const ObjectAttributes& object, uint32_t i) {
  const Mesh& mesh = *object.mesh;
  const std::span<const float> weights = object.pose->weights;
  vec3 normal = mesh.normals[i];
  if (!mesh.morph_normals.empty() && !weights.empty()) {
    for (size_t t = 0; t < mesh.morph_targets; ++t) {
      if (weights[t] != 0.0f) {
        normal += weights[t] * mesh.morph_normals[t * mesh.normals.size() + i];
      }
    }
  }
  if (!is_skinned(*object.motion)) return unit_or_zero(normal);
  const mat3 map = local_map(*object.motion, *object.pose, i);
  return unit_or_zero(cofactor(Affine(map[0], map[1], map[2], vec3(0.0f))) * normal);
}

// A cross product is twice the triangle's area long, so the sum weighs by area.
vec3 computed_normal(const ObjectAttributes& object, uint32_t vertex) {
  vec3 sum(0.0f);
  for (uint32_t k = object.first[vertex]; k < object.first[vertex + 1]; ++k) {
    const uvec3 t = object.mesh->triangles[object.triangles[k]];
    const vec3 corner = position_at(object, t.x);
    sum += cross(position_at(object, t.y) - corner, position_at(object, t.z) - corner);
  }
  return unit_or_zero(sum);
}

}  // namespace

vec3 position_at(const ObjectAttributes& object, uint32_t vertex) {
  if (!object.positions.empty()) return object.positions[vertex];
  vec3 at;
  positions(*object.motion, *object.pose, vertex, {&at, 1});
  return at;
}

vec3 normal_at(const ObjectAttributes& object, uint32_t i) {
  if (!object.normals.empty()) return object.normals[i];
  return object.source == NormalSource::deformed ? deformed_normal(object, i)
                                                 : computed_normal(object, i);
}

vec4 tangent_at(const ObjectAttributes& object, uint32_t i) {
  if (!object.tangents.empty()) return object.tangents[i];
  const vec4 tangent = object.mesh->tangents[i];
  if (!is_skinned(*object.motion)) return vec4(unit_or_zero(vec3(tangent)), tangent.w);
  return vec4(unit_or_zero(local_map(*object.motion, *object.pose, i) * vec3(tangent)), tangent.w);
}

bool AttributeTable::begin_frame(const World& world, const Scene& scene, const ScenePose& pose,
                                 uint64_t rays) {
  const uint64_t identity = identity_of(scene);
  const bool is_new = identity != scene_identity_;
  if (is_new) {
    bind(scene);
    scene_identity_ = identity;
  }
  world_ = &world;
  scene_ = &scene;
  pose_ = &pose;
  rays_ = rays;
  ++frame_;
  for (size_t i = 0; i < objects_.size(); ++i) touched_[i].store(0, std::memory_order_relaxed);
  return is_new;
}

void AttributeTable::bind(const Scene& scene) {
  meshes_.clear();
  meshes_.resize(scene.meshes.size());
  for (size_t i = 0; i < meshes_.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    meshes_[i].wants_tangents = wants_tangents(scene, mesh);
    if (wants_normals(mesh)) {
      meshes_[i].rest = mesh.normals.empty() ? NormalSource::computed : NormalSource::stored;
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
    if (object.source == NormalSource::none || !deforms(object.motion)) continue;
    // Stored normals can follow a deformation only if each belongs to one vertex.
    const bool follows = object.source == NormalSource::stored && mesh.corners.empty() &&
                         !std::holds_alternative<KeyframeMotion>(object.motion) &&
                         !std::holds_alternative<FreeMotion>(object.motion);
    object.source = follows ? NormalSource::deformed : NormalSource::computed;
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
  out.positions = world_->known_positions(index);
  out.source = object.source;
  out.motion = &object.motion;
  out.pose = &pose_->objects[index];
  object.frame = frame_;
  out.has_tangents = shared.wants_tangents && (object.source == NormalSource::stored ||
                                               object.source == NormalSource::deformed);
  if (object.source == NormalSource::stored) {
    out.normals = mesh.normals;
    if (out.has_tangents) out.tangents = mesh.tangents;
    return;
  }
  if (object.source == NormalSource::computed) {
    if (shared.first.empty()) list_neighbours(mesh, shared.first, shared.triangles);
    out.first = shared.first;
    out.triangles = shared.triangles;
    if (!deforms(object.motion)) out.normals = shared.normals;  // empty the first time
  }
  if (object.source != NormalSource::none && out.normals.empty() &&
      mesh.positions.size() <= rays_) {
    if (object.source == NormalSource::computed && out.positions.empty()) {
      object.positions.resize(mesh.positions.size());
      world_->positions(index, object.positions);
      out.positions = object.positions;
    }
    make_normals(object, shared);
  }
}

void AttributeTable::make_normals(ObjectEntry& object, MeshEntry& shared) {
  ObjectAttributes& out = object.attributes;
  const size_t count =
      out.normals_by_vertex() ? out.mesh->positions.size() : out.mesh->normals.size();
  std::vector<vec3>& normals = deforms(object.motion) ? object.normals : shared.normals;
  normals.resize(count);
  object.tangents.resize(out.has_tangents ? out.mesh->tangents.size() : 0);
  parallel_for(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) normals[i] = normal_at(out, static_cast<uint32_t>(i));
    for (size_t i = begin; i < end && out.has_tangents; ++i) {
      object.tangents[i] = tangent_at(out, static_cast<uint32_t>(i));
    }
  });
  out.normals = normals;
  out.tangents = object.tangents;
}

}  // namespace sinew
