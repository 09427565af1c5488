#include "sinew/svo/voxelize_triangle.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

using glm::dvec3;

// Far less than what matters, far more than the rounding of a crossing between 0 and 64: intervals
// found by division are this much wider than what is then tested.
constexpr double kSlip = 1e-6;

// a x + b y + c, not negative on the inner side of an edge of the projected triangle.
struct EdgeFunction {
  double a = 0.0, b = 0.0, c = 0.0;
  double operator()(double x, double y) const { return a * x + b * y + c; }
};

// The triangle seen along one axis: whether the shell has voxel (x, y) as far as that tells.
struct Projection {
  EdgeFunction edge[3];

  bool covers(double x, double y) const {
    return edge[0](x, y) >= 0.0 && edge[1](x, y) >= 0.0 && edge[2](x, y) >= 0.0;
  }
};

// The edge functions at the centre of voxel (x, y). `area` has the sign of the projected area.
Projection project(const dvec3 (&vertex)[3], int x, int y, double area) {
  Projection out;
  const double sign = area < 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; ++i) {
    const dvec3 &p = vertex[i], &q = vertex[(i + 1) % 3];
    const double a = -(q[y] - p[y]) * sign, b = (q[x] - p[x]) * sign;
    out.edge[i] = {a, b, -(a * p[x] + b * p[y]) + 0.5 * (a + b)};
  }
  return out;
}

// How far a voxel reaches beyond its centre, across the edge.
void widen(Projection& projection, Shell shell) {
  for (EdgeFunction& e : projection.edge) {
    const double a = std::abs(e.a), b = std::abs(e.b);
    e.c += 0.5 * (shell == Shell::thin ? std::max(a, b) : a + b);
  }
}

struct Interval {
  int first = 0, last = -1;
};

// What of the interval may have a x + c >= 0, surely containing what has; `inner`: surely has.
void clip(Interval& x, double a, double c, bool inner) {
  if (a == 0.0) {
    if (!(c >= (inner ? kSlip : 0.0))) x.last = x.first - 1;
    return;
  }
  // Beyond the interval anything will do, as long as it can be converted.
  const double at = std::clamp(-c / a, -1e6, 1e6), slip = inner ? kSlip : -kSlip;
  if (a > 0.0) {
    x.first = std::max(x.first, static_cast<int>(std::ceil(at + slip)));
  } else {
    x.last = std::min(x.last, static_cast<int>(std::floor(at - slip)));
  }
}

// The voxels that touch [low, high], within 0 to `last`.
Interval touched(double low, double high, uint32_t last) {
  const double end = static_cast<double>(last);
  return {static_cast<int>(std::clamp(std::ceil(low) - 1.0, 0.0, end + 1.0)),
          static_cast<int>(std::clamp(std::floor(high), -1.0, end))};
}

// The work on one triangle. Axis w is where the normal is longest; u and v are the two after it.
class Marker {
 public:
  Marker(const GridTriangle& triangle, Shell shell, uvec3 last, std::vector<BlockPlace>& out)
      : vertex_(triangle.vertex), shell_(shell), out_(out) {
    const dvec3 e1 = vertex_[1] - vertex_[0], e2 = vertex_[2] - vertex_[0];
    const dvec3 normal = cross(e1, e2), n = abs(normal);
    w_ = n.z >= n.x && n.z >= n.y ? 2 : n.y >= n.x ? 1 : 0;
    u_ = (w_ + 1) % 3;
    v_ = (w_ + 2) % 3;
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({vertex_[0][k], vertex_[1][k], vertex_[2][k]});
      range_[k] = touched(low, high, last[k]);
      stride_[k] = 1u << (6 * k);
    }
    along_w_ = project(vertex_, u_, v_, normal[w_]);
    inner_ = along_w_;
    along_u_ = project(vertex_, v_, w_, normal[u_]);
    along_v_ = project(vertex_, w_, u_, normal[v_]);
    widen(along_w_, shell);
    widen(along_u_, shell);
    widen(along_v_, shell);
    set_plane(normal);
  }

  void run() {
    if (range_[w_].last < range_[w_].first || !(depth_ > 0.0)) return;
    for (int v = range_[v_].first; v <= range_[v_].last; ++v) {
      if (shell_ == Shell::thin) {
        mark_thin_row(v);
      } else {
        mark_conservative_row(v);
      }
    }
  }

 private:
  // The plane's w at the centre of column (u, v) is (plane_.a u + plane_.b v + plane_.c) / depth_.
  void set_plane(const dvec3& normal) {
    const double sign = normal[w_] < 0.0 ? -1.0 : 1.0;
    const dvec3 n = sign * normal;
    depth_ = n[w_];
    plane_ = {-n[u_], -n[v_], dot(n, vertex_[0]) - 0.5 * (n[u_] + n[v_])};
  }

  // Columns of the row that may have voxels.
  Interval columns(int v) const {
    Interval u = range_[u_];
    for (const EdgeFunction& e : along_w_.edge) clip(u, e.a, e.b * v + e.c, false);
    // Where the plane passes through the range of w; a column is two voxels high at most.
    const double height = plane_.b * v + plane_.c;
    clip(u, plane_.a, height - (range_[w_].first - 2) * depth_, false);
    clip(u, -plane_.a, (range_[w_].last + 3) * depth_ - height, false);
    return u;
  }

  bool others_cover(int u, int v, int w) const {
    return along_u_.covers(v, w) && along_v_.covers(w, u);
  }

  void put(int u, int v, int w) {
    out_.push_back(static_cast<uint32_t>(u) * stride_[u_] + static_cast<uint32_t>(v) * stride_[v_] +
                   static_cast<uint32_t>(w) * stride_[w_]);
  }

  int plane_voxel(int u, double height) const {
    return static_cast<int>(std::floor((plane_.a * u + height) / depth_));
  }

  // The one voxel of the column that the plane passes through at its centre line.
  void mark_thin_column(int u, int v, double height) {
    if (!along_w_.covers(u, v)) return;
    const double at = std::floor((plane_.a * u + height) / depth_);
    if (!(at >= range_[w_].first && at <= range_[w_].last)) return;
    const int w = static_cast<int>(at);
    if (others_cover(u, v, w)) put(u, v, w);
  }

  void mark_thin_row(int v) {
    const Interval u = columns(v);
    if (u.first > u.last) return;
    // Columns whose centre line meets the triangle: there is nothing else to test.
    Interval inner = u;
    for (const EdgeFunction& e : inner_.edge) clip(inner, e.a, e.b * v + e.c, true);
    if (inner.first > inner.last) inner = {u.last + 1, u.last};
    const double height = plane_.b * v + plane_.c;
    for (int i = u.first; i < inner.first; ++i) mark_thin_column(i, v, height);
    for (int i = inner.first; i <= inner.last; ++i) {
      const int w = plane_voxel(i, height);
      if (w >= range_[w_].first && w <= range_[w_].last) put(i, v, w);
    }
    for (int i = inner.last + 1; i <= u.last; ++i) mark_thin_column(i, v, height);
  }

  void mark_conservative_row(int v) {
    const Interval columns_of_row = columns(v);
    const double height = plane_.b * v + plane_.c;
    const double reach = 0.5 * (std::abs(plane_.a) + std::abs(plane_.b));
    for (int u = columns_of_row.first; u <= columns_of_row.last; ++u) {
      if (!along_w_.covers(u, v)) continue;
      const double at = plane_.a * u + height;
      const double low = std::ceil((at - reach) / depth_) - 1.0;
      const double high = std::floor((at + reach) / depth_);
      const int first = static_cast<int>(std::max<double>(low, range_[w_].first));
      const int last = static_cast<int>(std::min<double>(high, range_[w_].last));
      for (int w = first; w <= last; ++w) {
        if (others_cover(u, v, w)) put(u, v, w);
      }
    }
  }

  const dvec3 (&vertex_)[3];
  Shell shell_;
  std::vector<BlockPlace>& out_;
  int u_ = 0, v_ = 1, w_ = 2;
  uint32_t stride_[3] = {};
  Interval range_[3];
  Projection along_u_, along_v_, along_w_;  // widened by the voxel
  Projection inner_;                        // along w, not widened
  EdgeFunction plane_;
  double depth_ = 1.0;
};

}  // namespace

void mark_triangle(const GridTriangle& triangle, Shell shell, uvec3 last,
                   std::vector<BlockPlace>& out) {
  Marker(triangle, shell, last, out).run();
}

}  // namespace sinew
