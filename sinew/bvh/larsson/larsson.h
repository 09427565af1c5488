// L as published, the opponent: an octary tree with one triangle a leaf in one depth-first array,
// whose lower half is left outdated by an update and made where rays come, and its traversal.
// Based on: T. Larsson, T. Akenine-Moller, "Strategies for Bounding Volume Hierarchy Updates for
// Ray Tracing of Deformable Models", 2003, section 3; B. Smits, "Efficiency Issues for Ray
// Tracing", journal of graphics tools 3(2), 1998 (skip indices). Scalar, and for one thread:
// queries write. Differs in that slabs are widened by their rounding (T. Ize, "Robust BVH Ray
// Traversal", 2013).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/math/ray.h"

namespace sinew::larsson {

// How an outdated node's box is made when a ray reaches it.
enum class FirstVisit : uint8_t {
  node,     // of this node alone, from the points below it ("top-down", what L found best)
  levels,   // of this node and the next q levels: the lowest from their points, the others merged
  subtree,  // of everything below it, bottom-up
};

struct Config {
  FirstVisit first_visit = FirstVisit::node;
  uint32_t visit_levels = 2;        // q of FirstVisit::levels, 1 to 16
  std::optional<uint32_t> depth{};  // d, where a hybrid update begins; none: half the height
};

// The link of a leaf needs no skip index: behind a leaf comes the next node.
struct Node {
  static constexpr uint32_t kLeaf = 0x80000000u;
  Box box;
  uint32_t link = 0;          // inner: the node behind its subtree; leaf: kLeaf | its number
  uint32_t last_updated = 0;  // the frame whose box this is

  bool is_leaf() const { return (link & kLeaf) != 0; }
  uint32_t leaf() const { return link & ~kLeaf; }  // leaves are numbered from the left
  uint32_t skip(uint32_t self) const { return is_leaf() ? self + 1 : link; }
};
static_assert(sizeof(Node) == 32);

// What updates touch: the terms of L's equation 7.
struct UpdateWork {
  uint64_t vertices = 0;  // read to make boxes from points
  uint64_t boxes = 0;     // written
};

// A ray with what every box test needs of it.
struct Probe {
  explicit Probe(const Ray& r) : ray(r), inverse(1.0f / r.direction) {}
  Ray ray;
  vec3 inverse;
};

// One body. Views the positions of its last update until the next.
class Hierarchy {
 public:
  // The tree is built for these positions, which it then also has. Triangles index positions.
  Hierarchy(std::span<const vec3> positions, std::span<const uvec3> triangles,
            const Config& config = {});

  // All boxes, from the leaves to the root.
  void update_bottom_up(std::span<const vec3> positions);
  // The boxes at depth d (and of leaves above) from their points, those above bottom-up. All
  // others are outdated until a query reaches them.
  void update_hybrid(std::span<const vec3> positions);

  // Replaces `hit` by the closest hit before it, which it calls `object`. The triangle test is
  // Moller's and Trumbore's, in float: not watertight.
  void closest_hit(const Probe& probe, uint32_t object, Hit& hit);
  bool any_hit(const Probe& probe);

  Box box() const { return nodes_.empty() ? Box() : nodes_[0].box; }  // current after every update
  std::span<const Node> nodes() const { return nodes_; }
  uint32_t height() const { return height_; }  // edges from the root to the deepest leaf
  uint32_t depth() const { return depth_; }    // d

  UpdateWork bottom_up_work() const;
  UpdateWork hybrid_work() const;
  UpdateWork visit_work() const { return visited_; }  // by queries since the last update

  // The order of the nodes, each triangle in one leaf, and that boxes which are not outdated are
  // exactly those of the triangles below. Empty text if all hold, else what is wrong.
  std::string validate() const;

 private:
  void build(std::span<const uvec3> triangles, const Config& config);
  void gather_points(std::span<const uint32_t> depths);
  std::span<const uint32_t> points_of(uint32_t node) const;
  Box leaf_box(uint32_t leaf) const;
  void set_from_triangle(Node& node);
  void set_from_points(Node& node, std::span<const uint32_t> points);
  void merge_children(uint32_t node);
  void update_range(uint32_t begin, uint32_t end);
  void update_levels(uint32_t node, uint32_t levels);
  void visit(uint32_t node);

  template <class MeetTriangle>
  void traverse(const Probe& probe, const float& t_max, const MeetTriangle& meet);

  std::vector<Node> nodes_;
  std::vector<uvec3> triangles_;      // one a leaf
  std::vector<uint32_t> primitives_;  // one a leaf: which of the caller's triangles it is
  std::span<const vec3> positions_;
  uint32_t frame_ = 0;
  uint32_t height_ = 0, depth_ = 0;
  FirstVisit first_visit_ = FirstVisit::node;
  uint32_t visit_levels_ = 0;

  // For updates only, so that the nodes stay small. Inner nodes at depth d and below have points:
  // the vertices of their triangles, each once, ascending; none elsewhere.
  struct Upper {
    uint32_t node = 0;
    uint32_t points = 0;  // how many
    size_t first_point = 0;
  };
  std::vector<Upper> upper_;         // nodes at depth d and above, children first
  std::vector<size_t> point_begin_;  // one a node
  std::vector<uint32_t> point_count_;
  std::vector<uint32_t> points_;  // those of upper_ in its order, then those of nodes below
  UpdateWork visited_;
};

// L's model of a complete tree with n leaves and k children a node.
double total_nodes(double n, double k);        // equation 4
double upper_nodes(double n, double k);        // equation 5: at half the height and above
double updated_share(double n, double k);      // equation 6: of the boxes, by a hybrid update
double predicted_speedup(double n, double k);  // equation 7: of a hybrid over a bottom-up update
double speedup_limit(double k);                // equations 8 to 10: what 7 stays below; above is 8

}  // namespace sinew::larsson
