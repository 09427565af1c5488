// The kernels behind all updates: boxes of treelets, and their insides.
#pragma once

#include <cstdint>
#include <span>

#include "sinew/bvh/wide.h"

namespace sinew {

// Views of a layout and of the buffers of a pose.
struct UpdateJob {
  const Bvh8Layout* layout = nullptr;
  const vec3* positions = nullptr;  // of all the body's vertices; null in make_treelet()
  Node8* nodes = nullptr;
  TrianglePacket* packets = nullptr;  // null in make_treelet()
};

// Vertices are read four floats at a time, so a span that kernels read ends one float before its
// storage does.
using TreeletVertices = std::array<vec3, kMaxTreeletVertices + 1>;

// Makes the treelets [begin, end): packets, nodes, and the box in the parent's lane; or `root_box`
// if there are no upper nodes. Different treelets may be made by different threads at once. Returns
// whether all their vertices are finite.
bool make_treelets(const UpdateJob& job, uint32_t begin, uint32_t end, Box& root_box);

// Puts the treelet's box where rays look for it: in the parent's lane, or, if it is the whole body,
// in `out.box`.
inline void set_treelet_box(const Bvh8Layout& layout, uint32_t treelet, const Box& box, Bvh8& out) {
  const Treelet& t = layout.treelets[treelet];
  if (layout.upper_nodes > 0) {
    set_lane_box(out.nodes[t.parent_node], t.parent_lane, box);
  } else {
    out.box = box;
  }
}

// Makes the nodes of one treelet from the positions of its own vertices, in the order of
// Bvh8Layout::vertices, and one place more whose value does not matter. The parent is left alone.
void make_treelet(const UpdateJob& job, uint32_t treelet, const vec3* at);

// Packs the treelet's triangles into `out`, one packet after another.
void pack_treelet(const Bvh8Layout& layout, uint32_t treelet, const TreeletVertices& at,
                  TrianglePacket* out);

// The exact boxes of the treelets [begin, begin + out.size()), from their vertices. Returns whether
// all of these are finite.
bool treelet_boxes(const UpdateJob& job, uint32_t begin, std::span<Box> out);

}  // namespace sinew
