#include "sinew/svo/draw/rasterize_hull.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

struct Flat {
  double x, y;
};

double turn(const Flat& a, const Flat& b, const Flat& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Andrew's monotone chain. Based on: A. Andrew, "Another Efficient Algorithm for Convex Hulls in
// Two Dimensions", 1979. `points` are sorted in place.
void wrap(Flat* points, uint32_t count, Outline& out) {
  std::sort(points, points + count,
            [](const Flat& a, const Flat& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  Flat chain[2 * Outline::kMost];
  uint32_t size = 0;
  const auto add = [&](const Flat& p, uint32_t least) {
    while (size >= least + 2 && !(turn(chain[size - 2], chain[size - 1], p) > 0.0)) --size;
    chain[size++] = p;
  };
  for (uint32_t i = 0; i < count; ++i) add(points[i], 0);
  const uint32_t lower = size - 1;
  for (uint32_t i = count - 1; i-- > 0;) add(points[i], lower);
  out.count = std::max(size - 1, 1u);  // the first came again
  for (uint32_t i = 0; i < out.count; ++i) {
    out.x[i] = chain[i].x;
    out.y[i] = chain[i].y;
  }
}

// Instead of each point the corners of the box that rounding leaves it.
uint32_t widen(Flat* points, const SeenPoints& seen, bool perspective, const float reach[3]) {
  for (uint32_t i = 0; i < seen.count; ++i) {
    const Flat p{seen.at[i][0], seen.at[i][1]};
    const double depth = seen.at[i][2];
    const double x = point_pad(std::abs(p.x), depth, perspective, reach[0], reach[2]);
    const double y = point_pad(std::abs(p.y), depth, perspective, reach[1], reach[2]);
    for (uint32_t k = 0; k < 4; ++k) {
      points[4 * i + k] = {(k & 1) != 0 ? p.x + x : p.x - x, (k & 2) != 0 ? p.y + y : p.y - y};
    }
  }
  return 4 * seen.count;
}

int column(double x, bool up) {
  const double at = std::clamp(x - 0.5, -32000.0, 32000.0);
  return static_cast<int>(up ? std::ceil(at) : std::floor(at));
}

}  // namespace

Outline outline_of(const ClipPoint corners[8], float near, bool perspective, const float reach[3]) {
  const SeenPoints seen = seen_points(corners, near, perspective);
  Flat points[Outline::kMost];
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
  double sum = 0.0;  // what is not finite stays in it
  for (uint32_t i = 0; i < seen.count; ++i) {
    points[i] = {seen.at[i][0], seen.at[i][1]};
    farthest = std::max({farthest, std::abs(points[i].x), std::abs(points[i].y)});
    sum += points[i].x + points[i].y;
    nearest = std::min(nearest, seen.at[i][2]);
  }
  Outline out;
  if (seen.count == 0 || !std::isfinite(sum)) return out;
  const float widest = std::max(reach[0], reach[1]);
  out.pad = point_pad(farthest, nearest, perspective, widest, reach[2]);
  uint32_t count = seen.count;
  if (out.pad > kWidePad) {
    count = widen(points, seen, perspective, reach);
    out.pad = 0.0;
  }
  wrap(points, count, out);
  return out;
}

void rows_of(const Outline& outline, int first, int count, int16_t* low, int16_t* high) {
  std::fill_n(low, count, int16_t{32000});
  std::fill_n(high, count, int16_t{-32000});
  for (uint32_t i = 0; i < outline.count; ++i) {
    const uint32_t next = i + 1 < outline.count ? i + 1 : 0;
    const bool down = outline.y[i] <= outline.y[next];
    const uint32_t a = down ? i : next, b = down ? next : i;
    const double ax = outline.x[a], ay = outline.y[a], dx = outline.x[b] - ax;
    const double dy = outline.y[b] - ay, pad = outline.pad;
    const int from = std::max(column(ay - pad, true) - first, 0);
    const int to = std::min(column(ay + dy + pad, false) - first, count - 1);
    for (int row = from; row <= to; ++row) {
      // Where the edge is within `pad` of the row's centres.
      const double y = first + row + 0.5 - ay;
      const double t0 = y - pad <= 0.0 ? 0.0 : std::min((y - pad) / dy, 1.0);
      const double t1 = y + pad >= dy ? 1.0 : std::max((y + pad) / dy, 0.0);
      const double x0 = ax + dx * t0, x1 = ax + dx * t1;
      const int l = column(std::min(x0, x1) - pad, true);
      const int h = column(std::max(x0, x1) + pad, false);
      low[row] = static_cast<int16_t>(std::min<int>(low[row], l));
      high[row] = static_cast<int16_t>(std::max<int>(high[row], h));
    }
  }
}

FaceDepths face_depths(const ClipPoint corners[8], float near, bool perspective) {
  using glm::dmat3;
  using glm::dvec3;
  FaceDepths out;
  dvec3 middle(0.0), axes[3] = {dvec3(0.0), dvec3(0.0), dvec3(0.0)};
  double low = corners[0].depth, high = low;
  for (int i = 0; i < 8; ++i) {
    const dvec3 p = 0.125 * dvec3(corners[i].x, corners[i].y, corners[i].depth);
    middle += p;
    for (int axis = 0; axis < 3; ++axis) axes[axis] += i >> axis & 1 ? p : -p;
    low = std::min<double>(low, corners[i].depth);
    high = std::max<double>(high, corners[i].depth);
  }
  const float beyond = std::nextafter(near, std::numeric_limits<float>::infinity());
  out.low = std::max(static_cast<float>(low), beyond);
  out.high = std::max(static_cast<float>(high), beyond);
  const dmat3 box(axes[0], axes[1], axes[2]);
  const double size = length(axes[0]) * length(axes[1]) * length(axes[2]);
  if (!(std::abs(glm::determinant(box)) > 1e-9 * size)) {  // flat: as far as its middle
    out.low = out.high = std::clamp(static_cast<float>(middle.z), out.low, out.high);
    return out;
  }
  const dmat3 rows = glm::transpose(glm::inverse(box));
  for (int i = 0; i < 3; ++i) {
    const dvec3 r = rows[i];
    const double at = dot(r, middle);
    const dvec3 n = perspective ? r : dvec3(0.0, 0.0, r.z);
    const dvec3 o = perspective ? dvec3(0.0, 0.0, at) : dvec3(-r.x, -r.y, at);
    for (int k = 0; k < 3; ++k) {
      out.n[i][k] = static_cast<float>(n[k]);
      out.o[i][k] = static_cast<float>(o[k]);
    }
  }
  return out;
}

}  // namespace sinew
