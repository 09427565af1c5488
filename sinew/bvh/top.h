// The top tree: a small eight-wide tree over the boxes of objects, built anew for every frame.
#pragma once

#include <span>
#include <vector>

#include "sinew/bvh/wide.h"

namespace sinew {

// Memory that is used again for every frame.
struct TopScratch {
  std::vector<uint32_t> order;    // of the boxes
  std::vector<vec3> centers;      // twice
  std::vector<uint32_t> pending;  // ranges of `order`, three words each
};

// Nodes over boxes 0..n-1 with child words leaf_word-like: kLeafBit | index (see SceneView). Empty
// for no boxes. Boxes must be finite and not empty. Allocates only where the number grows.
void build_top(std::span<const Box> boxes, TopScratch& scratch, std::vector<Node8>& out);

}  // namespace sinew
