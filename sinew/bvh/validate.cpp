// Checks every invariant of the traced layout; run after each pass in tests and debug builds.
#include <string>

#include "sinew/bvh/update/visit.h"
#include "sinew/bvh/wide.h"

namespace sinew {
namespace {

class Validator {
 public:
  Validator(const Bvh8Layout& layout, const Bvh8& bvh, std::span<const vec3> positions,
            std::span<const uvec3> triangles)
      : layout_(layout), bvh_(bvh), positions_(positions), triangles_(triangles) {}

  std::string run() {
    if (positions_.size() != layout_.vertex_count) return "vertex counts differ";
    if (triangles_.size() != layout_.triangle_count) return "triangle counts differ";
    if (bvh_.nodes.size() != layout_.children.size()) return "node counts differ";
    if (!bvh_.by_links && bvh_.packets.size() != layout_.packet_corners.size()) {
      return "packet counts differ";
    }
    seen_nodes_.assign(bvh_.nodes.size(), 0);
    seen_packets_.assign(layout_.packet_corners.size(), 0);
    seen_primitives_.assign(triangles_.size(), 0);
    check_treelets();
    if (!problem_.empty()) return problem_;
    if (bvh_.root == kNoChild) {
      if (!triangles_.empty()) problem_ = "there are triangles, but no root";
    } else {
      walk(bvh_.root, bvh_.box, 1);
    }
    for (size_t i = 0; i < seen_primitives_.size(); ++i) {
      if (!seen_primitives_[i]) report("triangle " + std::to_string(i) + " is in no leaf");
    }
    return problem_;
  }

 private:
  void report(const std::string& problem) {
    if (problem_.empty()) problem_ = problem;
  }

  void walk(uint32_t word, const Box& outer, uint32_t depth) {
    if (!problem_.empty()) return;
    if (depth > kMaxDepth) return report("deeper than kMaxDepth");
    if (is_leaf_word(word)) return check_leaf(word, outer);
    if (is_treelet_word(word)) return walk_link(treelet_of(word), outer, depth);
    if (word >= bvh_.nodes.size()) return report("a child word is out of range");
    if (seen_nodes_[word]++) return report("node " + std::to_string(word) + " has two parents");
    const Node8& node = bvh_.nodes[word];
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      const Box box = lane_box(node, lane);
      if (node.child[lane] == kNoChild) {
        if (!box.empty()) report("an absent child has a box");
        continue;
      }
      if (lane > 0 && node.child[lane - 1] == kNoChild) report("absent children must stand last");
      if (!outer.contains(box)) report("node " + std::to_string(word) + " leaves its parent's box");
      walk(node.child[lane], box, depth + 1);
    }
  }

  // A treelet that no ray came to has nothing that could be checked but that it stands aside.
  void walk_link(uint32_t treelet, const Box& outer, uint32_t depth) {
    if (treelet >= bvh_.links.size()) return report("a treelet word is out of range");
    const uint32_t made = bvh_.links[treelet];
    if (made == kBeingMade) return report("treelet " + std::to_string(treelet) + " is half made");
    if (made != kUnmade) return walk(made, outer, depth);
    const Treelet& t = layout_.treelets[treelet];
    for (uint32_t p = t.first_packet; p < t.first_packet + t.packet_count; ++p) {
      if (seen_packets_[p]++) report("packet " + std::to_string(p) + " is in two leaves");
      for (uint32_t lane = 0; lane < kPacket; ++lane) check_unmade_lane(t, p, lane, outer);
    }
  }

  void check_unmade_lane(const Treelet& treelet, uint32_t p, uint32_t lane, const Box& outer) {
    const uint32_t primitive = layout_.packet_primitives[p][lane];
    if (primitive == kNoPrimitive) return;
    if (primitive >= triangles_.size()) return report("a primitive is out of range");
    if (seen_primitives_[primitive]++) {
      return report("triangle " + std::to_string(primitive) + " is in two places");
    }
    for (int corner = 0; corner < 3; ++corner) {
      const uint8_t number = layout_.packet_corners[p].v[lane][corner];
      const uint32_t vertex = layout_.vertices[treelet.first_vertex + number];
      if (vertex != triangles_[primitive][corner]) return report("a packet's vertices are wrong");
      if (!outer.contains(positions_[vertex])) {
        return report("vertex " + std::to_string(vertex) + " leaves the box of its treelet");
      }
    }
  }

  void check_leaf(uint32_t word, const Box& box) {
    const uint32_t first = leaf_first(word), count = leaf_packets(word);
    if (size_t{first} + count > layout_.packet_corners.size())
      return report("a leaf is out of range");
    for (uint32_t p = first; p < first + count; ++p) {
      if (seen_packets_[p]++) report("packet " + std::to_string(p) + " is in two leaves");
      for (uint32_t lane = 0; lane < kPacket; ++lane) check_lane(p, lane, box);
    }
  }

  vec3 corner_of(uint32_t p, uint32_t lane, int corner) const {
    if (bvh_.by_links) {
      const PacketCorners& corners = layout_.packet_corners[p];
      return bvh_.vertices[corners.place + corners.v[lane][corner]];
    }
    const auto& v = bvh_.packets[p].v[corner];
    return vec3(v[0][lane], v[1][lane], v[2][lane]);
  }

  void check_lane(uint32_t p, uint32_t lane, const Box& box) {
    const uint32_t primitive = layout_.packet_primitives[p][lane];
    if (primitive == kNoPrimitive) {
      if (lane == 0) report("packet " + std::to_string(p) + " is empty");
      return;
    }
    if (primitive >= triangles_.size()) return report("a primitive is out of range");
    if (seen_primitives_[primitive]++) {
      return report("triangle " + std::to_string(primitive) + " is in two places");
    }
    for (int corner = 0; corner < 3; ++corner) {
      const uint8_t number = layout_.packet_corners[p].v[lane][corner];
      const uint32_t vertex = layout_.vertices[treelet_of_packet_[p]->first_vertex + number];
      if (vertex != triangles_[primitive][corner]) return report("a packet's vertices are wrong");
      const vec3 at = positions_[vertex];
      const vec3 packed = corner_of(p, lane, corner);
      if (packed != at) {
        return report("triangle " + std::to_string(primitive) + " is stale: its packed vertex " +
                      std::to_string(vertex) + " is not where the body has it");
      }
      if (!box.contains(at)) {
        return report("triangle " + std::to_string(primitive) + " leaves its leaf's box");
      }
    }
  }

  void check_treelets() {
    treelet_of_packet_.assign(layout_.packet_corners.size(), nullptr);
    for (size_t t = 0; t < layout_.treelets.size(); ++t) {
      const Treelet& treelet = layout_.treelets[t];
      if (treelet.first_node + treelet.node_count > bvh_.nodes.size() ||
          treelet.first_packet + treelet.packet_count > layout_.packet_corners.size() ||
          treelet.packet_count == 0 ||
          treelet.first_vertex + treelet.vertex_count > layout_.vertices.size()) {
        return report("treelet " + std::to_string(t) + " is out of range");
      }
      for (uint32_t p = 0; p < treelet.packet_count; ++p) {
        treelet_of_packet_[treelet.first_packet + p] = &treelet;
      }
      if (layout_.upper_nodes > 0 && layout_.children[treelet.parent_node][treelet.parent_lane] !=
                                         treelet_word(static_cast<uint32_t>(t))) {
        return report("treelet " + std::to_string(t) + " is not where its parent has it");
      }
    }
  }

  const Bvh8Layout& layout_;
  const Bvh8& bvh_;
  std::span<const vec3> positions_;
  std::span<const uvec3> triangles_;
  std::vector<const Treelet*> treelet_of_packet_;
  std::vector<uint8_t> seen_nodes_, seen_packets_, seen_primitives_;
  std::string problem_;
};

}  // namespace

std::string validate(const Bvh8Layout& layout, const Bvh8& bvh, std::span<const vec3> positions,
                     std::span<const uvec3> triangles) {
  return Validator(layout, bvh, positions, triangles).run();
}

}  // namespace sinew
