#include "sinew/bvh/trace/proximity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/bvh/update/visit.h"

namespace sinew {
namespace {

constexpr uint32_t kTop = 0xffffffffu;  // instead of an instance: a word of the top tree

struct Item {
  float distance;  // squared, to its box
  uint32_t word;
  uint32_t instance;
};

using Corners = std::array<vec3, 3>;

// Walks the hierarchy nearest box first. Query offers
//   float distance(const Box&)   squared, in the world; boxes farther than limit() are left out
//   float limit()
//   void triangle(const Instance&, uint32_t primitive, const Corners&)   in the world
template <class Query>
class Walker {
 public:
  Walker(const SceneView& scene, uint32_t mask, Query& query)
      : scene_(scene), mask_(mask), query_(query) {}

  void run() {
    if (scene_.top != nullptr) {
      push({0.0f, inner_word(0), kTop});
    } else if (scene_.instance_count > 0) {
      enter({0, kNoChild}, 0.0f);
    }
    while (count_ > 0) {
      const Item item = stack_[--count_];
      if (item.distance > query_.limit()) continue;
      if (item.instance == kTop) {
        visit_top(item);
      } else {
        visit(item);
      }
    }
  }

 private:
  void push(const Item& item) { stack_[count_++] = item; }

  void visit_top(const Item& item) {
    if (is_inner_word(item.word)) return open(scene_.top[item.word], item.instance, nullptr);
    const uint32_t index = item.word & ~kLeafBit;
    enter(scene_.leaves != nullptr ? scene_.leaves[index] : TopLeaf{index}, item.distance);
  }

  void enter(const TopLeaf& leaf, float distance) {
    const Instance& instance = scene_.instances[leaf.instance];
    if ((instance.mask & mask_) == 0) return;
    uint32_t root = leaf.word != kNoChild ? leaf.word : instance.root;
    if (leaf.word == kNoChild && instance.body != nullptr) {
      if (!is_ready(*instance.body) && !visit_upper(*instance.body)) {
        return look_through_body(instance);
      }
      root = instance.body->upper.load(std::memory_order_acquire);
    }
    if (root != kNoChild) push({distance, root, leaf.instance});
  }

  void visit(const Item& item) {
    const Instance& instance = scene_.instances[item.instance];
    uint32_t word = item.word;
    if (!is_inner_word(word) && !is_leaf_word(word)) {
      const uint32_t treelet = treelet_of(word);
      word = sinew::visit_treelet(*instance.body, treelet);
      if (word == kNoChild) return look_through_treelet(instance, treelet);
    }
    if (is_inner_word(word)) return open(instance.nodes[word], item.instance, &instance);
    for (uint32_t p = leaf_first(word); p < leaf_first(word) + leaf_packets(word); ++p) {
      visit_corners(instance, p);
    }
  }

  // Pushes the children, the nearest last.
  void open(const Node8& node, uint32_t index, const Instance* instance) {
    const uint32_t first = count_;
    for (uint32_t lane = 0; lane < kWidth; ++lane) {
      if (node.child[lane] == kNoChild) break;  // absent children stand last
      const Box box = in_world(lane_box(node, lane), instance);
      if (box.empty()) continue;
      const float distance = query_.distance(box);
      if (distance <= query_.limit()) push({distance, node.child[lane], index});
    }
    std::sort(stack_.begin() + first, stack_.begin() + count_,
              [](const Item& a, const Item& b) { return a.distance > b.distance; });
  }

  static Box in_world(const Box& box, const Instance* instance) {
    return instance == nullptr || instance->in_place ? box
                                                     : transform_box(instance->placement, box);
  }

  void visit_corners(const Instance& instance, uint32_t index) {
    if (instance.packets != nullptr) return visit_packet(instance, instance.packets[index], index);
    const PacketCorners& from = instance.corners[index];
    TrianglePacket packet;
    for (uint32_t lane = 0; lane < kPacket; ++lane) {
      for (int c = 0; c < 3; ++c) {
        const vec3 at = instance.vertices[from.place + from.v[lane][c]];
        for (int axis = 0; axis < 3; ++axis) packet.v[c][axis][lane] = at[axis];
      }
    }
    visit_packet(instance, packet, index);
  }

  void visit_packet(const Instance& instance, const TrianglePacket& packet, uint32_t index) {
    for (uint32_t lane = 0; lane < kPacket; ++lane) {
      const uint32_t primitive = instance.primitives[index][lane];
      if (primitive == kNoPrimitive) continue;
      Corners corners;
      for (int c = 0; c < 3; ++c) {
        corners[c] = vec3(packet.v[c][0][lane], packet.v[c][1][lane], packet.v[c][2][lane]);
        if (!instance.in_place) corners[c] = transform_point(instance.placement, corners[c]);
      }
      const vec3 sum = corners[0] + corners[1] + corners[2];
      if (!std::isfinite(sum.x + sum.y + sum.z)) continue;  // not there until it is finite
      query_.triangle(instance, primitive, corners);
    }
  }

  // What another thread is making: see visit.h.
  void look_through_treelet(const Instance& instance, uint32_t treelet) {
    TreeletPackets packets;
    look_at_packets(*instance.body, treelet, packets);
    const Treelet& t = instance.body->layout->treelets[treelet];
    for (uint32_t p = 0; p < t.packet_count; ++p) {
      visit_packet(instance, packets[p], t.first_packet + p);
    }
  }
  void look_through_body(const Instance& instance) {
    for (uint32_t t = 0; t < instance.body->layout->treelets.size(); ++t) {
      const Box box = in_world(look_at_box(*instance.body, t), &instance);
      if (!box.empty() && query_.distance(box) <= query_.limit()) look_through_treelet(instance, t);
    }
  }

  const SceneView& scene_;
  const uint32_t mask_;
  Query& query_;
  std::array<Item, 2 * kMaxDepth*(kWidth - 1) + kWidth> stack_;
  uint32_t count_ = 0;
};

// The point of the triangle that is nearest to p, as weights of its second and third corner.
// Based on: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5 (the regions of the
// triangle's vertices, edges and face).
glm::vec2 nearest_in_triangle(vec3 p, const Corners& corner) {
  const vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0], ap = p - corner[0];
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0f && d2 <= 0.0f) return {0.0f, 0.0f};
  const vec3 bp = p - corner[1];
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0f && d4 <= d3) return {1.0f, 0.0f};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return {d1 > d3 ? d1 / (d1 - d3) : 0.0f, 0.0f};
  const vec3 cp = p - corner[2];
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0f && d5 <= d6) return {0.0f, 1.0f};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return {0.0f, d2 > d6 ? d2 / (d2 - d6) : 0.0f};
  const float va = d3 * d6 - d5 * d4, along_bc = d4 - d3, back = d5 - d6;
  if (va <= 0.0f && along_bc >= 0.0f && back >= 0.0f) {
    const float w = along_bc + back > 0.0f ? along_bc / (along_bc + back) : 0.0f;
    return {1.0f - w, w};
  }
  const float scale = 1.0f / (va + vb + vc);
  return {vb * scale, vc * scale};
}

struct NearestQuery {
  vec3 from;
  float best;  // squared distance
  std::optional<NearestPoint> found{};

  float limit() const { return best; }
  float distance(const Box& box) const {
    const vec3 away = glm::max(glm::max(box.min - from, from - box.max), vec3(0.0f));
    return dot(away, away) * (1.0f - 1e-6f);  // never more than to a point inside, as rounded
  }
  void triangle(const Instance& instance, uint32_t primitive, const Corners& corner) {
    const glm::vec2 at = nearest_in_triangle(from, corner);
    const vec3 point = corner[0] + at.x * (corner[1] - corner[0]) + at.y * (corner[2] - corner[0]);
    const float squared = dot(point - from, point - from);
    if (!(squared <= best)) return;
    const TriangleId id{instance.object, primitive};
    if (found && squared == best && id > TriangleId{found->object, found->primitive}) return;
    best = squared;
    found = {std::sqrt(squared), point, at.x, at.y, primitive, instance.object};
  }
};

// Whether the triangle, moved so that the box's centre is the origin, meets the box.
bool meets_box(const Corners& corner, vec3 half) {
  const auto apart = [&](vec3 axis) {
    const float reach = dot(glm::abs(axis), half);
    const float a = dot(axis, corner[0]), b = dot(axis, corner[1]), c = dot(axis, corner[2]);
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const vec3 edges[3] = {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
  for (int axis = 0; axis < 3; ++axis) {
    vec3 unit(0.0f);
    unit[axis] = 1.0f;
    if (apart(unit)) return false;
    for (const vec3& edge : edges) {
      if (apart(cross(unit, edge))) return false;
    }
  }
  return !apart(cross(edges[0], edges[1]));
}

struct BoxQuery {
  const Box& box;
  std::vector<TriangleId>& out;

  float limit() const { return 0.0f; }
  float distance(const Box& other) const {
    const bool apart = glm::any(glm::greaterThan(other.min, box.max)) ||
                       glm::any(glm::lessThan(other.max, box.min));
    return apart ? 1.0f : 0.0f;
  }
  void triangle(const Instance& instance, uint32_t primitive, const Corners& corner) {
    const vec3 center = box.center();
    if (meets_box({corner[0] - center, corner[1] - center, corner[2] - center},
                  0.5f * box.extent())) {
      out.push_back({instance.object, primitive});
    }
  }
};

}  // namespace

std::optional<NearestPoint> nearest_point(const SceneView& scene, vec3 from, float max_distance,
                                          uint32_t mask) {
  if (!std::isfinite(from.x + from.y + from.z) || !(max_distance >= 0.0f)) return std::nullopt;
  NearestQuery query{from, max_distance * max_distance};
  Walker<NearestQuery>(scene, mask, query).run();
  return query.found;
}

void triangles_in_box(const SceneView& scene, const Box& box, std::vector<TriangleId>& out,
                      uint32_t mask) {
  out.clear();
  if (box.empty()) return;
  BoxQuery query{box, out};
  Walker<BoxQuery>(scene, mask, query).run();
  std::sort(out.begin(), out.end());
}

}  // namespace sinew
