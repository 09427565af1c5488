// A ray against eight boxes, and against a packet of four triangles. Included once per target.
// Based on: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013;
// T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Differs: triangle tests take four lanes,
// only lanes with a zero edge function are computed again in double, and the reciprocal of the far
// planes is widened rather than their distance, which is one operation less to wait for.
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/highway.h>
// clang-format on

#if defined(SINEW_BVH_RAY_TESTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_RAY_TESTS_INL_H_
#undef SINEW_BVH_RAY_TESTS_INL_H_
#else
#define SINEW_BVH_RAY_TESTS_INL_H_
#endif

#include <cmath>
#include <cstring>
#include <limits>

#include "sinew/bvh/wide.h"
#include "sinew/math/ray.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D8 = hn::CappedTag<float, 8>;  // eight lanes, or four where registers are small
using D8u = hn::CappedTag<uint32_t, 8>;
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;

// The far distance of a box is widened by this factor: the three roundings of (plane - origin) *
// reciprocal on the near and the far side (Ize 2013), and one for the factor itself.
constexpr float kRobust = 1.0f + 2.0f * 4.0f * 5.97e-8f;

// Boxes count up to this factor beyond the hit so far. A triangle's distance and that of its box
// are rounded differently; without the margin, which of several hits at the same distance is found
// would depend on the order of traversal.
constexpr float kReach = 1.0f + 0x1p-16f;

// Components of a direction that are smaller count as this.
constexpr float kTiny = 1e-37f;

template <class D>
HWY_INLINE uint32_t mask_bits(D d, hn::Mask<D> mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  uint32_t bits;
  std::memcpy(&bits, bytes, sizeof(bits));
  return bits & ((1u << hn::Lanes(d)) - 1u);
}

template <class D>
HWY_INLINE hn::Mask<D> load_mask(D d, uint32_t bits) {
  uint8_t bytes[8] = {};
  std::memcpy(bytes, &bits, sizeof(bits));
  return hn::LoadMaskBits(d, bytes);
}

// kPacked[bits]: which lanes are set, one after another.
struct PackedLanes {
  uint8_t lane[256][8] = {};
  constexpr PackedLanes() {
    for (uint32_t bits = 0; bits < 256; ++bits) {
      uint32_t count = 0;
      for (uint8_t i = 0; i < 8; ++i) {
        if (bits >> i & 1) lane[bits][count++] = i;
      }
    }
  }
};
inline constexpr PackedLanes kPacked;

// Stores the lanes in `bits` one after another, and as many numbers as there are lanes.
HWY_INLINE void store_lanes(D8u d, hn::Vec<D8u> v, uint32_t bits, uint32_t* to) {
#if HWY_TARGET <= HWY_AVX3
  hn::StoreU(hn::Compress(v, load_mask(d, bits)), d, to);
#else  // Highway 1.0 has no fast Compress here: it copies a table every time
  const hn::Rebind<uint8_t, D8u> bytes;
  const auto lanes = hn::PromoteTo(d, hn::LoadU(bytes, kPacked.lane[bits]));
  hn::StoreU(hn::TableLookupLanes(v, hn::IndicesFromVec(d, lanes)), d, to);
#endif
}

// Rays without a direction, or with a number that is not one, meet nothing.
HWY_INLINE bool is_traceable(const Ray& ray) {
  const D4 d;
  const V4 origin = hn::LoadU(d, &ray.origin.x);        // with t_min
  const V4 direction = hn::LoadU(d, &ray.direction.x);  // with t_max, which may be infinite
  const V4 limit = hn::Set(d, std::numeric_limits<float>::max());
  const uint32_t finite = mask_bits(d, hn::Le(hn::Abs(origin), limit)) &
                          (mask_bits(d, hn::Le(hn::Abs(direction), limit)) | 8u);
  const uint32_t large = mask_bits(d, hn::Ge(hn::Abs(direction), hn::Set(d, kTiny)));
  return finite == 15u && (large & 7u) != 0 && ray.t_min <= ray.t_max;
}

// Bit `axis` is set if the direction is negative there; tiny components keep their sign.
HWY_INLINE uint32_t negative_axes(const float* d) {
  const hn::FixedTag<int32_t, 4> di;
  const auto bits = hn::BitCast(di, hn::LoadU(D4(), d));
  return mask_bits(di, hn::Lt(bits, hn::Zero(di))) & 7u;
}

// The axis along which the direction is largest, the first of equals. Without branches.
HWY_INLINE uint32_t largest_axis(const float* d) {
  const float x = std::fabs(d[0]), y = std::fabs(d[1]), z = std::fabs(d[2]);
  const uint32_t z_largest = static_cast<uint32_t>(z > x) & static_cast<uint32_t>(z > y);
  return z_largest << 1 | (static_cast<uint32_t>(y > x) & (z_largest ^ 1u));
}

// kShearAxes[negative][kz]: kx and ky, which keep the winding.
constexpr uint8_t kShearAxes[2][3][2] = {{{1, 2}, {2, 0}, {0, 1}}, {{2, 1}, {0, 2}, {1, 0}}};

// What a ray costs once per space that it enters.
struct RaySetup {
  alignas(16) float origin[4];
  alignas(16) float reciprocal[4];      // of the direction; finite
  alignas(16) float far_reciprocal[4];  // widened by kRobust
  uint32_t near[3], far[3];  // rows of a node: the planes that the ray meets first and last
  uint32_t kx, ky, kz;       // axes; the direction is largest along kz (Woop 2013)
  float shear_x, shear_y, shear_z;

  // Without branches, for neighbours differ. Four floats of both are read, the last is ignored.
  RaySetup(const float* o, const float* d) {
    const D4 d4;
    const V4 tiny = hn::Set(d4, kTiny);
    const V4 direction = hn::LoadU(d4, d);
    const V4 size = hn::Abs(direction);
    // Tiny components are replaced: 0 * infinity would be NaN for origins on a box plane.
    const V4 safe = hn::IfThenElse(hn::Lt(size, tiny), hn::CopySign(tiny, direction), direction);
    const V4 inverse = hn::Div(hn::Set(d4, 1.0f), safe);
    hn::Store(inverse, d4, reciprocal);
    hn::Store(hn::Mul(inverse, hn::Set(d4, kRobust)), d4, far_reciprocal);
    hn::Store(hn::LoadU(d4, o), d4, origin);
    const uint32_t negative = negative_axes(d);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      near[axis] = axis + 3 * (negative >> axis & 1);
      far[axis] = axis + 3 - 3 * (negative >> axis & 1);
    }
    kz = largest_axis(d);
    const uint8_t* axes = kShearAxes[negative >> kz & 1][kz];
    kx = axes[0];
    ky = axes[1];
    shear_z = reciprocal[kz];
    shear_x = d[kx] * shear_z;
    shear_y = d[ky] * shear_z;
  }
};

// Bit i is set if the ray meets child i's box within [t_min, t_max]; entry[i] is where.
HWY_INLINE uint32_t test_boxes(const Node8& node, const RaySetup& ray, float t_min, float t_max,
                               float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;  // three rows of low planes, then three of high ones
  const float* near_x = planes[ray.near[0]];
  const float* near_y = planes[ray.near[1]];
  const float* near_z = planes[ray.near[2]];
  const float* far_x = planes[ray.far[0]];
  const float* far_y = planes[ray.far[1]];
  const float* far_z = planes[ray.far[2]];
  const auto ox = hn::Set(d, ray.origin[0]), oy = hn::Set(d, ray.origin[1]),
             oz = hn::Set(d, ray.origin[2]);
  const auto rx = hn::Set(d, ray.reciprocal[0]), ry = hn::Set(d, ray.reciprocal[1]),
             rz = hn::Set(d, ray.reciprocal[2]);
  const auto fx = hn::Set(d, ray.far_reciprocal[0]), fy = hn::Set(d, ray.far_reciprocal[1]),
             fz = hn::Set(d, ray.far_reciprocal[2]);
  uint32_t bits = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const auto nx = hn::Mul(hn::Sub(hn::Load(d, near_x + i), ox), rx);
    const auto ny = hn::Mul(hn::Sub(hn::Load(d, near_y + i), oy), ry);
    const auto nz = hn::Mul(hn::Sub(hn::Load(d, near_z + i), oz), rz);
    const auto lx = hn::Mul(hn::Sub(hn::Load(d, far_x + i), ox), fx);
    const auto ly = hn::Mul(hn::Sub(hn::Load(d, far_y + i), oy), fy);
    const auto lz = hn::Mul(hn::Sub(hn::Load(d, far_z + i), oz), fz);
    const auto near = hn::Max(hn::Max(nx, ny), hn::Max(nz, hn::Set(d, t_min)));
    const auto far = hn::Min(hn::Min(lx, ly), hn::Min(lz, hn::Set(d, t_max * kReach)));
    hn::Store(near, d, entry + i);
    bits |= mask_bits(d, hn::Le(near, far)) << i;
  }
  return bits;
}

// The same for tests without guarantees: Precision::fast.
struct FastSetup {
  alignas(16) float origin[4];
  alignas(16) float direction[4];
  alignas(16) float reciprocal[4];
  alignas(16) float scaled[4];  // origin * reciprocal
  uint32_t near[3], far[3];

  FastSetup(const float* o, const float* d) {
    const D4 d4;
    const V4 tiny = hn::Set(d4, 1e-18f);  // so that origin * reciprocal stays finite
    const V4 along = hn::LoadU(d4, d), from = hn::LoadU(d4, o);
    const V4 safe = hn::IfThenElse(hn::Lt(hn::Abs(along), tiny), hn::CopySign(tiny, along), along);
    const V4 inverse = hn::Div(hn::Set(d4, 1.0f), safe);
    hn::Store(from, d4, origin);
    hn::Store(along, d4, direction);
    hn::Store(inverse, d4, reciprocal);
    hn::Store(hn::Mul(from, inverse), d4, scaled);
    const uint32_t negative = negative_axes(d);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      near[axis] = axis + 3 * (negative >> axis & 1);
      far[axis] = axis + 3 - 3 * (negative >> axis & 1);
    }
  }
};

HWY_INLINE uint32_t test_boxes(const Node8& node, const FastSetup& ray, float t_min, float t_max,
                               float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;
  const auto rx = hn::Set(d, ray.reciprocal[0]), ry = hn::Set(d, ray.reciprocal[1]),
             rz = hn::Set(d, ray.reciprocal[2]);
  const auto sx = hn::Set(d, ray.scaled[0]), sy = hn::Set(d, ray.scaled[1]),
             sz = hn::Set(d, ray.scaled[2]);
  uint32_t bits = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const auto nx = hn::MulSub(hn::Load(d, planes[ray.near[0]] + i), rx, sx);
    const auto ny = hn::MulSub(hn::Load(d, planes[ray.near[1]] + i), ry, sy);
    const auto nz = hn::MulSub(hn::Load(d, planes[ray.near[2]] + i), rz, sz);
    const auto fx = hn::MulSub(hn::Load(d, planes[ray.far[0]] + i), rx, sx);
    const auto fy = hn::MulSub(hn::Load(d, planes[ray.far[1]] + i), ry, sy);
    const auto fz = hn::MulSub(hn::Load(d, planes[ray.far[2]] + i), rz, sz);
    const auto near = hn::Max(hn::Max(nx, ny), hn::Max(nz, hn::Set(d, t_min)));
    const auto far = hn::Min(hn::Min(fx, fy), hn::Min(fz, hn::Set(d, t_max)));
    hn::Store(near, d, entry + i);
    bits |= mask_bits(d, hn::Le(near, far)) << i;
  }
  return bits;
}

// A packet's hits by one ray, or by some rays with four lanes each.
template <class D>
struct PacketHits {
  static constexpr size_t kLanes = hn::MaxLanes(D());
  uint32_t bits;  // lanes whose triangle is met within [t_min, t_max]
  // Distance; weights of the second and third corner.
  alignas(4 * kLanes) float t[kLanes], v[kLanes], w[kLanes];
};

// Three corners' or edges' values, one triangle or ray a lane. Edge i is opposite corner i.
template <class V>
struct Triple {
  V a, b, c;
};

// Edge functions again in double, where float arithmetic gave zero. By value, so that callers need
// not keep what is hardly ever asked for in memory.
template <class D, class V = hn::Vec<D>>
HWY_NOINLINE Triple<V> exact_edges(D d, V xa, V xb, V xc, V ya, V yb, V yc, Triple<V> edges) {
  constexpr size_t kMost = 16;
  alignas(64) float x[3][kMost], y[3][kMost], e[3][kMost];
  hn::Store(xa, d, x[0]);
  hn::Store(xb, d, x[1]);
  hn::Store(xc, d, x[2]);
  hn::Store(ya, d, y[0]);
  hn::Store(yb, d, y[1]);
  hn::Store(yc, d, y[2]);
  hn::Store(edges.a, d, e[0]);
  hn::Store(edges.b, d, e[1]);
  hn::Store(edges.c, d, e[2]);
  for (int i = 0; i < 3; ++i) {
    const int from = (i + 2) % 3, to = (i + 1) % 3;
    for (size_t lane = 0; lane < hn::Lanes(d); ++lane) {
      if (e[i][lane] != 0) continue;
      e[i][lane] = static_cast<float>(double{x[from][lane]} * double{y[to][lane]} -
                                      double{y[from][lane]} * double{x[to][lane]});
    }
  }
  return {hn::Load(d, e[0]), hn::Load(d, e[1]), hn::Load(d, e[2])};
}

// Lanes in which the edge functions have no different signs.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Mask<D> signs_agree(D d, const Triple<V>& e) {
  const V zero = hn::Zero(d);
  return hn::Or(hn::Ge(hn::Min(hn::Min(e.a, e.b), e.c), zero),
                hn::Le(hn::Max(hn::Max(e.a, e.b), e.c), zero));
}

// Corners relative to the ray's origin, moved so that the ray runs along the third axis.
template <class V>
HWY_INLINE Triple<V> sheared(const Triple<V>& corner, V shear, const Triple<V>& z) {
  return {hn::Sub(corner.a, hn::Mul(shear, z.a)), hn::Sub(corner.b, hn::Mul(shear, z.b)),
          hn::Sub(corner.c, hn::Mul(shear, z.c))};
}

// The distance of the hit, times the sum of the edge functions.
template <class V>
HWY_INLINE V scaled_distance(const Triple<V>& e, const Triple<V>& z, V shear_z) {
  return hn::Mul(shear_z,
                 hn::Add(hn::Add(hn::Mul(e.a, z.a), hn::Mul(e.b, z.b)), hn::Mul(e.c, z.c)));
}

// The edge functions of triangles in the ray's sheared space (Woop 2013), and the lanes in which
// they agree. Zeros count only there, so only there they are looked for.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Mask<D> test_edges(D d, const Triple<V>& x, const Triple<V>& y, Triple<V>& e) {
  e = {hn::Sub(hn::Mul(x.c, y.b), hn::Mul(y.c, x.b)), hn::Sub(hn::Mul(x.a, y.c), hn::Mul(y.a, x.c)),
       hn::Sub(hn::Mul(x.b, y.a), hn::Mul(y.b, x.a))};
  auto agree = signs_agree(d, e);
  if (hn::AllFalse(d, agree)) return agree;
  const V zero = hn::Zero(d);
  const auto any_zero = hn::Or(hn::Or(hn::Eq(e.a, zero), hn::Eq(e.b, zero)), hn::Eq(e.c, zero));
  if (HWY_UNLIKELY(!hn::AllFalse(d, hn::And(agree, any_zero)))) {
    e = exact_edges(d, x.a, x.b, x.c, y.a, y.b, y.c, e);
    agree = signs_agree(d, e);
  }
  return agree;
}

// What the watertight test needs of rays: one ray in all lanes, or some with four lanes each. They
// share their axes.
template <class D>
struct WatertightRays {
  using V = hn::Vec<D>;
  uint32_t kx, ky, kz;
  V x, y, z;  // of the origin, along those axes
  V shear_x, shear_y, shear_z;
  V t_min;
};
HWY_INLINE WatertightRays<D4> lanes_of(const RaySetup& ray, float t_min) {
  const D4 d;
  return {ray.kx,
          ray.ky,
          ray.kz,
          hn::Set(d, ray.origin[ray.kx]),
          hn::Set(d, ray.origin[ray.ky]),
          hn::Set(d, ray.origin[ray.kz]),
          hn::Set(d, ray.shear_x),
          hn::Set(d, ray.shear_y),
          hn::Set(d, ray.shear_z),
          hn::Set(d, t_min)};
}

// `side` is 0, or the sign that the determinant must have: 1 for front faces, -1 for back faces.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void test_packet(D d, const TrianglePacket& packet, const WatertightRays<D>& rays,
                            V t_max, float side, PacketHits<D>& out) {
  const V zero = hn::Zero(d);
  const auto along = [&](uint32_t axis, V origin) {
    return Triple<V>{hn::Sub(hn::LoadDup128(d, packet.v[0][axis]), origin),
                     hn::Sub(hn::LoadDup128(d, packet.v[1][axis]), origin),
                     hn::Sub(hn::LoadDup128(d, packet.v[2][axis]), origin)};
  };
  const Triple<V> z = along(rays.kz, rays.z);
  const Triple<V> x = sheared(along(rays.kx, rays.x), rays.shear_x, z);
  const Triple<V> y = sheared(along(rays.ky, rays.y), rays.shear_y, z);
  Triple<V> e;
  auto hit = test_edges(d, x, y, e);
  out.bits = 0;
  if (hn::AllFalse(d, hit)) return;
  const V det = hn::Add(hn::Add(e.a, e.b), e.c);
  const V t = hn::Div(scaled_distance(e, z, rays.shear_z), det);
  hit = hn::And(hit, hn::Ne(det, zero));
  hit = hn::And(hit, hn::And(hn::Ge(t, rays.t_min), hn::Le(t, t_max)));
  hit = hn::And(hit, hn::Ge(hn::Mul(det, hn::Set(d, side)), zero));
  out.bits = mask_bits(d, hit);
  if (out.bits == 0) return;
  hn::Store(t, d, out.t);
  hn::Store(hn::Div(e.b, det), d, out.v);
  hn::Store(hn::Div(e.c, det), d, out.w);
}

// Three components of vectors.
template <class V>
struct Rows3 {
  V x, y, z;
};
template <class V>
HWY_INLINE Rows3<V> minus(const Rows3<V>& a, const Rows3<V>& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V>
HWY_INLINE Rows3<V> cross(const Rows3<V>& a, const Rows3<V>& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE V dot(const Rows3<V>& a, const Rows3<V>& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

// The same as WatertightRays, for the test without guarantees.
template <class D>
struct FastRays {
  using V = hn::Vec<D>;
  Rows3<V> origin, direction;
  V t_min;
};
HWY_INLINE FastRays<D4> lanes_of(const FastSetup& ray, float t_min) {
  const D4 d;
  const auto spread = [&](const float* p) {
    return Rows3<V4>{hn::Set(d, p[0]), hn::Set(d, p[1]), hn::Set(d, p[2])};
  };
  return {spread(ray.origin), spread(ray.direction), hn::Set(d, t_min)};
}

// T. Moller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1), 1997.
// Differs: divides only if a lane is hit.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void test_packet(D d, const TrianglePacket& packet, const FastRays<D>& rays, V t_max,
                            float side, PacketHits<D>& out) {
  const auto corner = [&](int i) {
    return Rows3<V>{hn::LoadDup128(d, packet.v[i][0]), hn::LoadDup128(d, packet.v[i][1]),
                    hn::LoadDup128(d, packet.v[i][2])};
  };
  const Rows3<V> v0 = corner(0), along = rays.direction;
  const Rows3<V> a = minus(corner(1), v0), b = minus(corner(2), v0);
  const Rows3<V> p = cross(along, b), from = minus(rays.origin, v0), q = cross(from, a);
  const V det = dot(a, p), zero = hn::Zero(d);
  const V size = hn::Abs(det);
  const V sign = hn::AndNot(size, det);  // its sign bit
  const V u = hn::Xor(dot(from, p), sign), v = hn::Xor(dot(along, q), sign);
  auto hit = hn::And(hn::Ge(hn::Min(u, v), zero), hn::Le(hn::Add(u, v), size));
  hit = hn::And(hit, hn::Gt(size, zero));
  out.bits = 0;
  if (hn::AllFalse(d, hit)) return;
  const V t = hn::Div(dot(b, q), det);
  hit = hn::And(hit, hn::And(hn::Ge(t, rays.t_min), hn::Le(t, t_max)));
  hit = hn::And(hit, hn::Ge(hn::Mul(det, hn::Set(d, side)), zero));
  out.bits = mask_bits(d, hit);
  if (out.bits == 0) return;
  hn::Store(t, d, out.t);
  hn::Store(hn::Div(u, size), d, out.v);
  hn::Store(hn::Div(v, size), d, out.w);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
