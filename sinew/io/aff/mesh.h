// Gathers the primitives that become one Mesh: polygons, meshes, spheres and cones, brought into
// the mesh's space.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/mesh.h"

namespace sinew::aff {

// How a primitive comes into the mesh: points by `to_mesh`, normals by its cofactors. A mirroring
// map turns triangles round, so that their outside stays outside.
class Placement {
 public:
  explicit Placement(const glm::dmat4& to_mesh);
  vec3 point(vec3 p) const { return vec3(to_mesh_ * glm::dvec4(p, 1.0)); }
  // Unit length, or zero if it has no direction.
  vec3 normal(vec3 n) const;
  uvec3 order(uvec3 triangle) const {
    return mirrors_ ? uvec3(triangle.x, triangle.z, triangle.y) : triangle;
  }

 private:
  glm::dmat4 to_mesh_;
  glm::dmat3 normals_;
  bool mirrors_ = false;
};

// Indices into the arrays of one primitive. Without normals it is flat.
struct Primitive {
  uint32_t material = 0;  // index into Scene::materials
  std::span<const vec3> positions;
  std::span<const vec3> normals;    // any length
  std::span<const vec2> texcoords;  // v goes down, 0 at the top of the image
  std::span<const uvec3> triangles;
  std::span<const uvec3> triangle_normals;    // empty: as `triangles`
  std::span<const uvec3> triangle_texcoords;  // empty: as `triangles`
};

class MeshBuilder {
 public:
  void add(const Primitive& primitive, const Placement& placement);
  size_t triangle_count() const { return mesh_.triangles.size(); }

  // Leaves nothing behind.
  Mesh take();

 private:
  uint32_t part(uint32_t material, bool flat);
  uint32_t corner(vec3 normal, vec2 texcoord);

  Mesh mesh_;
  std::unordered_map<uint64_t, uint32_t> parts_;
  bool smooth_ = false;    // some part has normals
  bool textured_ = false;  // ... texture coordinates
};

// Points and normals of surfaces that the file gives by a formula, for Primitive. `triangles`
// index both.
struct Tessellation {
  std::vector<vec3> positions;
  std::vector<vec3> normals;
  std::vector<uvec3> triangles;
};

inline constexpr uint32_t kRoundSegments = 32;  // around a sphere or cone; a sphere has half from
                                                // pole to pole

// A negative radius means the inside.
Tessellation tessellate_sphere(vec3 center, float radius);
// Open at both ends; `apex_radius` may be 0. Negative radii mean the inside.
Tessellation tessellate_cone(vec3 base, float base_radius, vec3 apex, float apex_radius);

}  // namespace sinew::aff
