#include "sinew/scene/procedural/unwrap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/math/box.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew {
namespace {

constexpr uint32_t kNoChart = 0xffffffffu;
constexpr float kMargin = 4.0f;  // texels around a chart

uint8_t dominant_side(vec3 n) {
  const vec3 a = glm::abs(n);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
  return static_cast<uint8_t>(2 * axis + (n[axis] < 0.0f));
}

vec3 triangle_normal(std::span<const vec3> normals, uvec3 t) {
  return normalize(normals[t.x] + normals[t.y] + normals[t.z]);
}

// Whether flattening to the side keeps at least a fifth of the area.
bool faces(vec3 n, uint8_t side) {
  return (side % 2 == 0 ? n[side / 2] : -n[side / 2]) > 0.2f;
}

// Drops the axis of a side; seen from outside, x goes right and y up.
vec2 flatten(vec3 p, uint8_t side) {
  const float sign = side % 2 == 0 ? 1.0f : -1.0f;
  switch (side / 2) {
    case 0:
      return {-sign * p.z, p.y};
    case 1:
      return {p.x, -sign * p.z};
    default:
      return {sign * p.x, p.y};
  }
}

// The side that each triangle faces, with ragged borders between sides straightened: a triangle
// takes the side that two of its neighbours have, unless it would be seen edge-on.
std::vector<uint8_t> choose_sides(std::span<const vec3> normals, std::span<const uvec3> triangles,
                                  std::span<const uint32_t> opposite) {
  std::vector<uint8_t> sides(triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t) {
    sides[t] = dominant_side(triangle_normal(normals, triangles[t]));
  }
  for (int pass = 0; pass < 4; ++pass) {
    const std::vector<uint8_t> old = sides;
    for (size_t t = 0; t < triangles.size(); ++t) {
      std::array<uint8_t, 3> near;
      for (int k = 0; k < 3; ++k) {
        const uint32_t h = opposite[3 * t + k];
        near[k] = h == kNoHalfEdge ? old[t] : old[h / 3];
      }
      uint8_t wanted = old[t];
      if (near[0] == near[1] || near[0] == near[2]) wanted = near[0];
      if (near[1] == near[2]) wanted = near[1];
      if (faces(triangle_normal(normals, triangles[t]), wanted)) sides[t] = wanted;
    }
  }
  return sides;
}

struct Chart {
  uint8_t side = 0;
  uint32_t triangles = 1;
  bool turned = false;  // by a quarter, to lie flat
  vec2 low{1e30f}, high{-1e30f};
  vec2 place{0.0f};  // of `low` in the atlas, in texels

  vec2 size() const { return high - low; }
};

// What a chart's triangles have in common: a side, and a slice across the longest axis of the body
// (long charts would leave much of the square empty).
struct Label {
  uint8_t side = 0;
  uint8_t slice = 0;
  bool operator==(const Label&) const = default;
};

std::vector<Label> choose_labels(std::span<const vec3> positions, std::span<const vec3> normals,
                                 std::span<const uvec3> triangles,
                                 std::span<const uint32_t> opposite) {
  constexpr float kSlices = 4.0f;
  Box box;
  for (const vec3 p : positions) box.extend(p);
  const vec3 size = box.extent();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const std::vector<uint8_t> sides = choose_sides(normals, triangles, opposite);
  std::vector<Label> labels(triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t) {
    const uvec3 v = triangles[t];
    const float middle =
        (positions[v.x][axis] + positions[v.y][axis] + positions[v.z][axis]) / 3.0f;
    const float share = (middle - box.min[axis]) / size[axis];
    labels[t] = {sides[t], static_cast<uint8_t>(std::clamp(kSlices * share, 0.0f, kSlices - 1.0f))};
  }
  return labels;
}

// Connected triangles of one label.
std::vector<uint32_t> find_charts(std::span<const Label> labels, std::span<const uint32_t> opposite,
                                  std::vector<Chart>& charts) {
  std::vector<uint32_t> chart(labels.size(), kNoChart);
  std::vector<uint32_t> stack;
  for (uint32_t seed = 0; seed < labels.size(); ++seed) {
    if (chart[seed] != kNoChart) continue;
    const uint32_t id = static_cast<uint32_t>(charts.size());
    charts.push_back({});
    charts.back().side = labels[seed].side;
    chart[seed] = id;
    stack.push_back(seed);
    while (!stack.empty()) {
      const uint32_t t = stack.back();
      stack.pop_back();
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t h = opposite[3 * t + k];
        if (h == kNoHalfEdge || chart[h / 3] != kNoChart || labels[h / 3] != labels[t]) continue;
        ++charts.back().triangles;
        chart[h / 3] = id;
        stack.push_back(h / 3);
      }
    }
  }
  return chart;
}

// Triangles of small charts join a chart beside them, where that does not flatten them too much.
void dissolve_small_charts(std::span<const vec3> normals, std::span<const uvec3> triangles,
                           std::span<const uint32_t> opposite, std::span<const Chart> charts,
                           std::span<const uint32_t> chart_of, std::vector<Label>& labels) {
  const uint32_t small = 8 + static_cast<uint32_t>(triangles.size() / 1000);
  const std::vector<Label> old = labels;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    if (charts[chart_of[t]].triangles >= small) continue;
    uint32_t best = charts[chart_of[t]].triangles;  // join the largest
    for (uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      if (opposite[h] == kNoHalfEdge) continue;
      const uint32_t other = opposite[h] / 3, size = charts[chart_of[other]].triangles;
      if (size <= best || !faces(triangle_normal(normals, triangles[t]), old[other].side)) continue;
      best = size;
      labels[t] = old[other];
    }
  }
}

// Places charts, tallest first, in rows; false if they do not fit at this scale (texels a metre).
bool pack(std::vector<Chart>& charts, std::span<const uint32_t> order, float scale, float side) {
  float x = 0.0f, y = 0.0f, row = 0.0f;
  for (const uint32_t id : order) {
    Chart& chart = charts[id];
    vec2 size = scale * chart.size();
    if (chart.turned) std::swap(size.x, size.y);
    size += 2.0f * kMargin;
    if (x + size.x > side) {
      x = 0.0f;
      y += row;
      row = 0.0f;
    }
    if (x + size.x > side || y + size.y > side) return false;
    chart.place = vec2(x, y) + kMargin;
    x += size.x;
    row = std::max(row, size.y);
  }
  return true;
}

// The greatest scale at which all charts fit, to 1%.
float pack_charts(std::vector<Chart>& charts, float side) {
  float area = 0.0f;
  for (Chart& chart : charts) {
    const vec2 size = chart.size();
    chart.turned = size.y > size.x;
    area += size.x * size.y;
  }
  std::vector<uint32_t> order(charts.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto height = [&](uint32_t i) { return std::min(charts[i].size().x, charts[i].size().y); };
  std::ranges::stable_sort(order, [&](uint32_t a, uint32_t b) { return height(a) > height(b); });
  float scale = side / std::sqrt(std::max(area, 1e-12f));
  while (!pack(charts, order, scale, side)) {
    scale *= 0.99f;
    SINEW_CHECK(scale > 1e-6f * side);  // else the margins alone are too much for the square
  }
  return scale;
}

}  // namespace

Unwrapping unwrap(std::span<const vec3> positions, std::span<const vec3> normals,
                  std::span<const uvec3> triangles, uint32_t resolution) {
  const std::vector<uint32_t> opposite = opposite_half_edges(triangles);
  std::vector<Label> labels = choose_labels(positions, normals, triangles, opposite);
  std::vector<Chart> charts;
  std::vector<uint32_t> chart_of = find_charts(labels, opposite, charts);
  for (int pass = 0; pass < 3; ++pass) {
    dissolve_small_charts(normals, triangles, opposite, charts, chart_of, labels);
    charts.clear();
    chart_of = find_charts(labels, opposite, charts);
  }
  for (size_t t = 0; t < triangles.size(); ++t) {
    Chart& chart = charts[chart_of[t]];
    for (int k = 0; k < 3; ++k) {
      const vec2 p = flatten(positions[triangles[t][k]], chart.side);
      chart.low = glm::min(chart.low, p);
      chart.high = glm::max(chart.high, p);
    }
  }
  const float side = static_cast<float>(resolution);
  const float scale = pack_charts(charts, side);

  // An entry for every pair of a vertex and a chart; a vertex has few charts, kept in a list.
  Unwrapping result;
  result.corners.resize(triangles.size());
  constexpr uint32_t kNone = 0xffffffffu;
  std::vector<uint32_t> first(positions.size(), kNone), next, entry_chart;
  for (size_t t = 0; t < triangles.size(); ++t) {
    const Chart& chart = charts[chart_of[t]];
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = triangles[t][k];
      uint32_t entry = first[v];
      while (entry != kNone && entry_chart[entry] != chart_of[t]) entry = next[entry];
      if (entry == kNone) {
        entry = static_cast<uint32_t>(result.vertices.size());
        vec2 p = scale * (flatten(positions[v], chart.side) - chart.low);
        if (chart.turned) p = vec2(p.y, scale * chart.size().x - p.x);
        p += chart.place;
        result.texcoords.push_back(vec2(p.x, side - p.y) / side);
        result.vertices.push_back(v);
        entry_chart.push_back(chart_of[t]);
        next.push_back(first[v]);
        first[v] = entry;
      }
      result.corners[t][k] = entry;
    }
  }
  return result;
}

}  // namespace sinew
