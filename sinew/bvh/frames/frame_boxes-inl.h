// Boxes of many frames at once (frame_rows.h), for the kernels that build and optimise over frames.
#if defined(SINEW_BVH_FRAME_BOXES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_BVH_FRAME_BOXES_INL
#undef SINEW_BVH_FRAME_BOXES_INL
#else
#define SINEW_BVH_FRAME_BOXES_INL
#endif

#include <hwy/highway.h>

#include "sinew/bvh/frames/frame_rows.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// kRow: floats a row, 4 or 8, which compilers unroll; or 0, any multiple of 8.
template <uint32_t kRow>
class FrameBoxOps {
  static constexpr size_t kLanes = kRow == 4 ? 4 : 8;

 public:
  using D = hn::CappedTag<float, kLanes>;
  using V = hn::Vec<D>;

  // g: how much an area in each frame counts.
  FrameBoxOps(const float* g, uint32_t padding) : g_(g), padding_(padding) {}

  static HWY_INLINE uint32_t lanes() { return static_cast<uint32_t>(hn::Lanes(D())); }
  HWY_INLINE uint32_t row() const { return kRow != 0 ? kRow : padding_; }
  HWY_INLINE uint32_t box_floats() const { return kBoxRows * row(); }

  // sum_i g_i * half area of the box in frame i.
  HWY_INLINE float area(const float* a) const { return union_area(a, a); }

  // The same of the union of two.
  HWY_INLINE float union_area(const float* a, const float* b) const {
    const D d;
    V sum = hn::Zero(d);
    for (uint32_t f = 0; f < row(); f += lanes()) {
      sum = hn::Add(sum, hn::Mul(hn::Load(d, g_ + f), half_areas(a, b, f)));
    }
    return hn::GetLane(hn::SumOfLanes(d, sum));
  }

  // Half areas of the union of two in the frames from f on, as many as there are lanes.
  HWY_INLINE V half_areas(const float* a, const float* b, uint32_t f) const {
    const V x = extent(a + f, b + f);
    const V y = extent(a + row() + f, b + row() + f);
    const V z = extent(a + 2 * row() + f, b + 2 * row() + f);
    return hn::Add(hn::Mul(x, hn::Add(y, z)), hn::Mul(y, z));
  }

  // Sums of half areas, a row.
  HWY_INLINE void clear_row(float* sums) const {
    const D d;
    for (uint32_t f = 0; f < row(); f += lanes()) hn::Store(hn::Zero(d), d, sums + f);
  }
  HWY_INLINE void add_areas(const float* a, float* sums) const {
    const D d;
    for (uint32_t f = 0; f < row(); f += lanes()) {
      hn::Store(hn::Add(hn::Load(d, sums + f), half_areas(a, a, f)), d, sums + f);
    }
  }
  HWY_INLINE void subtract_union_areas(const float* a, const float* b, float* sums) const {
    const D d;
    for (uint32_t f = 0; f < row(); f += lanes()) {
      hn::Store(hn::Sub(hn::Load(d, sums + f), half_areas(a, b, f)), d, sums + f);
    }
  }

  HWY_INLINE bool contains(const float* a, const float* b) const {
    const D d;
    for (uint32_t i = 0; i < box_floats(); i += lanes()) {
      if (!hn::AllTrue(d, hn::Ge(hn::Load(d, a + i), hn::Load(d, b + i)))) return false;
    }
    return true;
  }

  // The union of two; returns whether `out` was that already.
  HWY_INLINE bool join(const float* a, const float* b, float* out) const {
    const D d;
    auto same = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (uint32_t i = 0; i < box_floats(); i += lanes()) {
      const V both = hn::Max(hn::Load(d, a + i), hn::Load(d, b + i));
      same = hn::And(same, hn::Eq(both, hn::Load(d, out + i)));
      hn::Store(both, d, out + i);
    }
    return hn::AllTrue(d, same);
  }

 private:
  HWY_INLINE V extent(const float* a, const float* b) const {
    const D d;
    const uint32_t high = 3 * row();
    return hn::Add(hn::Max(hn::Load(d, a), hn::Load(d, b)),
                   hn::Max(hn::Load(d, a + high), hn::Load(d, b + high)));
  }

  const float* g_;
  uint32_t padding_;
};

// Calls a template of the row's length: SINEW_FOR_ROW(padding, kernel, (arguments)).
#ifndef SINEW_FOR_ROW
#define SINEW_FOR_ROW(padding, kernel, arguments) \
  switch (padding) {                              \
    case 4:                                       \
      return kernel<4> arguments;                 \
    case 8:                                       \
      return kernel<8> arguments;                 \
    default:                                      \
      return kernel<0> arguments;                 \
  }
#endif

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
