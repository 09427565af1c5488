// Update mode `local`: only some vertices have moved. What holds them is brought up to date, and
// the boxes on the way to the root: O(m + log n) for m changed vertices that are near each other.
// Based on: T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy Updates for
// Ray Tracing of Deformable Models", 2003, section 3.2, last paragraph.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/wide.h"
#include "sinew/motion/pose.h"

namespace sinew {

// What leads from a vertex up to the root; made once a layout.
struct WayUp {
  std::vector<uint32_t> first;    // vertex v is in the treelets treelet[first[v]] up to
  std::vector<uint32_t> treelet;  // treelet[first[v + 1] - 1]
  std::vector<uint32_t> parent;   // of every upper node; the root's is kNoChild
  std::vector<uint8_t> lane;      // in the parent
  std::vector<uint8_t> treelet_mark, node_mark;  // scratch, 0 between calls
  std::vector<uint32_t> treelets, nodes;         // scratch
};
WayUp find_way_up(const Bvh8Layout& layout);

// Vertices outside `changed`, which must be within the body, are where the last update had them.
// Treelets are made at once, or, if they hang by links, when the next ray comes. Returns whether
// the vertices of all treelets concerned are finite. Must not overlap queries.
bool update_local(const Bvh8Layout& layout, std::span<const vec3> positions, VertexRange changed,
                  WayUp& way, Bvh8& out);

}  // namespace sinew
