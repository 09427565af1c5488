// Queries that are not rays: the nearest point of the surface, and the triangles that meet a box.
// They visit bodies and treelets as rays do, so that what is not near is not made.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sinew/bvh/trace/traverse.h"
#include "sinew/math/box.h"

namespace sinew {

struct NearestPoint {
  float distance = 0.0f;  // in the world
  vec3 point{0.0f};       // in the world
  float u = 0.0f;         // where in the triangle, as Hit::u and v
  float v = 0.0f;
  uint32_t primitive = 0;
  uint32_t object = 0;
};

// The nearest point within `max_distance` of `from`; of several at the same distance, one of the
// least (object, primitive). Computed in float.
std::optional<NearestPoint> nearest_point(
    const SceneView& scene, vec3 from, float max_distance = std::numeric_limits<float>::infinity(),
    uint32_t mask = 0xffffffffu);

struct TriangleId {
  uint32_t object = 0;
  uint32_t primitive = 0;
  auto operator<=>(const TriangleId&) const = default;
};

// The triangles that have a point in common with the box (in the world), in order of their ids.
// Based on: T. Akenine-Moller, "Fast 3D Triangle-Box Overlap Testing", 2001. Computed in float:
// triangles that just touch may be missed.
void triangles_in_box(const SceneView& scene, const Box& box, std::vector<TriangleId>& out,
                      uint32_t mask = 0xffffffffu);

}  // namespace sinew
