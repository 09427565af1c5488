#include "sinew/bvh/update/update_local.h"

#include <algorithm>
#include <atomic>
#include <functional>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/update/update_kernels.h"
#include "sinew/bvh/update/visit.h"

namespace sinew {
namespace {

constexpr size_t kTreeletsPerTask = 32;

void find_treelets(VertexRange changed, WayUp& way) {
  way.treelets.clear();
  for (uint32_t k = way.first[changed.first]; k < way.first[changed.first + changed.count]; ++k) {
    const uint32_t treelet = way.treelet[k];
    if (way.treelet_mark[treelet] != 0) continue;
    way.treelet_mark[treelet] = 1;
    way.treelets.push_back(treelet);
  }
  for (const uint32_t treelet : way.treelets) way.treelet_mark[treelet] = 0;
}

void mark(uint32_t node, WayUp& way) {
  while (node != kNoChild && way.node_mark[node] == 0) {
    way.node_mark[node] = 1;
    way.nodes.push_back(node);
    node = way.parent[node];
  }
}

// The boxes of the treelets' parents and of all nodes above them; parents stand before children.
void refit_up(const Bvh8Layout& layout, WayUp& way, Bvh8& out) {
  way.nodes.clear();
  for (const uint32_t t : way.treelets) mark(layout.treelets[t].parent_node, way);
  std::sort(way.nodes.begin(), way.nodes.end(), std::greater());
  for (const uint32_t n : way.nodes) {
    way.node_mark[n] = 0;
    const Box box = node_box(out.nodes[n]);
    if (way.parent[n] == kNoChild) {
      out.box = box;
    } else {
      set_lane_box(out.nodes[way.parent[n]], way.lane[n], box);
    }
  }
}

}  // namespace

WayUp find_way_up(const Bvh8Layout& layout) {
  WayUp way;
  way.first.assign(size_t{layout.vertex_count} + 1, 0);
  for (const uint32_t vertex : layout.vertices) ++way.first[vertex + 1];
  for (size_t v = 1; v < way.first.size(); ++v) way.first[v] += way.first[v - 1];
  way.treelet.resize(layout.vertices.size());
  std::vector<uint32_t> next(way.first.begin(), way.first.end() - 1);
  for (uint32_t t = 0; t < layout.treelets.size(); ++t) {
    const Treelet& treelet = layout.treelets[t];
    for (uint32_t i = 0; i < treelet.vertex_count; ++i) {
      way.treelet[next[layout.vertices[treelet.first_vertex + i]]++] = t;
    }
  }
  way.parent.assign(layout.upper_nodes, kNoChild);
  way.lane.assign(layout.upper_nodes, 0);
  for (uint32_t n = 0; n < layout.upper_nodes; ++n) {
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = layout.children[n][lane];
      if (!is_inner_word(word)) continue;
      way.parent[word] = n;
      way.lane[word] = static_cast<uint8_t>(lane);
    }
  }
  way.treelet_mark.assign(layout.treelets.size(), 0);
  way.node_mark.assign(layout.upper_nodes, 0);
  return way;
}

bool update_local(const Bvh8Layout& layout, std::span<const vec3> positions, VertexRange changed,
                  WayUp& way, Bvh8& out) {
  SINEW_CHECK(positions.size() == layout.vertex_count);
  SINEW_CHECK(uint64_t{changed.first} + changed.count <= layout.vertex_count);
  find_treelets(changed, way);
  const UpdateJob job{&layout, positions.data(), out.nodes.data(), out.packets.data()};
  std::atomic<bool> finite = true;
  parallel_for(way.treelets.size(), kTreeletsPerTask, [&](size_t begin, size_t end) {
    bool all = true;
    for (size_t i = begin; i < end; ++i) {
      const uint32_t t = way.treelets[i];
      if (!out.by_links) {
        all &= make_treelets(job, t, t + 1, out.box);
        continue;
      }
      Box box;
      all &= treelet_boxes(job, t, {&box, 1});
      out.links[t] = kUnmade;
      set_treelet_box(layout, t, box, out);
    }
    if (!all) finite.store(false, std::memory_order_relaxed);
  });
  if (layout.upper_nodes > 0) refit_up(layout, way, out);
  return finite;
}

}  // namespace sinew
