// The slow, obvious twins of the voxeliser: one voxel and one triangle, in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/svo/make/voxelize.h"

namespace sinew::test {

using glm::dvec3;

// Whether the projections of triangle and cube on the axis have a point in common.
inline bool overlap_along(dvec3 axis, const dvec3 (&v)[3], dvec3 center) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const dvec3& p : v) {
    low = std::min(low, dot(axis, p - center));
    high = std::max(high, dot(axis, p - center));
  }
  const double reach = 0.5 * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
  return low <= reach && high >= -reach;
}

inline dvec3 unit_axis(int k) {
  dvec3 axis(0.0);
  axis[k] = 1.0;
  return axis;
}

// T. Akenine-Moller, "Fast 3D Triangle-Box Overlap Testing", 2001: 13 axes.
inline bool touches(const dvec3 (&v)[3], dvec3 center) {
  if (!overlap_along(cross(v[1] - v[0], v[2] - v[0]), v, center)) return false;
  for (int k = 0; k < 3; ++k) {
    if (!overlap_along(unit_axis(k), v, center)) return false;
    for (int i = 0; i < 3; ++i) {
      if (!overlap_along(cross(v[(i + 1) % 3] - v[i], unit_axis(k)), v, center)) return false;
    }
  }
  return true;
}

// As mark_triangle() defines it.
inline bool thin_shell_has(const dvec3 (&v)[3], dvec3 center) {
  const dvec3 normal = cross(v[1] - v[0], v[2] - v[0]);
  int w = 0;
  for (int k = 0; k < 3; ++k) {
    if (!overlap_along(unit_axis(k), v, center)) return false;
    if (std::abs(normal[k]) >= std::abs(normal[w])) w = k;
  }
  // How far above the centre the plane is, in units of the normal's length along w.
  const double above = dot(normal, v[0] - center) * (normal[w] < 0.0 ? -1.0 : 1.0);
  const double half = 0.5 * std::abs(normal[w]);
  if (!(above >= -half && above < half)) return false;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      const dvec3 across = cross(v[(i + 1) % 3] - v[i], unit_axis(k));
      const double inner = dot(across, v[(i + 2) % 3] - v[i]);
      const double reach =
          0.5 * std::max({std::abs(across.x), std::abs(across.y), std::abs(across.z)});
      const double at = dot(across, center - v[i]);
      if (inner >= 0.0 && at < -reach) return false;
      if (inner <= 0.0 && at > reach) return false;
    }
  }
  return true;
}

// Coordinates in voxels; the voxel is the cube from `voxel` to `voxel` + 1.
inline bool shell_has(const dvec3 (&v)[3], dvec3 voxel, Shell shell) {
  return shell == Shell::thin ? thin_shell_has(v, voxel + 0.5) : touches(v, voxel + 0.5);
}

// C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
inline dvec3 nearest_point(const dvec3 (&v)[3], dvec3 p) {
  const auto on_edge = [&](dvec3 a, dvec3 b) {
    const double length2 = dot(b - a, b - a);
    return a + (length2 > 0.0 ? std::clamp(dot(p - a, b - a) / length2, 0.0, 1.0) : 0.0) * (b - a);
  };
  const dvec3 normal = cross(v[1] - v[0], v[2] - v[0]);
  const dvec3 on_plane = p - normal * (dot(normal, p - v[0]) / dot(normal, normal));
  bool inside = true;
  dvec3 best = v[0];
  for (int i = 0; i < 3; ++i) {
    const dvec3 a = v[i], b = v[(i + 1) % 3];
    inside = inside && dot(cross(b - a, on_plane - a), normal) >= 0.0;
    const dvec3 at = on_edge(a, b);
    if (length(at - p) < length(best - p)) best = at;
  }
  return inside ? on_plane : best;
}

}  // namespace sinew::test
