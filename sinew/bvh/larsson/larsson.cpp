// Updates and traversal of L's hierarchy.
// Based on: Larsson, Akenine-Moller 2003, sections 3.2 and 3.3, figure 2; T. Moller, B. Trumbore,
// "Fast, Minimum Storage Ray/Triangle Intersection", journal of graphics tools 2(1), 1997.
#include "sinew/bvh/larsson/larsson.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew::larsson {
namespace {

// The ray's part up to t_max meets the box. A parallel ray in a box plane gives NaN, which the
// order of the comparisons leaves out.
bool meets(const Probe& probe, const Box& box, float t_max) {
  constexpr float kWiden = 1.0f + 4.0f * 5.97e-8f;
  float near = probe.ray.t_min, far = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = (box.min[axis] - probe.ray.origin[axis]) * probe.inverse[axis];
    const float b = (box.max[axis] - probe.ray.origin[axis]) * probe.inverse[axis];
    const float enter = b < a ? b : a, leave = (b < a ? a : b) * kWiden;
    near = enter > near ? enter : near;
    far = leave < far ? leave : far;
  }
  return near <= far;
}

struct TriangleHit {
  bool hit = false;
  float t = 0.0f, u = 0.0f, v = 0.0f;
};

TriangleHit intersect(const Ray& ray, vec3 a, vec3 b, vec3 c) {
  const vec3 edge1 = b - a, edge2 = c - a;
  const vec3 p = cross(ray.direction, edge2);
  const float determinant = dot(edge1, p);
  if (determinant == 0.0f) return {};
  const float inverse = 1.0f / determinant;
  const vec3 from_a = ray.origin - a;
  const float u = dot(from_a, p) * inverse;
  if (!(u >= 0.0f && u <= 1.0f)) return {};
  const vec3 q = cross(from_a, edge1);
  const float v = dot(ray.direction, q) * inverse;
  if (!(v >= 0.0f && u + v <= 1.0f)) return {};
  return {true, dot(edge2, q) * inverse, u, v};
}

}  // namespace

void Hierarchy::update_bottom_up(std::span<const vec3> positions) {
  SINEW_CHECK(positions.size() == positions_.size());
  positions_ = positions;
  ++frame_;
  visited_ = {};
  update_range(0, static_cast<uint32_t>(nodes_.size()));
}

void Hierarchy::update_hybrid(std::span<const vec3> positions) {
  SINEW_CHECK(positions.size() == positions_.size());
  positions_ = positions;
  ++frame_;
  visited_ = {};
  for (const Upper& upper : upper_) {
    Node& node = nodes_[upper.node];
    if (node.is_leaf()) {
      set_from_triangle(node);
    } else if (upper.points > 0) {
      set_from_points(node, {points_.data() + upper.first_point, upper.points});
    } else {
      merge_children(upper.node);
    }
  }
}

std::span<const uint32_t> Hierarchy::points_of(uint32_t node) const {
  return {points_.data() + point_begin_[node], point_count_[node]};
}

Box Hierarchy::leaf_box(uint32_t leaf) const {
  const uvec3 t = triangles_[leaf];
  Box box;
  for (int k = 0; k < 3; ++k) box.extend(positions_[t[k]]);
  return box;
}

void Hierarchy::set_from_triangle(Node& node) {
  node.box = leaf_box(node.leaf());
  node.last_updated = frame_;
}

void Hierarchy::set_from_points(Node& node, std::span<const uint32_t> points) {
  Box box;
  for (const uint32_t vertex : points) box.extend(positions_[vertex]);
  node.box = box;
  node.last_updated = frame_;
}

void Hierarchy::merge_children(uint32_t index) {
  Node& node = nodes_[index];
  Box box;
  for (uint32_t child = index + 1; child < node.link; child = nodes_[child].skip(child)) {
    box.extend(nodes_[child].box);
  }
  node.box = box;
  node.last_updated = frame_;
}

// Children stand behind their parents, so backwards is bottom-up.
void Hierarchy::update_range(uint32_t begin, uint32_t end) {
  for (uint32_t i = end; i-- > begin;) {
    if (nodes_[i].is_leaf()) {
      set_from_triangle(nodes_[i]);
    } else {
      merge_children(i);
    }
  }
}

void Hierarchy::update_levels(uint32_t index, uint32_t levels) {
  Node& node = nodes_[index];
  if (node.is_leaf()) {
    set_from_triangle(node);
    visited_.vertices += 3;
  } else if (levels == 0) {
    set_from_points(node, points_of(index));
    visited_.vertices += point_count_[index];
  } else {
    for (uint32_t child = index + 1; child < node.link; child = nodes_[child].skip(child)) {
      update_levels(child, levels - 1);
    }
    merge_children(index);
  }
  ++visited_.boxes;
}

void Hierarchy::visit(uint32_t index) {
  switch (first_visit_) {
    case FirstVisit::node:
      update_levels(index, 0);
      break;
    case FirstVisit::levels:
      update_levels(index, visit_levels_);
      break;
    case FirstVisit::subtree: {
      const uint32_t end = nodes_[index].skip(index);
      update_range(index, end);
      for (uint32_t i = index; i < end; ++i) visited_.vertices += nodes_[i].is_leaf() ? 3 : 0;
      visited_.boxes += end - index;
      break;
    }
  }
}

// Figure 2. `t_max` is read anew at every box; meet(leaf) says whether to stop.
template <class MeetTriangle>
void Hierarchy::traverse(const Probe& probe, const float& t_max, const MeetTriangle& meet) {
  const auto stop = static_cast<uint32_t>(nodes_.size());
  uint32_t index = 0;
  while (index < stop) {
    if (nodes_[index].last_updated != frame_) visit(index);
    const Node& node = nodes_[index];
    if (meets(probe, node.box, t_max)) {
      if (node.is_leaf() && meet(node.leaf())) return;
      ++index;
    } else {
      index = node.skip(index);
    }
  }
}

void Hierarchy::closest_hit(const Probe& probe, uint32_t object, Hit& hit) {
  float t_max = std::min(hit.t, probe.ray.t_max);
  traverse(probe, t_max, [&](uint32_t leaf) {
    const uvec3 v = triangles_[leaf];
    const TriangleHit found =
        intersect(probe.ray, positions_[v.x], positions_[v.y], positions_[v.z]);
    if (!found.hit || !(found.t >= probe.ray.t_min && found.t <= t_max)) return false;
    // Of equal hits the least (object, triangle) counts, as in all queries.
    const uint32_t primitive = primitives_[leaf];
    const bool equal = hit && found.t == hit.t;
    if (equal && (object > hit.object || (object == hit.object && primitive > hit.primitive))) {
      return false;
    }
    hit = {found.t, found.u, found.v, primitive, object};
    t_max = found.t;
    return false;
  });
}

bool Hierarchy::any_hit(const Probe& probe) {
  const float t_max = probe.ray.t_max;
  bool found = false;
  traverse(probe, t_max, [&](uint32_t leaf) {
    const uvec3 v = triangles_[leaf];
    const TriangleHit hit = intersect(probe.ray, positions_[v.x], positions_[v.y], positions_[v.z]);
    found = hit.hit && hit.t >= probe.ray.t_min && hit.t <= t_max;
    return found;
  });
  return found;
}

UpdateWork Hierarchy::bottom_up_work() const {
  return {3 * uint64_t{triangles_.size()}, nodes_.size()};
}

UpdateWork Hierarchy::hybrid_work() const {
  UpdateWork work{0, upper_.size()};
  for (const Upper& upper : upper_) {
    work.vertices += nodes_[upper.node].is_leaf() ? 3 : upper.points;
  }
  return work;
}

std::string Hierarchy::validate() const {
  std::vector<uint32_t> ends;  // of the nodes around
  std::vector<uint8_t> seen(triangles_.size());
  const auto wrong = [](uint32_t node, const char* what) {
    return "node " + std::to_string(node) + ": " + what;
  };
  for (uint32_t i = 0; i < nodes_.size(); ++i) {
    while (!ends.empty() && ends.back() == i) ends.pop_back();
    const uint32_t end = nodes_[i].skip(i), limit = ends.empty() ? end : ends.back();
    if (end > nodes_.size() || end <= i || end > limit) return wrong(i, "its skip index is wrong");
    ends.push_back(end);
    if (nodes_[i].is_leaf()) {
      const uint32_t leaf = nodes_[i].leaf();
      if (leaf >= seen.size() || seen[primitives_[leaf]]++) return wrong(i, "its leaf is wrong");
    } else if (nodes_[i + 1].skip(i + 1) == end) {
      return wrong(i, "it has a single child");
    }
    if (nodes_[i].last_updated != frame_) continue;
    Box exact;
    for (uint32_t j = i; j < end; ++j) {
      if (nodes_[j].is_leaf()) exact.extend(leaf_box(nodes_[j].leaf()));
    }
    if (exact.min != nodes_[i].box.min || exact.max != nodes_[i].box.max) {
      return wrong(i, "its box is not that of its triangles");
    }
  }
  for (size_t t = 0; t < seen.size(); ++t) {
    if (!seen[t]) return "triangle " + std::to_string(t) + ": no leaf has it";
  }
  return {};
}

double total_nodes(double n, double k) {
  return n + (n - 1.0) / (k - 1.0);
}
double upper_nodes(double n, double k) {
  return total_nodes(std::sqrt(n), k);
}
double updated_share(double n, double k) {
  return upper_nodes(n, k) / total_nodes(n, k);
}
double predicted_speedup(double n, double k) {
  return (3.0 * n + total_nodes(n, k)) / (0.5 * n + upper_nodes(n, k));
}
double speedup_limit(double k) {
  return 8.0 + 2.0 / (k - 1.0);
}

}  // namespace sinew::larsson
