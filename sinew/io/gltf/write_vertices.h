// The vertices of a mesh as glTF has them: one index means a position and all attributes, and the
// primitives that have normals share no vertices with those that have none. Where neither splits
// anything the mesh's vertices stay as they are.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/scene/mesh.h"

namespace sinew::gltf {

// Vertices that some parts of a mesh share.
struct VertexSet {
  bool flat = false;  // without normals
  uint32_t count = 0;
  std::vector<uint32_t> points;   // one a vertex: index of its position; empty: its own index
  std::vector<uint32_t> corners;  // one a vertex: index of its attributes; empty: as points

  uint32_t point(size_t vertex) const {
    return points.empty() ? static_cast<uint32_t>(vertex) : points[vertex];
  }
  uint32_t corner(size_t vertex) const { return corners.empty() ? point(vertex) : corners[vertex]; }
};

struct PartTriangles {
  uint32_t part = 0;              // in Mesh::parts
  uint32_t set = 0;               // in MeshVertices::sets
  uint32_t first = 0, count = 0;  // in MeshVertices::triangles
};

struct MeshVertices {
  std::vector<VertexSet> sets;
  std::vector<PartTriangles> parts;  // those that have triangles; they name the sets in order
  std::vector<uvec3> triangles;      // part by part, vertices of the part's set

  // Whether the vertices are those of the mesh, in its order.
  bool unchanged() const { return sets.size() == 1 && sets[0].points.empty(); }
  uint32_t count() const;  // over all sets
  // For all vertices, set by set, the rank of its position among those used.
  std::vector<uint32_t> dense_points(size_t position_count) const;
};

MeshVertices split_vertices(const Mesh& mesh);

}  // namespace sinew::gltf
