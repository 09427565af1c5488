// Up to 64 rays whose directions have the same signs and the same largest axis, as structure of
// arrays, and their tests: all of them against eight boxes at once by interval arithmetic, and
// sixteen rays at a time against one box or one triangle. Included once per target.
// Based on: S. Boulos et al., "Packet-based Whitted and Distribution Ray Tracing", GI 2007
// (interval tests); R. Barringer, T. Akenine-Moller, "Dynamic Ray Stream Traversal", SIGGRAPH 2014
// (streams of active rays). The arithmetic for each ray is that of ray_tests-inl.h, so the hits
// have the same bits.
#if defined(SINEW_BVH_RAY_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_RAY_GROUP_INL_H_
#undef SINEW_BVH_RAY_GROUP_INL_H_
#else
#define SINEW_BVH_RAY_GROUP_INL_H_
#endif

#include "sinew/bvh/trace/ray_tests-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

constexpr uint32_t kGroup = 64;       // bits of a mask of rays
using DG = hn::CappedTag<float, 16>;  // rays tested together
using DGu = hn::CappedTag<uint32_t, 16>;

// Vectors of a group that hold rays of the mask.
HWY_INLINE uint32_t count_vectors(uint64_t mask) {
  const uint32_t lanes = static_cast<uint32_t>(hn::Lanes(DG()));
  uint32_t count = 0;
  for (uint32_t i = 0; i < kGroup; i += lanes) {
    count += (mask >> i & ((1u << lanes) - 1u)) != 0;
  }
  return count;
}

// Rays may stand in one group if this is equal: signs of the direction, and its largest axis.
HWY_INLINE uint32_t group_class(const float* direction) {
  return negative_axes(direction) | largest_axis(direction) << 3;
}
constexpr uint32_t kGroupClasses = 3 << 3;

// As many rays as a vector has lanes, as structure of arrays.
HWY_INLINE void load_rays(const Ray* rays, hn::Vec<DG>* HWY_RESTRICT origin,
                          hn::Vec<DG>* HWY_RESTRICT direction) {
  static_assert(sizeof(Ray) == 8 * sizeof(float));
  const DG d;
  const float* const numbers = &rays[0].origin.x;
  hn::Vec<DG> low[4], high[4];  // origins and directions in turn
  hn::LoadInterleaved4(d, numbers, low[0], low[1], low[2], low[3]);
  hn::LoadInterleaved4(d, numbers + 4 * hn::Lanes(d), high[0], high[1], high[2], high[3]);
  for (int i = 0; i < 4; ++i) {
    origin[i] = hn::ConcatEven(d, high[i], low[i]);
    direction[i] = hn::ConcatOdd(d, high[i], low[i]);
  }
}

// Whether rays are traceable and of the first one's class, a vector of them at a time.
class RunOfOneClass {
 public:
  explicit RunOfOneClass(const Ray& first)
      : negative_(negative_axes(&first.direction.x)), largest_(largest_axis(&first.direction.x)) {}

  HWY_INLINE bool includes(const hn::Vec<DG>* origin, const hn::Vec<DG>* direction) const {
    const DG d;
    const auto limit = hn::Set(d, std::numeric_limits<float>::max());
    const auto x = hn::Abs(direction[0]), y = hn::Abs(direction[1]), z = hn::Abs(direction[2]);
    auto good = hn::Le(origin[3], direction[3]);  // t_min <= t_max
    good = hn::And(good, hn::Le(hn::Abs(origin[3]), limit));
    for (int axis = 0; axis < 3; ++axis) {
      good = hn::And(good, hn::Le(hn::Abs(origin[axis]), limit));
      const auto as_asked =
          hn::Set(d, negative_ >> axis & 1 ? -1.0f : 1.0f);  // CopySign keeps that of zeros
      good = hn::And(
          good, hn::Gt(hn::Mul(hn::CopySign(as_asked, direction[axis]), as_asked), hn::Zero(d)));
    }
    // In the order of largest_axis; what is largest is finite and not tiny.
    const auto is_z = hn::And(hn::Gt(z, x), hn::Gt(z, y));
    const auto is_y = hn::AndNot(is_z, hn::Gt(y, x));
    const auto is_x = hn::Not(hn::Or(is_z, is_y));
    good = hn::And(good, largest_ == 2 ? is_z : largest_ == 1 ? is_y : is_x);
    const auto most = hn::Max(hn::Max(x, y), z);
    good = hn::And(good, hn::And(hn::Le(x, limit), hn::And(hn::Le(y, limit), hn::Le(z, limit))));
    good = hn::And(good, hn::Ge(most, hn::Set(d, kTiny)));
    return hn::AllTrue(d, good);
  }

 private:
  uint32_t negative_, largest_;
};

struct alignas(64) RayGroup {
  uint32_t count = 0;
  uint64_t alive = 0;        // rays that still seek a hit
  uint32_t near[3], far[3];  // rows of a node, as in RaySetup
  uint32_t kx, ky, kz;
  float least_t_min, most_t;

  alignas(64) float origin[3][kGroup];
  alignas(64) float direction[3][kGroup];
  alignas(64) float reciprocal[3][kGroup];
  alignas(64) float far_reciprocal[3][kGroup];
  alignas(64) float shear_x[kGroup], shear_y[kGroup], shear_z[kGroup];
  alignas(64) float t_min[kGroup];
  // The best hit so far; t is t_max before.
  alignas(64) float t[kGroup], v[kGroup], w[kGroup];
  alignas(64) uint32_t primitive[kGroup], object[kGroup];
  alignas(64) uint32_t ray[kGroup];  // of the span

  // What bounds the group: of the origins the side that is met first or last, and the least and
  // most reciprocals.
  struct Interval {
    float origin, least, most;
  };
  Interval near_bound[3], far_bound[3];

  // What triangle tests need of each ray, as the test prepares it: see group_triangles-inl.h.
  alignas(64) float row[2][kGroup][4];

  RayGroup() {}  // nothing to initialise

  void add(const float* o, const float* d, float least_t, float most, uint32_t index) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][count] = o[axis];
      direction[axis][count] = d[axis];
    }
    t_min[count] = least_t;
    t[count] = most;
    ray[count++] = index;
  }

  // Takes kGroup rays that follow each other, the first of which is `index` of the span. False,
  // with nothing to rely on, if they are of several classes or not all are traceable.
  HWY_INLINE bool add_run(const Ray* rays, uint32_t index) {
    const DG d;
    const DGu du;
    const auto differs = [&](uint32_t i) {
      return group_class(&rays[i].direction.x) != group_class(&rays[0].direction.x);
    };
    if (differs(1) || differs(kGroup - 1)) return false;  // for most runs that are none
    const RunOfOneClass one_class(rays[0]);
    for (uint32_t i = 0; i < kGroup; i += static_cast<uint32_t>(hn::Lanes(d))) {
      hn::Vec<DG> o[4], along[4];  // the fourths are t_min and t_max
      load_rays(rays + i, o, along);
      if (!one_class.includes(o, along)) return false;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        hn::Store(o[axis], d, origin[axis] + i);
        hn::Store(along[axis], d, direction[axis] + i);
      }
      hn::Store(o[3], d, t_min + i);
      hn::Store(along[3], d, t + i);
      hn::Store(hn::Iota(du, index + i), du, ray + i);
    }
    count = kGroup;
    return true;
  }

  // Nothing was hit yet.
  HWY_INLINE void clear_hits() {
    const DG d;
    const DGu du;
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
      hn::Store(hn::Zero(d), d, v + i);
      hn::Store(hn::Zero(d), d, w + i);
      hn::Store(hn::Zero(du), du, primitive + i);
      hn::Store(hn::Set(du, kNoObject), du, object + i);
    }
  }

  // Rays that found nothing go on for ever.
  HWY_INLINE void finish() {
    const DG d;
    const DGu du;
    const auto never = hn::Set(d, __builtin_inff());
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
      const auto missed = hn::Eq(hn::Load(du, object + i), hn::Set(du, kNoObject));
      hn::Store(hn::IfThenElse(hn::RebindMask(d, missed), never, hn::Load(d, t + i)), d, t + i);
    }
  }

  Hit hit(uint32_t i) const { return {t[i], v[i], w[i], primitive[i], object[i]}; }
  void set_hit(uint32_t i, const Hit& hit) {
    t[i] = hit.t;
    v[i] = hit.u;
    w[i] = hit.v;
    primitive[i] = hit.primitive;
    object[i] = hit.object;
  }

  // Once all rays are added. `Triangles` is how triangles are tested.
  template <class Triangles>
  HWY_INLINE void prepare() {
    const DG d;
    const size_t lanes = hn::Lanes(d);
    alive = count == 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1;
    const size_t padded = (count + lanes - 1) / lanes * lanes;
    for (size_t i = count; i < padded; ++i) {  // like the first ray, but never alive
      for (int axis = 0; axis < 3; ++axis) {
        origin[axis][i] = origin[axis][0];
        direction[axis][i] = direction[axis][0];
      }
      t_min[i] = t_min[0];
      t[i] = t[0];
    }
    const float first[4] = {direction[0][0], direction[1][0], direction[2][0], 0.0f};
    const uint32_t negative = negative_axes(first);
    kz = largest_axis(first);
    const uint8_t* axes = kShearAxes[negative >> kz & 1][kz];
    kx = axes[0];
    ky = axes[1];
    for (uint32_t axis = 0; axis < 3; ++axis) {
      near[axis] = axis + 3 * (negative >> axis & 1);
      far[axis] = axis + 3 - 3 * (negative >> axis & 1);
      prepare_axis(axis, negative >> axis & 1, padded);
    }
    auto least = hn::Load(d, t_min);
    for (size_t i = 0; i < padded; i += lanes) {
      const auto sz = hn::Load(d, reciprocal[kz] + i);
      hn::Store(sz, d, shear_z + i);
      hn::Store(hn::Mul(hn::Load(d, direction[kx] + i), sz), d, shear_x + i);
      hn::Store(hn::Mul(hn::Load(d, direction[ky] + i), sz), d, shear_y + i);
      Triangles::prepare(*this, i);
      least = hn::Min(least, hn::Load(d, t_min + i));
    }
    least_t_min = hn::GetLane(hn::MinOfLanes(d, least));
    find_most_t();
  }

  HWY_INLINE void find_most_t() {
    const DG d;
    auto most = hn::Load(d, t);
    for (size_t i = hn::Lanes(d); i < count; i += hn::Lanes(d)) {
      most = hn::Max(most, hn::Load(d, t + i));
    }
    most_t = hn::GetLane(hn::MaxOfLanes(d, most));
  }

 private:
  HWY_INLINE void prepare_axis(uint32_t axis, bool negative, size_t padded) {
    const DG d;
    const auto tiny = hn::Set(d, kTiny), one = hn::Set(d, 1.0f), widen = hn::Set(d, kRobust);
    auto low = hn::Load(d, origin[axis]), high = low;
    auto least = hn::Set(d, __builtin_inff()), most = hn::Neg(least);
    for (size_t i = 0; i < padded; i += hn::Lanes(d)) {
      const auto o = hn::Load(d, origin[axis] + i);
      const auto along = hn::Load(d, direction[axis] + i);
      const auto safe =
          hn::IfThenElse(hn::Lt(hn::Abs(along), tiny), hn::CopySign(tiny, along), along);
      const auto inverse = hn::Div(one, safe);
      hn::Store(inverse, d, reciprocal[axis] + i);
      hn::Store(hn::Mul(inverse, widen), d, far_reciprocal[axis] + i);
      low = hn::Min(low, o);
      high = hn::Max(high, o);
      least = hn::Min(least, inverse);
      most = hn::Max(most, inverse);
    }
    const float from = hn::GetLane(hn::MinOfLanes(d, low));
    const float to = hn::GetLane(hn::MaxOfLanes(d, high));
    const float a = hn::GetLane(hn::MinOfLanes(d, least));
    const float b = hn::GetLane(hn::MaxOfLanes(d, most));
    near_bound[axis] = {negative ? from : to, a, b};
    far_bound[axis] = {negative ? to : from, a * kRobust, b * kRobust};
  }
};

// Children that some ray of the group may meet; entry[i] is not above where any ray does. Rounding
// is monotone, so the bounds hold for the distances as they are computed for every ray.
HWY_INLINE uint32_t test_boxes(const Node8& node, const RayGroup& group,
                               float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;
  uint32_t bits = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    auto near = hn::Set(d, group.least_t_min);
    auto far = hn::Set(d, group.most_t * kReach);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const RayGroup::Interval& n = group.near_bound[axis];
      const RayGroup::Interval& f = group.far_bound[axis];
      const auto to_near = hn::Sub(hn::Load(d, planes[group.near[axis]] + i), hn::Set(d, n.origin));
      const auto to_far = hn::Sub(hn::Load(d, planes[group.far[axis]] + i), hn::Set(d, f.origin));
      near = hn::Max(near, hn::Min(hn::Mul(to_near, hn::Set(d, n.least)),
                                   hn::Mul(to_near, hn::Set(d, n.most))));
      far = hn::Min(
          far, hn::Max(hn::Mul(to_far, hn::Set(d, f.least)), hn::Mul(to_far, hn::Set(d, f.most))));
    }
    hn::Store(near, d, entry + i);
    bits |= mask_bits(d, hn::Le(near, far)) << i;
  }
  return bits;
}

// The rays of `mask` that meet one child's box; `entry` becomes the least distance where they do,
// unless any hit is sought.
template <bool kAny>
HWY_INLINE uint64_t test_box(const Node8& node, uint32_t child, const RayGroup& group,
                             uint64_t mask, float& entry) {
  const DG d;
  const float(*planes)[kWidth] = node.low;
  const auto reach = hn::Set(d, kReach);
  auto least = hn::Set(d, __builtin_inff());
  uint64_t met = 0;
  for (size_t i = 0; i < group.count; i += hn::Lanes(d)) {
    const auto part = static_cast<uint32_t>(mask >> i) & ((1u << hn::Lanes(d)) - 1u);
    if (part == 0) continue;
    auto near = hn::Load(d, group.t_min + i);
    auto far = hn::Mul(hn::Load(d, group.t + i), reach);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const auto o = hn::Load(d, group.origin[axis] + i);
      const auto near_plane = hn::Set(d, planes[group.near[axis]][child]);
      const auto far_plane = hn::Set(d, planes[group.far[axis]][child]);
      near =
          hn::Max(near, hn::Mul(hn::Sub(near_plane, o), hn::Load(d, group.reciprocal[axis] + i)));
      far =
          hn::Min(far, hn::Mul(hn::Sub(far_plane, o), hn::Load(d, group.far_reciprocal[axis] + i)));
    }
    const auto hit = hn::Le(near, far);
    if (!kAny) least = hn::Min(least, hn::IfThenElse(hit, near, least));
    met |= uint64_t{mask_bits(d, hit) & part} << i;
  }
  entry = kAny ? 0.0f : hn::GetLane(hn::MinOfLanes(d, least));
  return met;
}

// The few rays of `mask`, one by one, against eight boxes each. Returns the children that any of
// them meets; rays[i] are those that meet child i, the first at entry[i].
HWY_INLINE uint32_t test_boxes_singly(const Node8& node, const RayGroup& group, uint64_t mask,
                                      uint64_t* HWY_RESTRICT rays, float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;
  uint32_t any = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    auto least = hn::Set(d, __builtin_inff());
    for (uint64_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto k = static_cast<uint32_t>(__builtin_ctzll(rest));
      auto near = hn::Set(d, group.t_min[k]);
      auto far = hn::Set(d, group.t[k] * kReach);
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const auto o = hn::Set(d, group.origin[axis][k]);
        near = hn::Max(near, hn::Mul(hn::Sub(hn::Load(d, planes[group.near[axis]] + i), o),
                                     hn::Set(d, group.reciprocal[axis][k])));
        far = hn::Min(far, hn::Mul(hn::Sub(hn::Load(d, planes[group.far[axis]] + i), o),
                                   hn::Set(d, group.far_reciprocal[axis][k])));
      }
      const auto hit = hn::Le(near, far);
      least = hn::Min(least, hn::IfThenElse(hit, near, least));
      const uint64_t bit = uint64_t{1} << k;
      for (uint32_t bits = mask_bits(d, hit) << i; bits != 0; bits &= bits - 1) {
        const uint32_t child = static_cast<uint32_t>(__builtin_ctz(bits));
        rays[child] = any >> child & 1 ? rays[child] | bit : bit;
        any |= 1u << child;
      }
    }
    hn::Store(least, d, entry + i);
  }
  return any;
}

// One ray of the group against eight boxes.
HWY_INLINE uint32_t test_boxes(const Node8& node, const RayGroup& group, uint32_t k,
                               float* HWY_RESTRICT entry) {
  const D8 d;
  const float(*planes)[kWidth] = node.low;
  uint32_t bits = 0;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    auto near = hn::Set(d, group.t_min[k]);
    auto far = hn::Set(d, group.t[k] * kReach);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const auto o = hn::Set(d, group.origin[axis][k]);
      near = hn::Max(near, hn::Mul(hn::Sub(hn::Load(d, planes[group.near[axis]] + i), o),
                                   hn::Set(d, group.reciprocal[axis][k])));
      far = hn::Min(far, hn::Mul(hn::Sub(hn::Load(d, planes[group.far[axis]] + i), o),
                                 hn::Set(d, group.far_reciprocal[axis][k])));
    }
    hn::Store(near, d, entry + i);
    bits |= mask_bits(d, hn::Le(near, far)) << i;
  }
  return bits;
}

// The rays of `mask` against one box that is hit where they enter it, some vectors of them.
// hit(first ray, bits, t) is called for vectors with hits not beyond those so far.
template <class OnHit>
HWY_INLINE void test_box_hits(const Node8& packet, uint32_t lane, const RayGroup& group,
                              uint64_t mask, const OnHit& on_hit) {
  const DG d;
  const float(*planes)[kWidth] = packet.low;
  for (size_t i = 0; i < group.count; i += hn::Lanes(d)) {
    const auto part = static_cast<uint32_t>(mask >> i) & ((1u << hn::Lanes(d)) - 1u);
    if (part == 0) continue;
    const auto most = hn::Load(d, group.t + i);
    auto near = hn::Load(d, group.t_min + i);
    auto far = hn::Mul(most, hn::Set(d, kReach));
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const auto o = hn::Load(d, group.origin[axis] + i);
      const auto near_plane = hn::Set(d, planes[group.near[axis]][lane]);
      const auto far_plane = hn::Set(d, planes[group.far[axis]][lane]);
      near =
          hn::Max(near, hn::Mul(hn::Sub(near_plane, o), hn::Load(d, group.reciprocal[axis] + i)));
      far =
          hn::Min(far, hn::Mul(hn::Sub(far_plane, o), hn::Load(d, group.far_reciprocal[axis] + i)));
    }
    near = hn::Add(near, hn::Zero(d));  // not -0
    const auto hit = hn::And(hn::Le(near, far), hn::Le(near, most));
    const uint32_t bits = mask_bits(d, hit) & part;
    if (bits != 0) on_hit(i, bits, near);
  }
}

// The rays that meet each child, as the low and the high half of a mask.
struct ChildRays {
  alignas(32) uint32_t low[kWidth], high[kWidth];
};

// The same where nobody asks for distances, and without branches: what a ray meets is not to be
// foretold.
HWY_INLINE void test_boxes_singly(const Node8& node, const RayGroup& group, uint64_t mask,
                                  ChildRays& out) {
  const D8 d;
  const D8u du;
  const float(*planes)[kWidth] = node.low;
  for (size_t i = 0; i < kWidth; i += hn::Lanes(d)) {
    const auto near_x = hn::Load(d, planes[group.near[0]] + i);
    const auto near_y = hn::Load(d, planes[group.near[1]] + i);
    const auto near_z = hn::Load(d, planes[group.near[2]] + i);
    const auto far_x = hn::Load(d, planes[group.far[0]] + i);
    const auto far_y = hn::Load(d, planes[group.far[1]] + i);
    const auto far_z = hn::Load(d, planes[group.far[2]] + i);
    const auto met_by = [&](uint32_t half, uint32_t from) {
      auto met = hn::Zero(du);
      for (; half != 0; half &= half - 1) {
        const uint32_t k = from + static_cast<uint32_t>(__builtin_ctz(half));
        const auto to = [&](uint32_t axis, auto plane, const float(&reciprocal)[3][kGroup]) {
          return hn::Mul(hn::Sub(plane, hn::Set(d, group.origin[axis][k])),
                         hn::Set(d, reciprocal[axis][k]));
        };
        const auto near =
            hn::Max(hn::Max(to(0, near_x, group.reciprocal), to(1, near_y, group.reciprocal)),
                    hn::Max(to(2, near_z, group.reciprocal), hn::Set(d, group.t_min[k])));
        const auto far =
            hn::Min(hn::Min(to(0, far_x, group.far_reciprocal), to(1, far_y, group.far_reciprocal)),
                    hn::Min(to(2, far_z, group.far_reciprocal), hn::Set(d, group.t[k] * kReach)));
        const auto hit = hn::RebindMask(du, hn::Le(near, far));
        met = hn::Or(met, hn::IfThenElseZero(hit, hn::Set(du, half & (~half + 1))));
      }
      return met;
    };
    hn::Store(met_by(static_cast<uint32_t>(mask), 0), du, out.low + i);
    hn::Store(met_by(static_cast<uint32_t>(mask >> 32), 32), du, out.high + i);
  }
}

// The rays of `mask` that a box entered at `entry` is not too far for.
HWY_INLINE uint64_t still_reach(const RayGroup& group, uint64_t mask, float entry) {
  const DG d;
  const auto margin = hn::Set(d, kReach), from = hn::Set(d, entry);
  uint64_t reach = 0;
  for (size_t i = 0; i < group.count; i += hn::Lanes(d)) {
    const auto near_enough = hn::Ge(hn::Mul(hn::Load(d, group.t + i), margin), from);
    reach |= uint64_t{mask_bits(d, near_enough)} << i;
  }
  return mask & reach;
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
