// The kernel behind all updates: makes the insides of treelets.
#pragma once

#include <cstdint>

#include "sinew/bvh/wide.h"

namespace sinew {

// Views of a layout, its pose's buffers and the vertices.
struct UpdateJob {
  const Treelet* treelets = nullptr;
  const PacketVertices* packet_vertices = nullptr;
  uint32_t upper_nodes = 0;
  const vec3* positions = nullptr;
  uint32_t vertex_count = 0;          // > 0
  Node8* nodes = nullptr;             // child words are set, boxes of absent children empty
  TrianglePacket* packets = nullptr;  // primitives are set
  Box* root_box = nullptr;            // written if there are no upper nodes
};

// Makes the treelets [begin, end): packets, inner boxes, and the box in the parent's lane.
// Different treelets may be made by different threads at once.
void make_treelets(const UpdateJob& job, uint32_t begin, uint32_t end);

}  // namespace sinew
