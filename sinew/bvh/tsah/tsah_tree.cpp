#include "sinew/bvh/tsah/tsah_tree.h"

#include "sinew/base/check.h"

namespace sinew {

MovableTree::MovableTree(const Tree& tree, const FrameBoxes& frames)
    : root_(Tree::kRoot),
      frame_count_(frames.frame_count()),
      nodes_(tree.nodes.size()),
      boxes_(tree.nodes.size() * frames.frame_count()) {
  SINEW_CHECK(!tree.empty() && frame_count_ > 0);
  SINEW_CHECK(tree.primitives.size() == frames.primitive_count());
  for (uint32_t n = 0; n < nodes_.size(); ++n) {
    const TreeNode& node = tree.nodes[n];
    if (node.is_leaf()) {
      SINEW_CHECK(node.count() == 1);
      nodes_[n].child[1] = tree.primitives[node.first()];
      continue;
    }
    nodes_[n].child = {node.left(), node.right()};
    for (const uint32_t c : nodes_[n].child) nodes_[c].parent = n;
  }
  for (uint32_t f = 0; f < frame_count_; ++f) {
    const Bounds bounds = refit(tree, frames.frames[f]);
    for (size_t n = 0; n < bounds.size(); ++n) boxes_[n * frame_count_ + f] = bounds[n];
  }
}

uint32_t MovableTree::sibling(uint32_t node) const {
  const Node& parent = nodes_[nodes_[node].parent];
  return parent.child[parent.child[0] == node ? 1 : 0];
}

void MovableTree::replace_child(uint32_t parent, uint32_t old_child, uint32_t new_child) {
  nodes_[new_child].parent = parent;
  if (parent == kNone) {
    root_ = new_child;
  } else {
    Node& node = nodes_[parent];
    node.child[node.child[0] == old_child ? 0 : 1] = new_child;
  }
}

// Whether a box changed.
bool MovableTree::fit(uint32_t node) {
  Box* const own = boxes_.data() + size_t{node} * frame_count_;
  const Box* const a = boxes_.data() + size_t{nodes_[node].child[0]} * frame_count_;
  const Box* const b = boxes_.data() + size_t{nodes_[node].child[1]} * frame_count_;
  bool changed = false;
  for (uint32_t f = 0; f < frame_count_; ++f) {
    Box box = a[f];
    box.extend(b[f]);
    changed |= box.min != own[f].min || box.max != own[f].max;
    own[f] = box;
  }
  return changed;
}

void MovableTree::fit_upwards(uint32_t node) {
  while (node != kNone && fit(node)) node = nodes_[node].parent;
}

uint32_t MovableTree::remove(uint32_t node) {
  SINEW_DCHECK(node != root_);
  const uint32_t parent = nodes_[node].parent;
  const uint32_t other = sibling(node);
  replace_child(nodes_[parent].parent, parent, other);
  fit_upwards(nodes_[other].parent);
  return parent;
}

void MovableTree::insert(uint32_t node, uint32_t at, uint32_t link) {
  replace_child(nodes_[at].parent, at, link);
  nodes_[link].child = {at, node};
  nodes_[at].parent = link;
  nodes_[node].parent = link;
  fit(link);
  fit_upwards(nodes_[link].parent);
}

std::vector<double> MovableTree::costs(const CostModel& model) const {
  std::vector<double> sums(frame_count_, 0.0);
  for (uint32_t n = 0; n < nodes_.size(); ++n) {
    const double weight = is_leaf(n) ? model.intersection : model.traversal;
    const std::span<const Box> own = boxes(n);
    for (uint32_t f = 0; f < frame_count_; ++f) sums[f] += weight * exact_half_area(own[f]);
  }
  for (uint32_t f = 0; f < frame_count_; ++f) {
    const double area = exact_half_area(boxes(root_)[f]);
    sums[f] = area > 0.0 ? sums[f] / area : 0.0;
  }
  return sums;
}

Tree MovableTree::to_tree(const State& state) {
  struct Pending {
    uint32_t from, parent;
    bool right;
  };
  Tree tree;
  tree.nodes.reserve(state.nodes.size());
  tree.primitives.reserve(state.nodes.size() / 2 + 1);
  std::vector<Pending> stack = {{state.root, 0, false}};
  while (!stack.empty()) {
    const Pending item = stack.back();
    stack.pop_back();
    const auto node = static_cast<uint32_t>(tree.nodes.size());
    if (node > 0) (item.right ? tree.nodes[item.parent].b : tree.nodes[item.parent].a) = node;
    const Node& from = state.nodes[item.from];
    if (from.child[0] == kNone) {
      tree.nodes.push_back(TreeNode::leaf(static_cast<uint32_t>(tree.primitives.size()), 1));
      tree.primitives.push_back(from.child[1]);
      continue;
    }
    tree.nodes.push_back(TreeNode::inner(0, 0));
    stack.push_back({from.child[1], node, true});
    stack.push_back({from.child[0], node, false});
  }
  return tree;
}

}  // namespace sinew
