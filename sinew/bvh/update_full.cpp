// Update mode `full`: all treelets, then the upper tree.
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/update.h"
#include "sinew/bvh/update_kernels.h"

namespace sinew {
namespace {

constexpr uint32_t kTreeletsPerTask = 64;

// Copies the constant parts (child words, primitives) from the layout and empties all boxes.
void allocate(const Bvh8Layout& layout, Bvh8& out) {
  out.nodes.assign(layout.children.size(), empty_node());
  for (size_t n = 0; n < layout.children.size(); ++n) {
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = layout.children[n][lane];
      const bool linked = word != kNoChild && is_treelet_word(word);
      out.nodes[n].child[lane] = linked ? made_word(layout.treelets[word & ~kTreeletBit]) : word;
    }
  }
  out.packets.resize(layout.packet_primitives.size());
  for (size_t p = 0; p < out.packets.size(); ++p) {
    for (uint32_t lane = 0; lane < kPacket; ++lane) {
      out.packets[p].primitive[lane] = layout.packet_primitives[p][lane];
    }
  }
  out.root = kNoChild;
  if (layout.upper_nodes > 0) out.root = inner_word(0);
  if (layout.upper_nodes == 0 && !layout.treelets.empty()) out.root = made_word(layout.treelets[0]);
}

Box node_box(const Node8& node) {
  Box box;
  for (uint32_t lane = 0; lane < kWidth; ++lane) box.extend(lane_box(node, lane));
  return box;
}

// The boxes of upper nodes below upper nodes; those of treelets are there already.
void refit_upper(const Bvh8Layout& layout, Bvh8& out) {
  for (uint32_t n = layout.upper_nodes; n-- > 0;) {
    Node8& node = out.nodes[n];
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = layout.children[n][lane];
      if (word == kNoChild || is_treelet_word(word)) continue;
      set_lane_box(node, lane, node_box(out.nodes[word]));
    }
  }
}

}  // namespace

void update_full(const Bvh8Layout& layout, std::span<const vec3> positions, Bvh8& out) {
  SINEW_CHECK(positions.size() == layout.vertex_count);
  if (out.nodes.size() != layout.children.size() ||
      out.packets.size() != layout.packet_vertices.size()) {
    allocate(layout, out);
  }
  out.box = Box();
  if (layout.treelets.empty()) return;
  const UpdateJob job{layout.treelets.data(), layout.packet_vertices.data(),
                      layout.upper_nodes,     positions.data(),
                      layout.vertex_count,    out.nodes.data(),
                      out.packets.data(),     &out.box};
  parallel_for(layout.treelets.size(), kTreeletsPerTask, [&](size_t begin, size_t end) {
    make_treelets(job, static_cast<uint32_t>(begin), static_cast<uint32_t>(end));
  });
  if (layout.upper_nodes == 0) return;
  refit_upper(layout, out);
  out.box = node_box(out.nodes[0]);
}

}  // namespace sinew
