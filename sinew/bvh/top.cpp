#include "sinew/bvh/top.h"

#include "sinew/bvh/build.h"
#include "sinew/bvh/collapse.h"

namespace sinew {
namespace {

void set_child(Node8& node, uint32_t lane, const Box& box, uint32_t word) {
  set_lane_box(node, lane, box);
  node.child[lane] = word;
}

}  // namespace

Node8 empty_node() {
  Node8 node = {};
  for (uint32_t lane = 0; lane < kWidth; ++lane) set_child(node, lane, Box(), kNoChild);
  return node;
}

void build_top(std::span<const Box> boxes, std::vector<Node8>& out) {
  out.clear();
  if (boxes.empty()) return;
  const Tree tree = build_binned(boxes, {.leaf_block = 1, .max_leaf = 1});
  const Bounds bounds = refit(tree, boxes);
  const auto is_leaf = [&](uint32_t node) { return tree.nodes[node].is_leaf(); };
  const auto leaf = [&](uint32_t node) {
    return kLeafBit | tree.primitives[tree.nodes[node].first()];
  };

  out.push_back(empty_node());
  if (is_leaf(Tree::kRoot)) return set_child(out[0], 0, bounds[0], leaf(Tree::kRoot));
  std::vector<uint32_t> queue = {Tree::kRoot};  // binary node of every wide node
  for (size_t next = 0; next < queue.size(); ++next) {
    const WideChildren children = open_children(tree, bounds, queue[next], is_leaf);
    for (uint32_t lane = 0; lane < children.count; ++lane) {
      const uint32_t child = children.node[lane];
      if (is_leaf(child)) {
        set_child(out[next], lane, bounds[child], leaf(child));
      } else {
        set_child(out[next], lane, bounds[child], inner_word(static_cast<uint32_t>(out.size())));
        out.push_back(empty_node());
        queue.push_back(child);
      }
    }
  }
}

}  // namespace sinew
