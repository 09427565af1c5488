// The surface area heuristic: the expected cost of a random ray through the root's box.
#pragma once

#include "sinew/bvh/bounds.h"
#include "sinew/bvh/wide.h"

namespace sinew {

struct CostModel {
  float traversal = 3.0f;     // c_T of T (T-SAH 2015): one inner node
  float intersection = 2.0f;  // c_I of T: one triangle
};

// C = (c_T * sum of inner areas + c_I * sum of leaf areas * primitives) / root area. 0 for an empty
// tree or one without area.
double sah_cost(const Tree& tree, const Bounds& bounds, const CostModel& model = {});

// The same for the traced layout in a pose, down to the treelets: a treelet counts as
// its packets of four triangles, all of them.
double upper_cost(const Bvh8Layout& layout, const Bvh8& bvh, const CostModel& model = {});

}  // namespace sinew
