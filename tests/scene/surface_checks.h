// Slow, obvious checks of surfaces for the tests of procedural shapes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

// Empty if every edge belongs to exactly two triangles that run along it in opposite directions,
// and the triangles around each vertex form one fan. Else what is wrong.
inline std::string why_not_manifold(std::span<const uvec3> triangles, size_t vertices) {
  struct Edge {
    uint32_t from, to, triangle;
  };
  std::vector<std::vector<Edge>> leaving(vertices);
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      if (a == b) return "triangle " + std::to_string(t) + " repeats a vertex";
      for (const Edge& e : leaving[a]) {
        if (e.to == b) return "edge runs twice, at triangle " + std::to_string(t);
      }
      leaving[a].push_back({a, b, t});
    }
  }
  const auto triangle_along = [&](uint32_t a, uint32_t b) -> int64_t {
    for (const Edge& e : leaving[a]) {
      if (e.to == b) return e.triangle;
    }
    return -1;
  };
  for (uint32_t v = 0; v < vertices; ++v) {
    if (leaving[v].empty()) continue;
    size_t steps = 0;
    uint32_t t = leaving[v][0].triangle;
    do {  // to the triangle across the edge that arrives at v
      const uvec3 c = triangles[t];
      const uint32_t before = c.x == v ? c.z : (c.y == v ? c.x : c.y);
      const int64_t next = triangle_along(v, before);
      if (next < 0) return "open edge at vertex " + std::to_string(v);
      t = static_cast<uint32_t>(next);
    } while (++steps <= leaving[v].size() && t != leaving[v][0].triangle);
    if (steps != leaving[v].size()) return "several fans at vertex " + std::to_string(v);
  }
  return {};
}

// Six times the volume that the surface encloses; positive if it is wound outwards.
inline double signed_volume6(std::span<const vec3> positions, std::span<const uvec3> triangles) {
  double sum = 0.0;
  for (const uvec3 t : triangles) {
    const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
    sum += dot(a, cross(b, c));
  }
  return sum;
}

// How many connected pieces the triangles form.
inline size_t count_components(std::span<const uvec3> triangles, size_t vertices) {
  std::vector<uint32_t> root(vertices);
  for (uint32_t i = 0; i < vertices; ++i) root[i] = i;
  const auto find = [&](uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  size_t count = 0;
  std::vector<uint8_t> used(vertices, 0);
  for (const uvec3 t : triangles) {
    for (int k = 0; k < 3; ++k) {
      if (!used[t[k]]) ++count;
      used[t[k]] = 1;
    }
    for (int k = 0; k < 2; ++k) {
      const uint32_t a = find(t[k]), b = find(t[k + 1]);
      if (a == b) continue;
      root[a] = b;
      --count;
    }
  }
  return count;
}

}  // namespace sinew
