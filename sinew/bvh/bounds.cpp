#include "sinew/bvh/bounds.h"

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/cost.h"

namespace sinew {
namespace {

// So it is in all trees that builders make; editing may change it.
bool parents_come_first(const Tree& tree) {
  for (size_t node = 0; node < tree.nodes.size(); ++node) {
    const TreeNode& n = tree.nodes[node];
    if (!n.is_leaf() && (n.left() < node || n.right() < node)) return false;
  }
  return true;
}

}  // namespace

void triangle_boxes(std::span<const vec3> positions, std::span<const uvec3> triangles,
                    std::span<Box> out) {
  SINEW_CHECK(out.size() == triangles.size());
  parallel_for(triangles.size(), 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Box box;
      for (int k = 0; k < 3; ++k) box.extend(positions[triangles[i][k]]);
      out[i] = box;
    }
  });
}

Bounds refit(const Tree& tree, std::span<const Box> primitive_boxes) {
  Bounds bounds(tree.nodes.size());
  const auto set_leaf = [&](size_t node) {
    const TreeNode& n = tree.nodes[node];
    for (uint32_t i = 0; i < n.count(); ++i) {
      bounds[node].extend(primitive_boxes[tree.primitives[n.first() + i]]);
    }
  };
  const auto set_inner = [&](size_t node) {
    const TreeNode& n = tree.nodes[node];
    bounds[node] = bounds[n.left()];
    bounds[node].extend(bounds[n.right()]);
  };
  if (parents_come_first(tree)) {
    for (size_t node = tree.nodes.size(); node-- > 0;) {
      tree.nodes[node].is_leaf() ? set_leaf(node) : set_inner(node);
    }
    return bounds;
  }
  // Depth first, children before their parent: the second visit of a node finds both boxes done.
  std::vector<std::pair<uint32_t, bool>> stack = {{Tree::kRoot, false}};
  while (!stack.empty()) {
    const auto [node, children_done] = stack.back();
    stack.pop_back();
    const TreeNode& n = tree.nodes[node];
    if (n.is_leaf()) {
      set_leaf(node);
    } else if (children_done) {
      set_inner(node);
    } else {
      stack.emplace_back(node, true);
      stack.emplace_back(n.left(), false);
      stack.emplace_back(n.right(), false);
    }
  }
  return bounds;
}

std::vector<float> half_areas(const Bounds& bounds) {
  std::vector<float> areas(bounds.size());
  for (size_t i = 0; i < bounds.size(); ++i) areas[i] = half_area(bounds[i]);
  return areas;
}

double sah_cost(const Tree& tree, const Bounds& bounds, const CostModel& model) {
  if (tree.empty()) return 0.0;
  const double root = exact_half_area(bounds[Tree::kRoot]);
  if (!(root > 0.0)) return 0.0;
  double sum = 0.0;
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const TreeNode& node = tree.nodes[i];
    const double weight =
        node.is_leaf() ? double(model.intersection) * node.count() : double(model.traversal);
    sum += weight * exact_half_area(bounds[i]);
  }
  return sum / root;
}

double upper_cost(const Bvh8Layout& layout, const Bvh8& bvh, const CostModel& model) {
  const double root = half_area(bvh.box);
  if (layout.upper_nodes == 0 || !(root > 0.0)) return 0.0;
  double sum = double(model.traversal) * root;
  for (uint32_t n = 0; n < layout.upper_nodes; ++n) {
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const uint32_t word = layout.children[n][lane];
      if (word == kNoChild) break;  // absent children stand last
      const double weight = is_inner_word(word)
                                ? double(model.traversal)
                                : double(model.intersection) * kPacket *
                                      layout.treelets[treelet_of(word)].packet_count;
      sum += weight * half_area(lane_box(bvh.nodes[n], lane));
    }
  }
  return sum / root;
}

}  // namespace sinew
