// Packs triangles from the vertices of their treelet. Included once per target.
#if defined(SINEW_BVH_PACK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_PACK_INL_H_
#undef SINEW_BVH_PACK_INL_H_
#else
#define SINEW_BVH_PACK_INL_H_
#endif

#include "sinew/bvh/wide.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// `at` are the vertices of the treelet, which are read four floats at a time: there is one more
// than it has.
HWY_INLINE void pack_triangles(const PacketCorners& corners, const vec3* at, TrianglePacket& out) {
  const hn::FixedTag<float, 4> d;
  for (int corner = 0; corner < 3; ++corner) {
    const auto a = hn::LoadU(d, &at[corners.v[0][corner]].x);
    const auto b = hn::LoadU(d, &at[corners.v[1][corner]].x);
    const auto c = hn::LoadU(d, &at[corners.v[2][corner]].x);
    const auto e = hn::LoadU(d, &at[corners.v[3][corner]].x);
    const auto ac_low = hn::InterleaveLower(d, a, c), ac_high = hn::InterleaveUpper(d, a, c);
    const auto be_low = hn::InterleaveLower(d, b, e), be_high = hn::InterleaveUpper(d, b, e);
    hn::Store(hn::InterleaveLower(d, ac_low, be_low), d, out.v[corner][0]);
    hn::Store(hn::InterleaveUpper(d, ac_low, be_low), d, out.v[corner][1]);
    hn::Store(hn::InterleaveLower(d, ac_high, be_high), d, out.v[corner][2]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per target
