#include "sinew/io/gltf/write_vertices.h"

#include <algorithm>
#include <array>
#include <utility>

namespace sinew::gltf {
namespace {

bool has_attributes(const Mesh& mesh) {
  return !mesh.normals.empty() || !mesh.tangents.empty() || !mesh.texcoords[0].empty() ||
         !mesh.texcoords[1].empty() || !mesh.colors.empty();
}

// Fills parts, and triangles as `corner_of` gives them, in the mesh's order within each part.
template <class CornerOf>
void group_by_part(const Mesh& mesh, MeshVertices& out, const CornerOf& corner_of) {
  std::vector<uint32_t> begin(mesh.parts.size() + 1, 0);
  for (const uint32_t part : mesh.triangle_part) ++begin[part + 1];
  for (size_t i = 0; i < mesh.parts.size(); ++i) begin[i + 1] += begin[i];
  std::vector<uint32_t> next = begin;
  out.triangles.resize(mesh.triangles.size());
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const uint32_t part = mesh.triangle_part[t];
    out.triangles[next[part]++] = corner_of(t);
  }
  std::array<int32_t, 2> set_of = {-1, -1};  // smooth, flat
  for (uint32_t part = 0; part < mesh.parts.size(); ++part) {
    const uint32_t count = begin[part + 1] - begin[part];
    if (count == 0) continue;
    int32_t& set = set_of[mesh.parts[part].flat ? 1 : 0];
    if (set < 0) {
      set = static_cast<int32_t>(out.sets.size());
      out.sets.push_back({.flat = mesh.parts[part].flat, .count = 0, .points = {}, .corners = {}});
    }
    out.parts.push_back({part, static_cast<uint32_t>(set), begin[part], count});
  }
}

uint64_t key_of(uint32_t point, uint32_t corner) {
  return uint64_t{point} << 32 | corner;
}

// The pairs of position and corner that the triangles of `set` use become its vertices, in order of
// their positions. `points` and `corners` hold the triangles part by part.
void make_set(MeshVertices& out, uint32_t set, const std::vector<uvec3>& points,
              const std::vector<uvec3>& corners) {
  std::vector<uint64_t> keys;
  const auto for_each_triangle = [&](const auto& function) {
    for (const PartTriangles& part : out.parts) {
      for (uint32_t t = part.first; part.set == set && t < part.first + part.count; ++t) {
        function(t);
      }
    }
  };
  for_each_triangle([&](uint32_t t) {
    for (int k = 0; k < 3; ++k) keys.push_back(key_of(points[t][k], corners[t][k]));
  });
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for_each_triangle([&](uint32_t t) {
    for (int k = 0; k < 3; ++k) {
      const auto at =
          std::lower_bound(keys.begin(), keys.end(), key_of(points[t][k], corners[t][k]));
      out.triangles[t][k] = static_cast<uint32_t>(at - keys.begin());
    }
  });
  VertexSet& vertices = out.sets[set];
  vertices.count = static_cast<uint32_t>(keys.size());
  for (const uint64_t key : keys) {
    vertices.points.push_back(static_cast<uint32_t>(key >> 32));
    vertices.corners.push_back(static_cast<uint32_t>(key));
  }
}

}  // namespace

uint32_t MeshVertices::count() const {
  uint32_t sum = 0;
  for (const VertexSet& set : sets) sum += set.count;
  return sum;
}

std::vector<uint32_t> MeshVertices::dense_points(size_t position_count) const {
  std::vector<uint32_t> rank(position_count, 0);
  for (const VertexSet& set : sets) {
    for (uint32_t v = 0; v < set.count; ++v) rank[set.point(v)] = 1;
  }
  uint32_t used = 0;
  for (uint32_t& r : rank) used += std::exchange(r, used);
  std::vector<uint32_t> result;
  result.reserve(count());
  for (const VertexSet& set : sets) {
    for (uint32_t v = 0; v < set.count; ++v) result.push_back(rank[set.point(v)]);
  }
  return result;
}

MeshVertices split_vertices(const Mesh& mesh) {
  MeshVertices out;
  group_by_part(mesh, out, [&](uint32_t t) { return mesh.triangles[t]; });
  const bool seams = !mesh.corners.empty() && has_attributes(mesh);
  if (out.sets.size() == 1 && !seams) {
    out.sets[0].count = static_cast<uint32_t>(mesh.positions.size());
    return out;
  }
  const std::vector<uvec3> points = out.triangles;
  std::vector<uvec3> corners = points;
  if (seams) {
    MeshVertices of_corners;
    group_by_part(mesh, of_corners, [&](uint32_t t) { return mesh.corners[t]; });
    corners = std::move(of_corners.triangles);
  }
  for (uint32_t set = 0; set < out.sets.size(); ++set) make_set(out, set, points, corners);
  return out;
}

}  // namespace sinew::gltf
