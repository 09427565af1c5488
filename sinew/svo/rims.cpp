#include "sinew/svo/rims.h"

#include <algorithm>
#include <cmath>

#include "sinew/svo/key_table.h"
#include "sinew/svo/lattice_source.h"

namespace sinew {
namespace {

constexpr float kSharp = 0.0f;  // cosine of the angle between normals

// The triangle that has the edge.
struct Edge {
  uint32_t triangle = 0;
  bool paired = false;
  bool forward = false;  // the triangle passes it from the lower vertex to the higher
};

vec3 unit_normal(std::span<const vec3> positions, uvec3 t) {
  const vec3 normal = cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
  const float size = length(normal);
  return size > 0.0f && std::isfinite(size) ? normal / size : vec3(0.0f);
}

}  // namespace

std::vector<uint8_t> rim_triangles(std::span<const vec3> positions,
                                   std::span<const uvec3> triangles) {
  LatticeSource source;
  source.rest = positions;
  KeyTable places(positions.size()), numbers(3 * triangles.size() / 2);
  std::vector<uint32_t> place(positions.size());
  for (uint32_t v = 0; v < place.size(); ++v) place[v] = places.number(vertex_key(source, v));
  std::vector<vec3> normals(triangles.size());
  std::vector<uint8_t> out(triangles.size(), 0);
  std::vector<Edge> edges;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    normals[i] = unit_normal(positions, triangles[i]);
    if (normals[i] == vec3(0.0f)) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = place[triangles[i][k]], b = place[triangles[i][(k + 1) % 3]];
      const uint32_t edge = numbers.number(uint64_t{std::min(a, b)} << 32 | std::max(a, b));
      if (edge == edges.size()) {
        edges.push_back({i, false, a < b});
        continue;
      }
      Edge& other = edges[edge];
      const float turned = (a < b) == other.forward ? -1.0f : 1.0f;  // seen from its other side
      const bool rim = turned * dot(normals[i], normals[other.triangle]) < kSharp;
      if (rim && !other.paired) out[i] = out[other.triangle] = 1;
      other.paired = true;
    }
  }
  for (const Edge& edge : edges) {
    if (!edge.paired) out[edge.triangle] = 1;
  }
  return out;
}

}  // namespace sinew
