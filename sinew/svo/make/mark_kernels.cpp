// Marks voxels row by row: a vector of columns at a time, in double, so that neighbours agree.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/svo/make/mark_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <cmath>

#include "sinew/svo/make/voxelize_triangle.h"

#ifndef SINEW_SVO_MARK_KERNELS_SETUP_
#define SINEW_SVO_MARK_KERNELS_SETUP_
namespace sinew {

// a x + b y + c, not negative on the inner side of an edge of the projected triangle, or within a
// voxel's reach of it.
struct EdgeFunction {
  double a = 0.0, b = 0.0, c = 0.0;
};

struct Interval {
  int first = 0, last = -1;
};

// A triangle within a block. Axis w is where the normal is longest; u and v are the two after it.
struct MarkSetup {
  bool thin = true;
  Interval u, v, w;         // voxels that touch the triangle's box
  EdgeFunction along_w[3];  // of (u, v)
  EdgeFunction along_u[3];  // of (v, w)
  EdgeFunction along_v[3];  // of (w, u)
  // The plane's w at the centre of column (u, v) is (a u + b v + c) / depth.
  EdgeFunction plane;
  double depth = 1.0;
  double stride_u = 0.0, stride_v = 0.0, stride_w = 0.0;  // of BlockPlace
};

}  // namespace sinew
#endif  // SINEW_SVO_MARK_KERNELS_SETUP_

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

V set(double x) {
  return hn::Set(D(), x);
}

// Narrows the interval to where a x + c may not be negative. Intervals found by division are wider
// than what is then tested by far less than a column, far more than the division's rounding.
void clip(Interval& x, double a, double c) {
  constexpr double kSlip = 1e-6;
  if (a == 0.0) {
    if (!(c >= 0.0)) x.last = x.first - 1;
    return;
  }
  // Beyond the block anything will do, as long as it can be converted.
  const double at = std::clamp(-c / a, -1e6, 1e6);
  if (a > 0.0) {
    x.first = std::max(x.first, static_cast<int>(std::ceil(at - kSlip)));
  } else {
    x.last = std::min(x.last, static_cast<int>(std::floor(at + kSlip)));
  }
}

// Columns of row v that may have voxels.
Interval columns_of(const MarkSetup& s, double v, int lanes) {
  Interval u = s.u;
  if (u.last - u.first < lanes) return u;
  for (const EdgeFunction& e : s.along_w) clip(u, e.a, e.b * v + e.c);
  // Where the plane passes through the range of w; it is in three voxels of a column at most.
  const double height = s.plane.b * v + s.plane.c;
  clip(u, s.plane.a, height - (s.w.first - 2) * s.depth);
  clip(u, -s.plane.a, (s.w.last + 3) * s.depth - height);
  return u;
}

// An edge's values along a row, where one coordinate is known.
struct RowEdge {
  V slope, start;

  M covers(V x) const { return hn::Ge(hn::Add(hn::Mul(slope, x), start), hn::Zero(D())); }
};

// Its values where neither is.
struct PlaneEdge {
  V a, b, c;

  M covers(V x, V y) const {
    return hn::Ge(hn::Add(hn::Add(hn::Mul(a, x), hn::Mul(b, y)), c), hn::Zero(D()));
  }
};

// One row of columns.
class Row {
 public:
  Row(const MarkSetup& s, double v) : s_(s) {
    for (int i = 0; i < 3; ++i) {
      along_w_[i] = {set(s.along_w[i].a), set(s.along_w[i].b * v + s.along_w[i].c)};
      along_u_[i] = {set(s.along_u[i].b), set(s.along_u[i].a * v + s.along_u[i].c)};
      along_v_[i] = {set(s.along_v[i].a), set(s.along_v[i].b), set(s.along_v[i].c)};
    }
    height_ = set(s.plane.b * v + s.plane.c);
    place_ = set(v * s.stride_v);
  }

  // Those of the columns from u that are not after the last; gives how many places were written.
  size_t mark(int u, int last, BlockPlace* out) const {
    const D d;
    const V x = hn::Add(set(u), hn::ConvertTo(d, hn::Iota(hn::RebindToSigned<D>(), 0)));
    M seen = hn::And(hn::Le(x, set(last)), along_w_[0].covers(x));
    seen = hn::And(seen, hn::And(along_w_[1].covers(x), along_w_[2].covers(x)));
    if (hn::AllFalse(d, seen)) return 0;
    const V depth = set(s_.depth), at = hn::Add(hn::Mul(set(s_.plane.a), x), height_);
    if (s_.thin) {
      const V w = hn::Floor(hn::Div(at, depth));
      const M in_range = hn::And(hn::Ge(w, set(s_.w.first)), hn::Le(w, set(s_.w.last)));
      return put(hn::And(seen, in_range), x, w, out);
    }
    const V reach = set(0.5 * (std::abs(s_.plane.a) + std::abs(s_.plane.b)));
    const V low = hn::Sub(hn::Ceil(hn::Div(hn::Sub(at, reach), depth)), set(1.0));
    const V high = hn::Min(hn::Floor(hn::Div(hn::Add(at, reach), depth)), set(s_.w.last));
    size_t count = 0;
    for (V w = hn::Max(low, set(s_.w.first));; w = hn::Add(w, set(1.0))) {
      const M some = hn::And(seen, hn::Le(w, high));
      if (hn::AllFalse(d, some)) return count;
      count += put(some, x, w, out + count);
    }
  }

 private:
  size_t put(M mask, V u, V w, BlockPlace* out) const {
    const D d;
    const hn::Rebind<int32_t, D> d32;
    const hn::Rebind<uint32_t, D> du32;
    for (int i = 0; i < 3; ++i) mask = hn::And(mask, along_u_[i].covers(w));
    for (int i = 0; i < 3; ++i) mask = hn::And(mask, along_v_[i].covers(w, u));
    const V place =
        hn::Add(hn::Add(hn::Mul(u, set(s_.stride_u)), hn::Mul(w, set(s_.stride_w))), place_);
    // Highway 1.0.3 compresses 64-bit lanes by a table that it copies each time. StoreMaskBits()
    // may write 8 bytes.
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, mask, bits);
    const auto places = hn::BitCast(du32, hn::DemoteTo(d32, place));
    // A whole vector: there is room.
    hn::StoreU(hn::Compress(places, hn::LoadMaskBits(du32, bits)), du32, out);
    return hn::CountTrue(d, mask);
  }

  const MarkSetup& s_;
  RowEdge along_w_[3], along_u_[3];
  PlaneEdge along_v_[3];
  V height_, place_;
};

size_t mark_rows_kernel(const MarkSetup& s, BlockPlace* out) {
  const auto lanes = static_cast<int>(hn::Lanes(D()));
  size_t count = 0;
  for (int v = s.v.first; v <= s.v.last; ++v) {
    const Interval u = columns_of(s, v, lanes);
    if (u.first > u.last) continue;
    const Row row(s, v);
    for (int first = u.first; first <= u.last; first += lanes) {
      count += row.mark(first, u.last, out + count);
    }
  }
  return count;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {
namespace {

using glm::dvec3;

HWY_EXPORT(mark_rows_kernel);

// The edge functions of the triangle seen along one axis, at the centre of voxel (x, y) and as far
// beyond as the voxel reaches. `area` has the sign of the projected area.
void project(const dvec3 (&vertex)[3], int x, int y, double area, bool thin,
             EdgeFunction (&out)[3]) {
  const double sign = area < 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; ++i) {
    const dvec3 &p = vertex[i], &q = vertex[(i + 1) % 3];
    const double a = -(q[y] - p[y]) * sign, b = (q[x] - p[x]) * sign;
    const double size_a = std::abs(a), size_b = std::abs(b);
    const double reach = 0.5 * (thin ? std::max(size_a, size_b) : size_a + size_b);
    out[i] = {a, b, -(a * p[x] + b * p[y]) + 0.5 * (a + b) + reach};
  }
}

// The voxels that touch [low, high], within 0 to `last`.
Interval touched(double low, double high, uint32_t last) {
  const double end = static_cast<double>(last);
  return {static_cast<int>(std::clamp(std::ceil(low) - 1.0, 0.0, end + 1.0)),
          static_cast<int>(std::clamp(std::floor(high), -1.0, end))};
}

}  // namespace

size_t mark_triangle(const GridTriangle& triangle, Shell shell, uvec3 last, BlockPlace* out) {
  const dvec3(&vertex)[3] = triangle.vertex;
  const dvec3 normal = cross(vertex[1] - vertex[0], vertex[2] - vertex[0]), n = abs(normal);
  const int w = n.z >= n.x && n.z >= n.y ? 2 : n.y >= n.x ? 1 : 0;
  const int u = (w + 1) % 3, v = (w + 2) % 3;
  if (!(n[w] > 0.0)) return 0;
  Interval range[3];
  for (int k = 0; k < 3; ++k) {
    range[k] = touched(std::min({vertex[0][k], vertex[1][k], vertex[2][k]}),
                       std::max({vertex[0][k], vertex[1][k], vertex[2][k]}), last[k]);
    if (range[k].first > range[k].last) return 0;
  }
  MarkSetup s;
  s.thin = shell == Shell::thin;
  s.u = range[u];
  s.v = range[v];
  s.w = range[w];
  project(vertex, u, v, normal[w], s.thin, s.along_w);
  project(vertex, v, w, normal[u], s.thin, s.along_u);
  project(vertex, w, u, normal[v], s.thin, s.along_v);
  const dvec3 up = normal[w] < 0.0 ? -normal : normal;
  s.plane = {-up[u], -up[v], dot(up, vertex[0]) - 0.5 * (up[u] + up[v])};
  s.depth = up[w];
  const double strides[3] = {1.0, 64.0, 4096.0};
  s.stride_u = strides[u];
  s.stride_v = strides[v];
  s.stride_w = strides[w];
  return HWY_DYNAMIC_DISPATCH(mark_rows_kernel)(s, out);
}

}  // namespace sinew
#endif  // HWY_ONCE
