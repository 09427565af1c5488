// Shapes that study scenes are made of. All are wound counter-clockwise seen from outside.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/mesh.h"

namespace sinew {

struct TriangleSurface {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
};

// A unit sphere: the icosahedron with every edge cut in `frequency` (>= 1) equal arcs.
// 20 f^2 triangles, 10 f^2 + 2 vertices, closed.
TriangleSurface geodesic_sphere(uint32_t frequency);

// A closed skin over `rows` rings of `around` vertices and a pole at each end: 2 * around * rows
// triangles, around * rows + 2 vertices. `point(u, v)` with u in [0, 1) around and v in [0, 1] from
// the first pole to the last; the poles are point(0, 0) and point(0, 1). The rings run
// counter-clockwise seen from the last pole. Calls of `point` run in parallel.
TriangleSurface closed_tube(uint32_t around, uint32_t rows,
                            const std::function<vec3(float u, float v)>& point);

// A flat disc around the origin, facing +Y: `sectors` quads around and `rings` outwards. Texture
// coordinates are polar, so that the disc can turn beneath a pattern that repeats:
// (turns * angle / 2 pi, radius / ring_height).
struct DiscConfig {
  float radius = 1.0f;
  uint32_t sectors = 64;
  uint32_t rings = 8;
  float rim = 0.1f;          // how far the edge goes down
  float turns = 1.0f;        // repeats of the texture around the disc
  float ring_height = 1.0f;  // repeats of the texture outwards
};
Mesh make_disc(const DiscConfig& config, uint32_t material);

// The six sides of a box, seen from outside, or from inside if `inward`. One part.
Mesh make_box(vec3 low, vec3 high, bool inward, uint32_t material);

// Area-weighted unit normals of the vertices.
std::vector<vec3> vertex_normals(std::span<const vec3> positions, std::span<const uvec3> triangles);

// Half-edge 3 t + k runs from corner k to corner k + 1 of triangle t. Entry h is the half-edge that
// runs the other way, or kNoHalfEdge if there is none, or if the edge has more than two triangles.
inline constexpr uint32_t kNoHalfEdge = 0xffffffffu;
std::vector<uint32_t> opposite_half_edges(std::span<const uvec3> triangles);

// A mesh of one part.
Mesh single_part_mesh(TriangleSurface surface, uint32_t material);

}  // namespace sinew
