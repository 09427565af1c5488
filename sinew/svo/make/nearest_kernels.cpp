#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/svo/make/nearest_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/svo/make/nearest_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

struct Vector3 {
  V x, y, z;
};

V dot_of(const Vector3& p, const vec3& q) {
  const D d;
  return hn::MulAdd(p.x, hn::Set(d, q.x),
                    hn::MulAdd(p.y, hn::Set(d, q.y), hn::Mul(p.z, hn::Set(d, q.z))));
}

HWY_INLINE V saturate(V x) {
  const D d;
  return hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, 1.0f));
}

// From the triangle's first vertex to the voxels' centres.
Vector3 centers_of(const NearestSetup& setup, const BlockPlace* places) {
  const D d;
  const hn::Rebind<uint32_t, D> du;
  const hn::Rebind<int32_t, D> di;
  const auto place = hn::LoadU(du, places);
  const auto mask = hn::Set(du, 63);
  const auto at = [&](auto bits, float offset) {
    return hn::Add(hn::ConvertTo(d, hn::BitCast(di, hn::And(bits, mask))), hn::Set(d, offset));
  };
  return {at(place, setup.offset.x), at(hn::ShiftRight<6>(place), setup.offset.y),
          at(hn::ShiftRight<12>(place), setup.offset.z)};
}

// The squared distance of p from the point with weights (u, v), less that of p from the first
// vertex. d1 and d2 are the products of p with the edges.
V distance2(const NearestSetup& setup, V d1, V d2, V u, V v) {
  const D d;
  const V u_part = hn::Sub(hn::Mul(u, hn::Set(d, setup.dot11)), hn::Add(d1, d1));
  const V v_part = hn::Sub(hn::Mul(v, hn::Set(d, setup.dot22)), hn::Add(d2, d2));
  const V both = hn::Mul(hn::Mul(u, v), hn::Set(d, 2.0f * setup.dot12));
  return hn::MulAdd(u, u_part, hn::MulAdd(v, v_part, both));
}

// The nearest point of the triangle's border.
void clamp_to_edges(const NearestSetup& setup, const Vector3& p, V& u, V& v) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V d1 = dot_of(p, setup.edge1), d2 = dot_of(p, setup.edge2);
  const V on1 = saturate(hn::Mul(d1, hn::Set(d, setup.inverse11)));
  const V on2 = saturate(hn::Mul(d2, hn::Set(d, setup.inverse22)));
  const V along = hn::Sub(hn::Sub(d2, d1), hn::Set(d, setup.dot12 - setup.dot11));
  const V on3 = saturate(hn::Mul(along, hn::Set(d, setup.inverse33)));
  u = on1;
  v = zero;
  V best = distance2(setup, d1, d2, on1, zero);
  const V at2 = distance2(setup, d1, d2, zero, on2);
  const auto nearer2 = hn::Lt(at2, best);
  u = hn::IfThenElse(nearer2, zero, u);
  v = hn::IfThenElse(nearer2, on2, v);
  best = hn::Min(best, at2);
  const V at3 = distance2(setup, d1, d2, hn::Sub(one, on3), on3);
  const auto nearer3 = hn::Lt(at3, best);
  u = hn::IfThenElse(nearer3, hn::Sub(one, on3), u);
  v = hn::IfThenElse(nearer3, on3, v);
}

}  // namespace

void nearest_points_kernel(const NearestSetup& setup, const BlockPlace* places, size_t count,
                           float* out_u, float* out_v) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  HWY_ALIGN BlockPlace rest[HWY_MAX_BYTES / sizeof(BlockPlace)] = {};
  HWY_ALIGN float rest_u[HWY_MAX_BYTES / sizeof(float)], rest_v[HWY_MAX_BYTES / sizeof(float)];
  for (size_t i = 0; i < count; i += lanes) {
    const bool whole = count - i >= lanes;
    for (size_t k = i; !whole && k < count; ++k) rest[k - i] = places[k];
    const Vector3 p = centers_of(setup, whole ? places + i : rest);
    const V zero = hn::Zero(d);
    V u = dot_of(p, setup.dual1), v = dot_of(p, setup.dual2);
    const auto outside = hn::Not(hn::And(hn::And(hn::Ge(u, zero), hn::Ge(v, zero)),
                                         hn::Le(hn::Add(u, v), hn::Set(d, 1.0f))));
    if (!hn::AllFalse(d, outside)) {
      V edge_u, edge_v;
      clamp_to_edges(setup, p, edge_u, edge_v);
      u = hn::IfThenElse(outside, edge_u, u);
      v = hn::IfThenElse(outside, edge_v, v);
    }
    hn::StoreU(u, d, whole ? out_u + i : rest_u);
    hn::StoreU(v, d, whole ? out_v + i : rest_v);
    for (size_t k = i; !whole && k < count; ++k) {
      out_u[k] = rest_u[k - i];
      out_v[k] = rest_v[k - i];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(nearest_points_kernel);

NearestSetup make_nearest_setup(const GridTriangle& triangle) {
  using glm::dvec3;
  const dvec3 e1 = triangle.vertex[1] - triangle.vertex[0];
  const dvec3 e2 = triangle.vertex[2] - triangle.vertex[0], e3 = e2 - e1;
  const double dot11 = dot(e1, e1), dot12 = dot(e1, e2), dot22 = dot(e2, e2);
  const dvec3 normal = cross(e1, e2);
  const double area2 = dot(normal, normal);
  const auto inverse = [](double x) {
    const double y = 1.0 / x;
    return std::isfinite(static_cast<float>(y)) ? static_cast<float>(y) : 0.0f;
  };
  NearestSetup setup;
  setup.offset = vec3(dvec3(0.5) - triangle.vertex[0]);
  setup.edge1 = vec3(e1);
  setup.edge2 = vec3(e2);
  setup.dual1 = vec3((dot22 * e1 - dot12 * e2) / area2);
  setup.dual2 = vec3((dot11 * e2 - dot12 * e1) / area2);
  setup.dot11 = static_cast<float>(dot11);
  setup.dot12 = static_cast<float>(dot12);
  setup.dot22 = static_cast<float>(dot22);
  setup.inverse11 = inverse(dot11);
  setup.inverse22 = inverse(dot22);
  setup.inverse33 = inverse(dot(e3, e3));
  return setup;
}

void nearest_points(const NearestSetup& setup, const BlockPlace* places, size_t count, float* u,
                    float* v) {
  HWY_DYNAMIC_DISPATCH(nearest_points_kernel)(setup, places, count, u, v);
}

}  // namespace sinew
#endif  // HWY_ONCE
