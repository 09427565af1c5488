#include "sinew/bvh/builders/derived_upper.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/bvh/wide.h"
#include "sinew/motion/clusters.h"

namespace sinew {
namespace {

// The nodes where treelets begin, and the tree above them, whose primitives they are.
struct Cut {
  std::vector<uint32_t> roots;  // nodes of the whole tree
  Tree upper;
};

std::vector<uint32_t> triangles_below(const Tree& tree) {
  std::vector<uint32_t> counts(tree.nodes.size(), 0);
  for (size_t n = tree.nodes.size(); n-- > 0;) {  // children stand after their parents
    const TreeNode& node = tree.nodes[n];
    counts[n] = node.is_leaf() ? node.count() : counts[node.left()] + counts[node.right()];
  }
  return counts;
}

// Copies the nodes of `from` at and below `root` to the end of `to`, depth first. Those that
// ends(node) says are left to end(node), which appends what stands in their place.
template <class Ends, class End>
void copy_tree(const Tree& from, uint32_t root, Tree& to, const Ends& ends, const End& end) {
  struct Pending {
    uint32_t node, parent;
    bool right;
  };
  const auto top = static_cast<uint32_t>(to.nodes.size());
  std::vector<Pending> stack = {{root, 0, false}};
  while (!stack.empty()) {
    const Pending item = stack.back();
    stack.pop_back();
    const auto place = static_cast<uint32_t>(to.nodes.size());
    if (place > top) (item.right ? to.nodes[item.parent].b : to.nodes[item.parent].a) = place;
    if (ends(item.node)) {
      end(item.node);
      continue;
    }
    const TreeNode& node = from.nodes[item.node];
    to.nodes.push_back(node);
    stack.push_back({node.right(), place, true});
    stack.push_back({node.left(), place, false});
  }
}

Cut cut_at_treelets(const Tree& tree) {
  const std::vector<uint32_t> counts = triangles_below(tree);
  Cut cut;
  copy_tree(
      tree, Tree::kRoot, cut.upper,
      [&](uint32_t node) {
        return tree.nodes[node].is_leaf() || counts[node] <= kTreeletTriangles;
      },
      [&](uint32_t node) {
        const auto treelet = static_cast<uint32_t>(cut.roots.size());
        cut.upper.nodes.push_back(TreeNode::leaf(treelet, 1));
        cut.upper.primitives.push_back(treelet);
        cut.roots.push_back(node);
      });
  return cut;
}

// The vertices of the triangles below a node, each once.
std::vector<uint32_t> vertices_below(const Tree& tree, uint32_t root,
                                     std::span<const uvec3> triangles) {
  std::vector<uint32_t> vertices, stack = {root};
  while (!stack.empty()) {
    const TreeNode& node = tree.nodes[stack.back()];
    stack.pop_back();
    if (!node.is_leaf()) {
      stack.insert(stack.end(), {node.right(), node.left()});
      continue;
    }
    for (uint32_t i = 0; i < node.count(); ++i) {
      const uvec3 t = triangles[tree.primitives[node.first() + i]];
      vertices.insert(vertices.end(), {t.x, t.y, t.z});
    }
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

FrameBoxes derived_frames(const Tree& tree, std::span<const uint32_t> roots, const Motion& motion,
                          std::span<const uvec3> triangles, std::span<const Pose> poses,
                          std::span<const double> weights) {
  std::vector<uint32_t> first = {0}, vertices;
  for (const uint32_t root : roots) {
    const std::vector<uint32_t> own = vertices_below(tree, root, triangles);
    vertices.insert(vertices.end(), own.begin(), own.end());
    first.push_back(static_cast<uint32_t>(vertices.size()));
  }
  const ClusterBounds clusters = make_cluster_bounds(motion, {first, vertices});
  std::vector<std::vector<Box>> frames(poses.size(), std::vector<Box>(roots.size()));
  for (size_t f = 0; f < poses.size(); ++f) {
    derive_bounds(clusters, motion, poses[f], 0, frames[f]);
  }
  FrameBoxes out = make_frame_boxes(std::move(frames));
  out.weights.assign(weights.begin(), weights.end());
  return out;
}

// The upper tree with the old subtrees in place of its leaves.
Tree graft(const Tree& upper, const Tree& tree, std::span<const uint32_t> roots) {
  Tree out;
  const auto add_leaf = [&](uint32_t n) {
    const TreeNode& leaf = tree.nodes[n];
    const auto begin = tree.primitives.begin() + leaf.first();
    out.nodes.push_back(TreeNode::leaf(static_cast<uint32_t>(out.primitives.size()), leaf.count()));
    out.primitives.insert(out.primitives.end(), begin, begin + leaf.count());
  };
  const auto add_subtree = [&](uint32_t n) {
    const uint32_t root = roots[upper.primitives[upper.nodes[n].first()]];
    copy_tree(
        tree, root, out, [&](uint32_t node) { return tree.nodes[node].is_leaf(); }, add_leaf);
  };
  copy_tree(
      upper, Tree::kRoot, out, [&](uint32_t node) { return upper.nodes[node].is_leaf(); },
      add_subtree);
  return out;
}

}  // namespace

Tree suit_derived_boxes(const Tree& tree, const Motion& motion, std::span<const uvec3> triangles,
                        std::span<const Pose> poses, std::span<const double> weights,
                        const OptimizeConfig& config) {
  SINEW_CHECK(derivable(motion) && poses.size() == weights.size());
  if (tree.empty() || poses.empty()) return tree;
  const Cut cut = cut_at_treelets(tree);
  if (cut.roots.size() < 3) return tree;  // nothing can change places
  const FrameBoxes frames = derived_frames(tree, cut.roots, motion, triangles, poses, weights);
  return graft(optimize(cut.upper, frames, config), tree, cut.roots);
}

}  // namespace sinew
