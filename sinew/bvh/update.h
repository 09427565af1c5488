// Updates: bring a Bvh8 to a new pose of its body, in place.
#pragma once

#include <span>

#include "sinew/bvh/wide.h"

namespace sinew {

// Mode `full`: every treelet from its vertices, bottom-up and in parallel, then the upper tree.
// Allocates only the first time (or when the layout changed). Positions must be finite for the
// triangles to be hit; a triangle with a vertex that is not finite is never hit and has no box.
void update_full(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out);

}  // namespace sinew
