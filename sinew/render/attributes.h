// Vertex normals and tangents of this frame's objects, made only for objects that rays have met.
// Stored normals follow their motion (morph deltas, then the cofactor of the vertex's local map);
// vertex caches, free motions and meshes without normals get area-weighted means of their
// triangles' normals, from the current positions.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"
#include "sinew/world/world.h"

namespace sinew {

// One object in this frame, in its own space (before placement). Views only.
struct ObjectAttributes {
  const Mesh* mesh = nullptr;
  Affine placement = identity_affine();
  bool mirrored = false;            // the placement turns triangles inside out
  mat3 normal_map{1.0f};            // object -> world for normals, up to length
  std::span<const vec3> positions;  // one a vertex
  std::span<const vec3> normals;    // unit or zero; empty: shade with the triangles' normals
  std::span<const vec4> tangents;   // as Mesh::tangents; empty: made from texture coordinates
  bool normals_by_vertex = false;   // indexed by Mesh::triangles rather than corner_of()
};

class AttributeTable {
 public:
  // Starts a frame; tables that depend on the scene alone are kept if it is still the same one.
  void begin_frame(const World& world, const Scene& scene, const ScenePose& pose);

  // Says that a ray met the object. Safe to call from several threads.
  void touch(uint32_t object) {
    if (touched_[object].load(std::memory_order_relaxed) == 0) {
      touched_[object].store(1, std::memory_order_relaxed);
    }
  }
  // Makes the attributes of all objects touched since begin_frame. Must not overlap other calls.
  void refresh();

  // Valid after the refresh that followed the object's touch.
  const ObjectAttributes& of(uint32_t object) const { return objects_[object].attributes; }

 private:
  enum class Source : uint8_t { none, stored, deformed, computed };
  struct MeshEntry {
    Source rest = Source::none;  // where normals come from if the mesh is rigid
    bool wants_tangents = false;
    bool has_adjacency = false;
    std::vector<uint32_t> first;      // adjacency: triangles of vertex v are
    std::vector<uint32_t> triangles;  // triangles[first[v] .. first[v + 1])
    std::vector<vec3> normals;        // computed, of the rigid mesh
  };
  struct ObjectEntry {
    ObjectAttributes attributes;
    Motion motion;
    Source source = Source::none;
    uint64_t frame = 0;  // in which attributes were made
    std::vector<vec3> normals;
    std::vector<vec4> tangents;
  };

  void bind(const Scene& scene);
  void refresh_object(uint32_t index);
  void compute_normals(MeshEntry& entry, const Mesh& mesh, std::span<const vec3> positions,
                       std::vector<vec3>& out);

  const World* world_ = nullptr;
  const Scene* scene_ = nullptr;
  const ScenePose* pose_ = nullptr;
  uint64_t scene_identity_ = 0;
  uint64_t frame_ = 0;
  std::vector<MeshEntry> meshes_;
  std::vector<ObjectEntry> objects_;
  std::vector<vec3> face_normals_;  // scratch of compute_normals
  std::unique_ptr<std::atomic<uint8_t>[]> touched_;
};

}  // namespace sinew
