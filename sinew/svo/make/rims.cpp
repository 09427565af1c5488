#include "sinew/svo/make/rims.h"

#include <algorithm>
#include <cmath>

#include "sinew/svo/make/key_table.h"
#include "sinew/svo/make/lattice_source.h"

namespace sinew {
namespace {

constexpr float kSharp = 0.25f;  // cosine of the angle between normals

// A triangle's edge, listed with its lower vertex.
struct Edge {
  uint32_t other = 0;     // the higher vertex
  uint32_t triangle = 0;  // twice, and 1 if it passes the edge from the lower vertex
};

vec3 unit_normal(std::span<const vec3> positions, uvec3 t) {
  const vec3 normal = cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
  const float size = length(normal);
  return size > 0.0f && std::isfinite(size) ? normal / size : vec3(0.0f);
}

// `edges` of one lower vertex: a few. Where more than two triangles have an edge, each needs one
// other from which it does not turn sharply.
void mark_rims(std::span<const Edge> edges, std::span<const vec3> normals,
               std::vector<uint8_t>& out) {
  for (const Edge& edge : edges) {
    bool goes_on = false;
    for (const Edge& next : edges) {
      if (next.other != edge.other || next.triangle >> 1 == edge.triangle >> 1) continue;
      const bool same_way = ((next.triangle ^ edge.triangle) & 1) == 0;  // seen from behind then
      const float cosine = dot(normals[next.triangle >> 1], normals[edge.triangle >> 1]);
      goes_on = goes_on || (same_way ? -cosine : cosine) >= kSharp;
    }
    if (!goes_on) out[edge.triangle >> 1] = 1;
  }
}

}  // namespace

std::vector<uint8_t> rim_triangles(std::span<const vec3> positions,
                                   std::span<const uvec3> triangles) {
  LatticeSource source;
  source.rest = positions;
  KeyTable places(positions.size());
  std::vector<uint32_t> place(positions.size());
  for (uint32_t v = 0; v < place.size(); ++v) place[v] = places.number(vertex_key(source, v));
  std::vector<vec3> normals(triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) normals[i] = unit_normal(positions, triangles[i]);
  const auto each_edge = [&](auto&& call) {
    for (uint32_t i = 0; i < triangles.size(); ++i) {
      if (normals[i] == vec3(0.0f)) continue;
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = place[triangles[i][k]], b = place[triangles[i][(k + 1) % 3]];
        call(std::min(a, b), Edge{std::max(a, b), 2 * i + (a < b)});
      }
    }
  };
  std::vector<uint32_t> first(places.size() + 2, 0);  // edge of each vertex; one place ahead
  each_edge([&](uint32_t low, Edge) { ++first[low + 2]; });
  for (size_t v = 2; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<Edge> edges(first.back());
  each_edge([&](uint32_t low, Edge edge) { edges[first[low + 1]++] = edge; });
  std::vector<uint8_t> out(triangles.size(), 0);
  for (uint32_t v = 0; v < places.size(); ++v) {
    mark_rims({edges.data() + first[v], first[v + 1] - first[v]}, normals, out);
  }
  return out;
}

}  // namespace sinew
