#include "sinew/bvh/tree.h"

namespace sinew {
namespace {

std::string at_node(uint32_t node, const char* problem) {
  return "node " + std::to_string(node) + " " + problem;
}

// What is wrong with a leaf; marks its primitives in `seen`.
const char* check_leaf(const Tree& tree, const TreeNode& leaf, std::vector<bool>& seen) {
  const size_t count = tree.primitives.size();
  if (leaf.count() == 0) return "is a leaf without primitives";
  if (leaf.first() > count || leaf.count() > count - leaf.first()) {
    return "is a leaf beyond the primitives";
  }
  for (uint32_t i = 0; i < leaf.count(); ++i) {
    const uint32_t primitive = tree.primitives[leaf.first() + i];
    if (primitive >= count) return "holds a primitive that does not exist";
    if (seen[primitive]) return "holds a primitive that another leaf has";
    seen[primitive] = true;
  }
  return nullptr;
}

}  // namespace

std::string validate(const Tree& tree, uint32_t primitive_count) {
  if (tree.primitives.size() != primitive_count) {
    return "it has " + std::to_string(tree.primitives.size()) + " primitives, not " +
           std::to_string(primitive_count);
  }
  if (primitive_count == 0) return tree.empty() ? "" : "it has nodes, but no primitives";
  if (tree.empty()) return "it has no nodes";
  std::vector<bool> seen(primitive_count, false), has_parent(tree.nodes.size(), false);
  const auto count = static_cast<uint32_t>(tree.nodes.size());
  size_t held = 0;
  for (uint32_t n = 0; n < count; ++n) {
    const TreeNode& node = tree.nodes[n];
    if (n != Tree::kRoot && !has_parent[n]) return at_node(n, "has no parent before it");
    if (node.is_leaf()) {
      if (const char* problem = check_leaf(tree, node, seen)) return at_node(n, problem);
      held += node.count();
      continue;
    }
    for (const uint32_t child : {node.left(), node.right()}) {
      if (child >= count) return at_node(n, "has a child that does not exist");
      if (child <= n) return at_node(n, "has a child that stands before it");
      if (has_parent[child]) return at_node(child, "has two parents");
      has_parent[child] = true;
    }
  }
  return held == primitive_count ? "" : "some primitives are in no leaf";
}

}  // namespace sinew
