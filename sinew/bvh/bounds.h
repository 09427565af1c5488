// Bounds: the boxes of a Tree's nodes in one frame. Topology and boxes are separate values, so one
// tree can be judged over many frames and a refit writes a single array.
#pragma once

#include <span>
#include <vector>

#include "sinew/bvh/tree.h"
#include "sinew/math/box.h"

namespace sinew {

using Bounds = std::vector<Box>;  // one a tree node

// Box of each triangle.
void triangle_boxes(std::span<const vec3> positions, std::span<const uvec3> triangles,
                    std::span<Box> out);

// Bottom-up boxes of all nodes over the primitives' boxes.
Bounds refit(const Tree& tree, std::span<const Box> primitive_boxes);

// Half the surface area of each.
std::vector<float> half_areas(const Bounds& bounds);

}  // namespace sinew
