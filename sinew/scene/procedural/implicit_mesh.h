// Meshes for implicit surfaces: always closed and manifold, with well-shaped triangles.
// Based on: marching tetrahedra (A. Doi, A. Koide, 1991) on the body-centred cubic lattice, whose
// tetrahedra are all alike (F. Labelle, J. Shewchuk, "Isosurface Stuffing", 2007, section 3).
// Differs: crossings are kept away from lattice points, then vertices are spread by tangential
// smoothing and put back on the surface by Newton steps, so no slivers remain.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew {

// Negative inside, near to the signed distance around its zero set, and a pure function: it is
// called in parallel.
using Field = std::function<float(vec3)>;

struct ImplicitMeshConfig {
  Box box;                 // contains the surface
  float cell = 0.05f;      // edge of a lattice cube
  uint32_t smoothing = 4;  // rounds of spreading
};

struct ImplicitMesh {
  TriangleSurface surface;
  std::vector<vec3> normals;  // of the field, one a vertex
};

ImplicitMesh mesh_implicit(const Field& field, const ImplicitMeshConfig& config);

// The cell size for about `triangles` triangles, from a coarse trial.
float cell_for_triangles(const Field& field, const Box& box, uint32_t triangles);

}  // namespace sinew
