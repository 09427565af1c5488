// Triangles against rays of a group. Where many rays reach a leaf, vectors of them are tested
// against one triangle after another; where few do, as where triangles are small, lanes are filled
// by a packet's four triangles as well, once for each ray. Included once per target.
#if defined(SINEW_BVH_GROUP_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_GROUP_TRIANGLES_INL_H_
#undef SINEW_BVH_GROUP_TRIANGLES_INL_H_
#else
#define SINEW_BVH_GROUP_TRIANGLES_INL_H_
#endif

#include "sinew/bvh/trace/ray_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

constexpr uint32_t kLanesARay = kPacket;
constexpr uint32_t kTogether = static_cast<uint32_t>(hn::MaxLanes(DG())) / kLanesARay;

// As many rays of a mask as are tested together. Those beyond `count` repeat the last.
struct FewRays {
  uint32_t count = 0;
  uint32_t ray[kTogether];

  // Takes them out of the mask, which must hold some.
  HWY_INLINE explicit FewRays(uint64_t& mask) {
    uint32_t last = 0;
    for (uint32_t& place : ray) {
      const bool more = mask != 0;
      last = more ? static_cast<uint32_t>(__builtin_ctzll(mask)) : last;
      place = last;
      mask &= mask - more;
      count += more;
    }
  }
  uint32_t lanes() const { return (1u << (kLanesARay * count)) - 1u; }
  uint32_t ray_of(uint32_t lane) const { return ray[lane / kLanesARay]; }
  // The lanes of the same ray.
  static uint32_t lanes_with(uint32_t lane) {
    return ((1u << kLanesARay) - 1u) << (lane / kLanesARay * kLanesARay);
  }
};

// One vector of part(0), part(1) ..., four lanes each.
template <class D, class Part>
HWY_INLINE hn::Vec<D> join(D d, const Part& part, uint32_t first = 0) {
  if constexpr (hn::MaxLanes(D()) == kLanesARay) {
    return part(first);
  } else {
    const hn::Half<D> half;
    const auto low = join(half, part, first);
    constexpr auto kParts = static_cast<uint32_t>(hn::MaxLanes(hn::Half<D>())) / kLanesARay;
    return hn::Combine(d, join(half, part, first + kParts), low);
  }
}
// A row of each ray.
HWY_INLINE hn::Vec<DG> load_rows(const float (*rows)[4], const FewRays& few) {
  return join(DG(), [&](uint32_t i) { return hn::Load(D4(), rows[few.ray[i]]); });
}
// A number of each ray, in all its lanes.
HWY_INLINE hn::Vec<DG> load_each(const float* numbers, const FewRays& few) {
  return join(DG(), [&](uint32_t i) { return hn::Set(D4(), numbers[few.ray[i]]); });
}

// How triangles are tested that few rays reach: what becomes the rows of rays i and following, and
// rows in lanes.
struct WatertightTriangles {
  static HWY_INLINE void prepare(RayGroup& group, size_t i) {
    const DG d;
    hn::StoreInterleaved4(
        hn::Load(d, group.origin[group.kx] + i), hn::Load(d, group.origin[group.ky] + i),
        hn::Load(d, group.origin[group.kz] + i), hn::Load(d, group.t_min + i), d, group.row[0][i]);
    hn::StoreInterleaved4(hn::Load(d, group.shear_x + i), hn::Load(d, group.shear_y + i),
                          hn::Load(d, group.shear_z + i), hn::Zero(d), d, group.row[1][i]);
  }
  static HWY_INLINE WatertightRays<DG> lanes_of(const RayGroup& group, const FewRays& few) {
    const auto from = load_rows(group.row[0], few), shear = load_rows(group.row[1], few);
    return {group.kx,
            group.ky,
            group.kz,
            hn::Broadcast<0>(from),
            hn::Broadcast<1>(from),
            hn::Broadcast<2>(from),
            hn::Broadcast<0>(shear),
            hn::Broadcast<1>(shear),
            hn::Broadcast<2>(shear),
            hn::Broadcast<3>(from)};
  }
};

struct FastTriangles {
  static HWY_INLINE void prepare(RayGroup& group, size_t i) {
    const DG d;
    hn::StoreInterleaved4(hn::Load(d, group.origin[0] + i), hn::Load(d, group.origin[1] + i),
                          hn::Load(d, group.origin[2] + i), hn::Load(d, group.t_min + i), d,
                          group.row[0][i]);
    hn::StoreInterleaved4(hn::Load(d, group.direction[0] + i), hn::Load(d, group.direction[1] + i),
                          hn::Load(d, group.direction[2] + i), hn::Zero(d), d, group.row[1][i]);
  }
  static HWY_INLINE FastRays<DG> lanes_of(const RayGroup& group, const FewRays& few) {
    const auto from = load_rows(group.row[0], few), along = load_rows(group.row[1], few);
    return {{hn::Broadcast<0>(from), hn::Broadcast<1>(from), hn::Broadcast<2>(from)},
            {hn::Broadcast<0>(along), hn::Broadcast<1>(along), hn::Broadcast<2>(along)},
            hn::Broadcast<3>(from)};
  }
};

// One triangle of a packet against the rays of `mask`, some vectors of them. hit(first ray, bits,
// t, v, w) is called for vectors with hits.
template <class OnHit>
HWY_INLINE void test_triangle(const TrianglePacket& packet, uint32_t lane, const RayGroup& group,
                              uint64_t mask, float side, const OnHit& on_hit) {
  const DG d;
  using V = hn::Vec<DG>;
  const V zero = hn::Zero(d);
  for (size_t i = 0; i < group.count; i += hn::Lanes(d)) {
    const auto part = static_cast<uint32_t>(mask >> i) & ((1u << hn::Lanes(d)) - 1u);
    if (part == 0) continue;
    const auto along = [&](uint32_t axis) {
      const V origin = hn::Load(d, group.origin[axis] + i);
      return Triple<V>{hn::Sub(hn::Set(d, packet.v[0][axis][lane]), origin),
                       hn::Sub(hn::Set(d, packet.v[1][axis][lane]), origin),
                       hn::Sub(hn::Set(d, packet.v[2][axis][lane]), origin)};
    };
    const Triple<V> z = along(group.kz);
    const Triple<V> x = sheared(along(group.kx), hn::Load(d, group.shear_x + i), z);
    const Triple<V> y = sheared(along(group.ky), hn::Load(d, group.shear_y + i), z);
    Triple<V> e;
    auto hit = test_edges(d, x, y, e);
    if ((mask_bits(d, hit) & part) == 0) continue;
    const V det = hn::Add(hn::Add(e.a, e.b), e.c);
    const V t = hn::Div(scaled_distance(e, z, hn::Load(d, group.shear_z + i)), det);
    hit = hn::And(hit, hn::Ne(det, zero));
    hit = hn::And(
        hit, hn::And(hn::Ge(t, hn::Load(d, group.t_min + i)), hn::Le(t, hn::Load(d, group.t + i))));
    hit = hn::And(hit, hn::Ge(hn::Mul(det, hn::Set(d, side)), zero));
    const uint32_t bits = mask_bits(d, hit) & part;
    if (bits != 0) on_hit(i, bits, t, hn::Div(e.b, det), hn::Div(e.c, det));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
