// The triangles under an octree as the skin lattice sees them, and points on them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>

#include "sinew/motion/motion.h"
#include "sinew/svo/make/block_part.h"
#include "sinew/svo/make/fragments.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {

struct LatticeSource {
  VoxelGrid grid;
  std::span<const uvec3> triangles;
  std::span<const uint16_t> materials;  // one a triangle
  std::span<const vec3> rest;           // of the vertices; empty if nothing is known of them
  SkinMotion skin;                      // influences == 0: none
  std::span<const vec3> deltas;         // of morph targets, target-major
  uint32_t targets = 0;
};
LatticeSource lattice_source(const VoxelGrid& grid, const SvoSource& source);

// A point on the surface, as a corner sees it: a + v (b - a) + w (c - a).
struct SheetPoint {
  float distance2 = std::numeric_limits<float>::infinity();
  uint32_t triangle = kInside;  // none
  float v = 0.0f, w = 0.0f;
};
// A total order, so that whoever compares the same points takes the same one.
inline bool nearer(const SheetPoint& a, const SheetPoint& b) {
  if (a.distance2 != b.distance2) return a.distance2 < b.distance2;
  return std::tie(a.triangle, a.v, a.w) < std::tie(b.triangle, b.v, b.w);
}

// The point of the triangle that is nearest to `to`.
SheetPoint nearest_point(const LatticeSource& source, uint32_t triangle, vec3 to);
// The same point of the surface as seen from elsewhere.
SheetPoint seen_from(const LatticeSource& source, const SheetPoint& point, vec3 to);

// The four heaviest influences on the point, which sum to 65535.
void skin_corner(const LatticeSource& source, const SheetPoint& point, PartCorner& out);
vec3 target_delta(const LatticeSource& source, const SheetPoint& point, uint32_t target);

// Equal for vertices at equal positions; of vertices without positions, for the same one.
uint64_t vertex_key(const LatticeSource& source, uint32_t vertex);

}  // namespace sinew
