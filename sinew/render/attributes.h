// Vertex normals and tangents of this frame's objects, made only for objects that rays have met: of
// all vertices at once, or, in a frame with fewer rays than the object has vertices, where a ray
// asks for them. Both give the same bits. Stored normals follow their motion (morph deltas, then
// the cofactor of the vertex's local map); vertex caches, free motions and meshes without normals
// get area-weighted means of their triangles' normals, from the current positions.
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

// Where vertex normals come from: nowhere (shade with the triangles' normals), the file, the file's
// moved like the vertices, or the triangles around each vertex.
enum class NormalSource : uint8_t { none, stored, deformed, computed };

// One object in this frame, in its own space (before placement). Views only.
struct ObjectAttributes {
  const Mesh* mesh = nullptr;
  Affine placement = identity_affine();
  bool mirrored = false;            // the placement turns triangles inside out
  mat3 normal_map{1.0f};            // object -> world for normals, up to length
  std::span<const vec3> positions;  // one a vertex, if they are all known; else see position_at()
  NormalSource source = NormalSource::none;
  bool has_tangents = false;  // else made from texture coordinates

  // What is made for all vertices already; else see normal_at() and tangent_at().
  std::span<const vec3> normals;
  std::span<const vec4> tangents;

  // From which they are made.
  const Motion* motion = nullptr;
  const Pose* pose = nullptr;
  std::span<const uint32_t> first;      // the triangles around vertex v are
  std::span<const uint32_t> triangles;  // triangles[first[v] .. first[v + 1])

  // Whether normals are indexed by Mesh::triangles rather than corner_of().
  bool normals_by_vertex() const { return source == NormalSource::computed; }
};

vec3 position_at(const ObjectAttributes& object, uint32_t vertex);
// Unit or zero; `i` as normals_by_vertex() says. There must be a source.
vec3 normal_at(const ObjectAttributes& object, uint32_t i);
// As Mesh::tangents. The object must have them.
vec4 tangent_at(const ObjectAttributes& object, uint32_t i);

class AttributeTable {
 public:
  // Starts a frame of about so many rays; tables that depend on the scene alone are kept if it is
  // still the same one. Returns whether it is another.
  bool begin_frame(const World& world, const Scene& scene, const ScenePose& pose, uint64_t rays);

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
  struct MeshEntry {
    NormalSource rest = NormalSource::none;  // where normals come from if the mesh is rigid
    bool wants_tangents = false;
    std::vector<uint32_t> first;  // adjacency, as in ObjectAttributes
    std::vector<uint32_t> triangles;
    std::vector<vec3> normals;  // computed, of the rigid mesh
  };
  struct ObjectEntry {
    ObjectAttributes attributes;
    Motion motion;
    NormalSource source = NormalSource::none;
    uint64_t frame = 0;  // in which attributes were made
    std::vector<vec3> positions, normals;
    std::vector<vec4> tangents;
  };

  void bind(const Scene& scene);
  void refresh_object(uint32_t index);
  void make_normals(ObjectEntry& object, MeshEntry& shared);

  const World* world_ = nullptr;
  const Scene* scene_ = nullptr;
  const ScenePose* pose_ = nullptr;
  uint64_t scene_identity_ = 0;
  uint64_t frame_ = 0;
  std::vector<MeshEntry> meshes_;
  std::vector<ObjectEntry> objects_;
  uint64_t rays_ = 0;
  std::unique_ptr<std::atomic<uint8_t>[]> touched_;
};

}  // namespace sinew
