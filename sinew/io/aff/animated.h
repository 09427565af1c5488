// Animated triangles (`tpa`): triangles with a shape for each of several times.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/mesh.h"

namespace sinew::aff {

// Triangles that have the same times. Positions are key by key, three a triangle.
struct AnimatedTriangles {
  std::vector<float> times;         // seconds, increasing
  std::vector<vec3> positions;      // (triangle * times.size() + key) * 3 + corner
  std::vector<uint32_t> materials;  // one a triangle: index into Scene::materials
  uint64_t flat_votes = 0;          // keys of triangles whose three normals are equal ...
  uint64_t smooth_votes = 0;        // ... and not
};

// One mesh with a key a time. Corners that stand together at every time become one vertex. It is
// flat if most of the file's normals are.
Mesh make_animated_mesh(const AnimatedTriangles& in);

// n if there are 4^n triangles.
std::optional<int> complexity_of(size_t triangles);

// Splits every triangle into four at the middles of its edges, in every key. Keys whose vertices
// lie on a sphere keep to it.
void subdivide(Mesh& mesh);

struct Sphere {
  vec3 center{0.0f};
  float radius = 0.0f;
};
// The sphere on which all of at least 16 points lie to within 1e-4 of its radius, if there is one.
std::optional<Sphere> sphere_through(std::span<const vec3> points);

}  // namespace sinew::aff
