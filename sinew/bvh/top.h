// The top tree: a small eight-wide tree over the boxes of objects, built anew for every frame.
#pragma once

#include <span>
#include <vector>

#include "sinew/bvh/wide.h"

namespace sinew {

// Nodes over boxes 0..n-1 with child words kLeafBit | index (see SceneView). Empty for no boxes.
// Boxes must be finite and not empty.
void build_top(std::span<const Box> boxes, std::vector<Node8>& out);

}  // namespace sinew
