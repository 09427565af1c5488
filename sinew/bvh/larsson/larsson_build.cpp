// L's hierarchy: octants about the middle of each node's box, medians where that does not part the
// triangles, and the point sets that its updates start from.
// Based on: Larsson, Akenine-Moller 2003, section 3.1. Where even the medians do not part them
// (centres that coincide), equal shares in the order of the centres do.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "sinew/base/check.h"
#include "sinew/bvh/larsson/larsson.h"

namespace sinew::larsson {
namespace {

constexpr uint32_t kBranching = 8;

// Where each octant's triangles begin within the node's, and the end.
using Cuts = std::array<size_t, kBranching + 1>;

struct Builder {
  std::span<const vec3> positions;
  std::span<const uvec3> triangles;
  std::vector<vec3> centers;     // one a triangle
  std::vector<uint32_t> order;   // of the triangles; a node owns a range
  std::vector<uint32_t> sorted;  // scratch

  void start() {
    centers.resize(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i) {
      const uvec3 t = triangles[i];
      const vec3 center = (positions[t.x] + positions[t.y] + positions[t.z]) / 3.0f;
      centers[i] = std::isfinite(center.x + center.y + center.z) ? center : vec3(0.0f);
    }
    order.resize(triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    sorted.resize(order.size());
  }

  // Orders the range by octants about `middle`.
  Cuts partition(size_t begin, size_t end, vec3 middle) {
    const auto octant = [&](uint32_t triangle) {
      const vec3 c = centers[triangle];
      return (c.x < middle.x ? 0u : 4u) | (c.y < middle.y ? 0u : 2u) | (c.z < middle.z ? 0u : 1u);
    };
    Cuts cuts{};
    for (size_t i = begin; i < end; ++i) ++cuts[octant(order[i]) + 1];
    cuts[0] = begin;
    for (uint32_t k = 0; k < kBranching; ++k) cuts[k + 1] += cuts[k];
    Cuts next = cuts;
    for (size_t i = begin; i < end; ++i) sorted[next[octant(order[i])]++] = order[i];
    std::copy_n(sorted.begin() + static_cast<ptrdiff_t>(begin), end - begin,
                order.begin() + static_cast<ptrdiff_t>(begin));
    return cuts;
  }

  vec3 box_middle(size_t begin, size_t end) const {
    Box box;
    for (size_t i = begin; i < end; ++i) {
      const uvec3 t = triangles[order[i]];
      for (int k = 0; k < 3; ++k) box.extend(positions[t[k]]);
    }
    return box.center();
  }

  vec3 medians(size_t begin, size_t end) {
    const std::span<uint32_t> part(sorted.data() + begin, end - begin);
    vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
      std::copy_n(order.begin() + static_cast<ptrdiff_t>(begin), part.size(), part.begin());
      const auto middle = part.begin() + static_cast<ptrdiff_t>(part.size() / 2);
      std::nth_element(part.begin(), middle, part.end(),
                       [&](uint32_t a, uint32_t b) { return centers[a][axis] < centers[b][axis]; });
      out[axis] = centers[*middle][axis];
    }
    return out;
  }

  Cuts equal_shares(size_t begin, size_t end) {
    std::sort(order.begin() + static_cast<ptrdiff_t>(begin),
              order.begin() + static_cast<ptrdiff_t>(end), [&](uint32_t a, uint32_t b) {
                const vec3 p = centers[a], q = centers[b];
                return std::tuple(p.x, p.y, p.z, a) < std::tuple(q.x, q.y, q.z, b);
              });
    Cuts cuts{};
    for (uint32_t k = 0; k <= kBranching; ++k) cuts[k] = begin + (end - begin) * k / kBranching;
    return cuts;
  }

  Cuts split(size_t begin, size_t end) {
    const auto parts = [&](const Cuts& cuts) {
      int count = 0;
      for (uint32_t k = 0; k < kBranching; ++k) count += cuts[k] < cuts[k + 1];
      return count;
    };
    if (const Cuts cuts = partition(begin, end, box_middle(begin, end)); parts(cuts) >= 2) {
      return cuts;
    }
    if (const Cuts cuts = partition(begin, end, medians(begin, end)); parts(cuts) >= 2) {
      return cuts;
    }
    return equal_shares(begin, end);
  }
};

struct Range {
  size_t begin, end;
  uint32_t depth;
};

}  // namespace

Hierarchy::Hierarchy(std::span<const vec3> positions, std::span<const uvec3> triangles,
                     const Config& config)
    : positions_(positions), first_visit_(config.first_visit), visit_levels_(config.visit_levels) {
  SINEW_CHECK(visit_levels_ >= 1 && visit_levels_ <= 16);
  SINEW_CHECK(triangles.size() < Node::kLeaf);
  for (const uvec3 t : triangles) SINEW_CHECK(std::max({t.x, t.y, t.z}) < positions.size());
  build(triangles, config);
  update_bottom_up(positions);
}

// Without recursion, since a bad distribution makes a deep tree.
void Hierarchy::build(std::span<const uvec3> triangles, const Config& config) {
  Builder builder{positions_, triangles, {}, {}, {}};
  builder.start();
  std::vector<Range> todo;
  if (!triangles.empty()) todo.push_back({0, triangles.size(), 0});
  std::vector<uint32_t> depths, path;  // of every node; the inner nodes still open
  while (!todo.empty()) {
    const Range range = todo.back();
    todo.pop_back();
    const auto index = static_cast<uint32_t>(nodes_.size());
    for (; path.size() > range.depth; path.pop_back()) nodes_[path.back()].link = index;
    depths.push_back(range.depth);
    height_ = std::max(height_, range.depth);
    Node& node = nodes_.emplace_back();
    if (range.end - range.begin == 1) {
      node.link = Node::kLeaf | static_cast<uint32_t>(range.begin);
      continue;
    }
    path.push_back(index);
    const Cuts cuts = builder.split(range.begin, range.end);
    for (uint32_t k = kBranching; k-- > 0;) {
      if (cuts[k] < cuts[k + 1]) todo.push_back({cuts[k], cuts[k + 1], range.depth + 1});
    }
  }
  for (const uint32_t open : path) nodes_[open].link = static_cast<uint32_t>(nodes_.size());

  primitives_ = std::move(builder.order);
  for (const uint32_t primitive : primitives_) triangles_.push_back(triangles[primitive]);

  depth_ = std::min(config.depth.value_or(height_ / 2), height_);
  gather_points(depths);
}

// Hybrid updates then read everything but the nodes and the positions from one end to the other.
void Hierarchy::gather_points(std::span<const uint32_t> depths) {
  point_begin_.resize(nodes_.size());
  point_count_.resize(nodes_.size());
  std::vector<uint32_t> vertices;
  const auto gather = [&](uint32_t node) {
    vertices.clear();
    for (uint32_t j = node; j < nodes_[node].link; ++j) {
      if (!nodes_[j].is_leaf()) continue;
      const uvec3 t = triangles_[nodes_[j].leaf()];
      vertices.insert(vertices.end(), {t.x, t.y, t.z});
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    point_begin_[node] = points_.size();
    point_count_[node] = static_cast<uint32_t>(vertices.size());
    points_.insert(points_.end(), vertices.begin(), vertices.end());
  };
  for (auto i = static_cast<uint32_t>(nodes_.size()); i-- > 0;) {
    if (depths[i] > depth_) continue;
    if (depths[i] == depth_ && !nodes_[i].is_leaf()) gather(i);
    upper_.push_back({i, point_count_[i], point_begin_[i]});
  }
  for (uint32_t i = 0; i < nodes_.size(); ++i) {
    if (depths[i] > depth_ && !nodes_[i].is_leaf()) gather(i);
  }
}

}  // namespace sinew::larsson
