// The surface area heuristic: the expected cost of a random ray through the root's box.
#pragma once

#include "sinew/bvh/bounds.h"
#include "sinew/bvh/wide.h"
#include "sinew/math/box.h"

namespace sinew {

struct CostModel {
  float traversal = 3.0f;     // c_T of T (T-SAH 2015): one inner node
  float intersection = 2.0f;  // c_I of T: one triangle
};

// half_area() in double, where it neither overflows nor drowns a triangle's share in a large scene.
inline double exact_half_area(const Box& b) {
  if (b.empty()) return 0.0;
  const double x = double(b.max.x) - double(b.min.x), y = double(b.max.y) - double(b.min.y);
  const double z = double(b.max.z) - double(b.min.z);
  return x * y + y * z + z * x;
}

// C = (c_T * sum of inner areas + c_I * sum of leaf areas * primitives) / root area. 0 for an empty
// tree or one without area.
double sah_cost(const Tree& tree, const Bounds& bounds, const CostModel& model = {});

// The same for the traced layout in a pose, down to the treelets: a treelet counts as
// its packets of four triangles, all of them.
double upper_cost(const Bvh8Layout& layout, const Bvh8& bvh, const CostModel& model = {});

}  // namespace sinew
