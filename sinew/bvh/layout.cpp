// Collapses a binary tree into eight-wide nodes (collapse.h) and cuts it into treelets: where few
// triangles are left, the subtree is stored apart and linked by a word.
#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/bvh/builders/collapse.h"
#include "sinew/bvh/wide.h"

namespace sinew {
namespace {

class LayoutMaker {
 public:
  LayoutMaker(const Tree& tree, std::span<const float> areas, std::span<const uvec3> triangles,
              uint32_t treelet_triangles)
      : tree_(tree),
        areas_(areas),
        triangles_(triangles),
        limit_(treelet_triangles),
        collapse_(tree) {
    measure_subtrees();
  }

  Result<Bvh8Layout> run(uint32_t vertex_count) {
    layout_.vertex_count = vertex_count;
    number_.assign(vertex_count, kUnnumbered);
    layout_.triangle_count = static_cast<uint32_t>(triangles_.size());
    if (tree_.empty()) return std::move(layout_);
    make_upper();
    for (Treelet& treelet : layout_.treelets) make_treelet(treelet);
    if (layout_.depth > kMaxDepth) {
      return fail({ErrorKind::bad_input, "", "", "the tree is too deep to be traced",
                   "build it with build_binned or build_sweep"});
    }
    if (layout_.packet_corners.size() >= kMaxPackets) {
      return fail({ErrorKind::bad_input, "", "", "the mesh has too many triangles",
                   "split it into several objects"});
    }
    return std::move(layout_);
  }

 private:
  struct Task {
    uint32_t tree_node;
    uint32_t wide_node;
    uint32_t depth;
  };
  using Children = std::array<uint32_t, kWidth>;

  // Triangles below every node, what a ray that enters it pays, and how it collapses. A stack,
  // because trees may be deep.
  void measure_subtrees() {
    counts_.assign(tree_.nodes.size(), 0);
    costs_.assign(tree_.nodes.size(), 0.0f);
    std::vector<std::pair<uint32_t, bool>> stack;
    if (!tree_.empty()) stack.emplace_back(Tree::kRoot, false);
    while (!stack.empty()) {
      const auto [node, children_done] = stack.back();
      stack.pop_back();
      const TreeNode& n = tree_.nodes[node];
      if (n.is_leaf()) {
        counts_[node] = n.count();
        costs_[node] = build_.intersection_cost * float((n.count() + kPacket - 1) / kPacket);
        collapse_.add_leaf(node);
      } else if (children_done) {
        counts_[node] = counts_[n.left()] + counts_[n.right()];
        costs_[node] = build_.traversal_cost + entered(node, n.left()) + entered(node, n.right());
        if (!is_treelet(node)) {
          for (const uint32_t child : {n.left(), n.right()}) {
            if (is_treelet(child)) collapse_.close(child);
          }
        }
        collapse_.add_inner(node, share_of(Tree::kRoot, node));
      } else {
        stack.emplace_back(node, true);
        stack.emplace_back(n.left(), false);
        stack.emplace_back(n.right(), false);
      }
    }
  }

  // How many of the rays that enter a node's box enter another within: a number from 0 to 1 even
  // where areas make no sense.
  float share_of(uint32_t outer, uint32_t inner) const {
    const float share = areas_[inner] / areas_[outer];
    return share < 1.0f ? std::max(share, 0.0f) : 1.0f;
  }
  float entered(uint32_t parent, uint32_t child) const {
    return share_of(parent, child) * costs_[child];
  }

  // Any-hit rays take the last lane first, and most of them hit something. So what is soon done
  // stands last: a wall before the furniture.
  WideChildren children_of(uint32_t node) const {
    WideChildren children = collapse_.children_of(node);
    std::stable_sort(children.node.begin(), children.node.begin() + children.count,
                     [&](uint32_t a, uint32_t b) { return costs_[a] > costs_[b]; });
    return children;
  }

  bool is_leaf(uint32_t node) const { return tree_.nodes[node].is_leaf(); }
  bool is_treelet(uint32_t node) const { return is_leaf(node) || counts_[node] <= limit_; }

  uint32_t new_node() {
    Children none;
    none.fill(kNoChild);
    layout_.children.push_back(none);
    return static_cast<uint32_t>(layout_.children.size() - 1);
  }

  void make_upper() {
    if (is_treelet(Tree::kRoot)) {
      layout_.treelets.push_back({});
      treelet_roots_ = {{Tree::kRoot, 0, 1}};
      return;
    }
    std::vector<Task> queue = {{Tree::kRoot, new_node(), 1}};
    for (size_t next = 0; next < queue.size(); ++next) {  // breadth first: parents before children
      const Task task = queue[next];
      const WideChildren children = children_of(task.tree_node);
      for (uint32_t lane = 0; lane < children.count; ++lane) {
        uint32_t word;
        if (is_treelet(children.node[lane])) {
          const auto treelet = static_cast<uint32_t>(layout_.treelets.size());
          word = treelet_word(treelet);
          layout_.treelets.push_back({.parent_node = task.wide_node, .parent_lane = lane});
          treelet_roots_.push_back({children.node[lane], 0, task.depth + 1});
        } else {
          word = inner_word(new_node());
          queue.push_back({children.node[lane], word, task.depth + 1});
        }
        layout_.children[task.wide_node][lane] = word;
      }
    }
    layout_.upper_nodes = static_cast<uint32_t>(layout_.children.size());
  }

  void make_treelet(Treelet& treelet) {
    const auto index = static_cast<uint32_t>(&treelet - layout_.treelets.data());
    const Task root = treelet_roots_[index];
    treelet.first_node = static_cast<uint32_t>(layout_.children.size());
    treelet.first_packet = static_cast<uint32_t>(layout_.packet_corners.size());
    treelet.first_vertex = static_cast<uint32_t>(layout_.vertices.size());
    if (is_leaf(root.tree_node)) {
      add_leaf(root.tree_node, index);
      layout_.depth = std::max(layout_.depth, root.depth);
    } else {
      std::vector<Task> queue = {{root.tree_node, new_node(), root.depth}};
      for (size_t next = 0; next < queue.size(); ++next) {
        const Task task = queue[next];
        layout_.depth = std::max(layout_.depth, task.depth + 1);
        const WideChildren children = children_of(task.tree_node);
        for (uint32_t lane = 0; lane < children.count; ++lane) {
          uint32_t word;
          if (is_leaf(children.node[lane])) {
            word = add_leaf(children.node[lane], index);
          } else {
            word = inner_word(new_node());
            queue.push_back({children.node[lane], word, task.depth + 1});
          }
          layout_.children[task.wide_node][lane] = word;
        }
      }
    }
    treelet.node_count = static_cast<uint32_t>(layout_.children.size()) - treelet.first_node;
    treelet.packet_count =
        static_cast<uint32_t>(layout_.packet_corners.size()) - treelet.first_packet;
    treelet.vertex_count = static_cast<uint32_t>(layout_.vertices.size()) - treelet.first_vertex;
    sort_vertices(treelet);
  }

  // Puts the treelet's vertices in the order of the body's, for the sake of memory accesses.
  void sort_vertices(const Treelet& treelet) {
    const auto first = layout_.vertices.begin() + treelet.first_vertex;
    const std::vector<uint32_t> before(first, layout_.vertices.end());
    std::sort(first, layout_.vertices.end());
    for (uint32_t i = 0; i < treelet.vertex_count; ++i) number_[first[i]] = static_cast<uint8_t>(i);
    for (uint32_t p = 0; p < treelet.packet_count; ++p) {
      for (auto& lane : layout_.packet_corners[treelet.first_packet + p].v) {
        for (uint8_t& corner : lane) corner = number_[before[corner]];
      }
    }
    for (const uint32_t vertex : before) number_[vertex] = kUnnumbered;
  }

  // The vertex's place among those of the treelet being made.
  uint8_t number(uint32_t vertex, uint32_t first_vertex) {
    if (number_[vertex] == kUnnumbered) {
      number_[vertex] = static_cast<uint8_t>(layout_.vertices.size() - first_vertex);
      layout_.vertices.push_back(vertex);
    }
    return number_[vertex];
  }

  uint32_t add_leaf(uint32_t node, uint32_t treelet) {
    const uint32_t first_vertex = layout_.treelets[treelet].first_vertex;
    const TreeNode& leaf = tree_.nodes[node];
    const auto first = static_cast<uint32_t>(layout_.packet_corners.size());
    for (uint32_t i = 0; i < leaf.count(); i += kPacket) {
      PacketCorners corners;
      corners.place = place_of(layout_, treelet);
      PacketPrimitives primitives;
      for (uint32_t lane = 0; lane < kPacket; ++lane) {
        const bool used = i + lane < leaf.count();
        const uint32_t primitive = tree_.primitives[leaf.first() + i + (used ? lane : 0)];
        primitives[lane] = used ? primitive : kNoPrimitive;
        for (int k = 0; k < 3; ++k) {
          corners.v[lane][k] = number(triangles_[primitive][k], first_vertex);
        }
      }
      layout_.packet_corners.push_back(corners);
      layout_.packet_primitives.push_back(primitives);
    }
    return leaf_word(first, static_cast<uint32_t>(layout_.packet_corners.size()) - first);
  }

  const Tree& tree_;
  std::span<const float> areas_;
  std::span<const uvec3> triangles_;
  uint32_t limit_;
  static constexpr BuildConfig build_{};
  std::vector<uint32_t> counts_;
  std::vector<float> costs_;
  WideCollapse collapse_;
  std::vector<Task> treelet_roots_;  // one a treelet; wide_node unused
  static constexpr uint8_t kUnnumbered = 255;
  std::vector<uint8_t> number_;  // of every vertex, within the treelet being made
  Bvh8Layout layout_;
};

}  // namespace

Node8 empty_node() {
  Node8 node = {};
  for (uint32_t lane = 0; lane < kWidth; ++lane) {
    set_lane_box(node, lane, Box());
    node.child[lane] = kNoChild;
  }
  return node;
}

Box node_box(const Node8& node) {
  Box box;
  for (uint32_t lane = 0; lane < kWidth; ++lane) box.extend(lane_box(node, lane));
  return box;
}

size_t bytes_of(const Bvh8Layout& layout) {
  const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
  return bytes(layout.children) + bytes(layout.packet_corners) + bytes(layout.packet_primitives) +
         bytes(layout.treelets) + bytes(layout.vertices);
}

size_t bytes_of(const Bvh8& bvh) {
  return bvh.nodes.size() * sizeof(Node8) + bvh.packets.size() * sizeof(TrianglePacket) +
         bvh.vertices.size() * sizeof(vec3) + bvh.links.size() * sizeof(uint32_t);
}

Result<Bvh8Layout> make_layout(const Tree& tree, std::span<const float> areas,
                               std::span<const uvec3> triangles, uint32_t vertex_count,
                               uint32_t treelet_triangles) {
  SINEW_CHECK(areas.size() == tree.nodes.size());
  SINEW_CHECK(treelet_triangles > 0 && treelet_triangles <= kMaxTreeletTriangles);
  for (const TreeNode& node : tree.nodes) {
    if (node.is_leaf() && node.count() > kPacket * kMaxLeafPackets) {
      return fail({ErrorKind::bad_input, "", "", "a leaf of the tree holds too many triangles",
                   "build with max_leaf of at most 32"});
    }
  }
  return LayoutMaker(tree, areas, triangles, treelet_triangles).run(vertex_count);
}

Result<void> check_triangles(std::span<const uvec3> triangles, size_t vertex_count) {
  for (size_t i = 0; i < triangles.size(); ++i) {
    const uvec3 t = triangles[i];
    if (t.x >= vertex_count || t.y >= vertex_count || t.z >= vertex_count) {
      return fail({ErrorKind::bad_input, "", "triangle " + std::to_string(i),
                   "it refers to a vertex that does not exist", "check the index list"});
    }
  }
  return {};
}

Result<Bvh8Layout> build_layout(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                const BuildConfig& config) {
  SINEW_CHECKED(check_triangles(triangles, positions.size()));
  std::vector<Box> boxes(triangles.size());
  triangle_boxes(positions, triangles, boxes);
  for (Box& box : boxes) {
    if (!is_finite(box)) box = {vec3(0.0f), vec3(0.0f)};
  }
  const Tree tree = build_binned(boxes, config);
  return make_layout(tree, half_areas(refit(tree, boxes)), triangles,
                     static_cast<uint32_t>(positions.size()));
}

}  // namespace sinew
