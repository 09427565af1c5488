// Adaptive leaf size. Based on: J. Bittner, M. Hapala, V. Havran, "Fast Insertion-Based
// Optimization of Bounding Volume Hierarchies", 2013, section 3.5; J. Bittner, D. Meister, "T-SAH",
// 2015, section 5.4. Differs: leaves have a limit, and their primitives cost blocks.
#include "sinew/base/check.h"
#include "sinew/bvh/frames/optimize.h"

namespace sinew {
namespace {

struct Subtree {
  double cost = 0.0;   // of the best way to have it
  uint32_t count = 0;  // primitives
  bool leaf = false;
};

struct LeafCost {
  const CostModel& model;
  uint32_t block;

  double operator()(uint32_t count, double area) const {
    const uint64_t blocks = (uint64_t{count} + block - 1) / block;
    return double(model.intersection) * static_cast<double>(blocks * block) * area;
  }
};

// Nodes so that every parent stands before its children.
std::vector<uint32_t> parents_first(const Tree& tree) {
  std::vector<uint32_t> order = {Tree::kRoot};
  order.reserve(tree.nodes.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const TreeNode& node = tree.nodes[order[i]];
    if (!node.is_leaf()) order.insert(order.end(), {node.left(), node.right()});
  }
  return order;
}

std::vector<Subtree> decide(const Tree& tree, std::span<const float> areas, const CostModel& model,
                            const LeafCost& leaf_cost, uint32_t max_leaf) {
  std::vector<Subtree> subtrees(tree.nodes.size());
  const std::vector<uint32_t> order = parents_first(tree);
  for (size_t i = order.size(); i-- > 0;) {
    const uint32_t n = order[i];
    const TreeNode& node = tree.nodes[n];
    if (node.is_leaf()) {
      subtrees[n] = {leaf_cost(node.count(), areas[n]), node.count(), true};
      continue;
    }
    const Subtree &left = subtrees[node.left()], &right = subtrees[node.right()];
    Subtree& own = subtrees[n];
    own = {double(model.traversal) * areas[n] + left.cost + right.cost, left.count + right.count};
    const double as_leaf = leaf_cost(own.count, areas[n]);
    if (own.count <= max_leaf && as_leaf < own.cost) {
      own.cost = as_leaf;
      own.leaf = true;
    }
  }
  return subtrees;
}

}  // namespace

Tree collapse_leaves(const Tree& tree, const FrameBoxes& frames, std::span<const double> g,
                     const CostModel& model, uint32_t leaf_block, uint32_t max_leaf) {
  SINEW_CHECK(leaf_block >= 1 && max_leaf >= 1 && g.size() == frames.frame_count());
  if (tree.empty()) return tree;
  const std::vector<Subtree> subtrees =
      decide(tree, weighted_areas(tree, frames, g), model, LeafCost{model, leaf_block}, max_leaf);

  struct Pending {
    uint32_t from, parent;
    bool right;
    bool inside;  // a leaf that is being made: only its primitives are of interest
  };
  Tree out;
  out.primitives.reserve(tree.primitives.size());
  std::vector<Pending> stack = {{Tree::kRoot, 0, false, false}};
  while (!stack.empty()) {
    const Pending item = stack.back();
    stack.pop_back();
    const TreeNode& from = tree.nodes[item.from];
    const auto node = static_cast<uint32_t>(out.nodes.size());
    const bool leaf = item.inside || subtrees[item.from].leaf;
    if (!item.inside) {
      const auto first = static_cast<uint32_t>(out.primitives.size());
      out.nodes.push_back(leaf ? TreeNode::leaf(first, subtrees[item.from].count) : TreeNode());
      if (node > 0) (item.right ? out.nodes[item.parent].b : out.nodes[item.parent].a) = node;
    }
    if (from.is_leaf()) {
      const auto first = tree.primitives.begin() + from.first();
      out.primitives.insert(out.primitives.end(), first, first + from.count());
    } else {
      stack.push_back({from.right(), node, true, leaf});
      stack.push_back({from.left(), node, false, leaf});
    }
  }
  return out;
}

TimedTree traced_tree(const Tree& tree, const FrameBoxes& frames, double exponent) {
  constexpr BuildConfig kTraced{};
  constexpr CostModel kCost{kTraced.traversal_cost,
                            kTraced.intersection_cost / float(kTraced.leaf_block)};
  const std::vector<double> g = area_weights(tree, frames, frame_costs(tree, frames), exponent);
  TimedTree out;
  out.tree = collapse_leaves(tree, frames, g, kCost, kTraced.leaf_block, kTraced.max_leaf);
  out.areas = weighted_areas(out.tree, frames, g);
  return out;
}

}  // namespace sinew
