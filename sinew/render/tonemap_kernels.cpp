// Exposure, a shoulder that compresses the brightest channel and carries the others along (hue
// stays), then lets very bright colours fade to white; sRGB with exact rounding.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/render/tonemap_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/render/tonemap_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<I>;

HWY_INLINE V set(float x) {
  return hn::Set(D(), x);
}

// Neither negative, infinite nor NaN.
HWY_INLINE V tame(V x) {
  const V finite = hn::Min(hn::Max(x, hn::Zero(D())), set(kLargestRadiance));
  return hn::IfThenZeroElse(hn::IsNaN(x), finite);
}

struct Pixels {
  V red, green, blue, alpha;
};

HWY_INLINE void compress(Pixels& p) {
  const V peak = hn::Max(p.red, hn::Max(p.green, p.blue));
  const auto beyond = hn::Gt(peak, set(kShoulder));
  if (hn::AllFalse(D(), beyond)) return;
  constexpr float kRoom = 1.0f - kShoulder;
  const V one = set(1.0f);
  const V new_peak =
      hn::Sub(one, hn::Div(set(kRoom * kRoom), hn::Add(peak, set(kRoom - kShoulder))));
  const V keep = hn::Div(one, hn::MulAdd(set(kDesaturation), hn::Sub(peak, new_peak), one));
  const V scale = hn::Div(new_peak, peak);
  const auto channel = [&](V x) {
    const V faded = hn::MulAdd(keep, hn::Sub(hn::Mul(x, scale), new_peak), new_peak);
    return hn::IfThenElse(beyond, faded, x);
  };
  p.red = channel(p.red);
  p.green = channel(p.green);
  p.blue = channel(p.blue);
}

// As linear_to_srgb_code().
HWY_INLINE VI srgb_code(const srgb_detail::Encoder& encoder, V linear) {
  const D d;
  const I i;
  const V x = hn::Min(linear, set(1.0f));
  const VI cell = hn::ConvertTo(i, hn::Mul(x, set(static_cast<float>(encoder.kCells))));
  const VI low = hn::GatherIndex(i, encoder.low.data(), cell);
  const V threshold = hn::GatherIndex(d, encoder.threshold.data() + 1, low);
  return hn::Sub(low, hn::VecFromMask(i, hn::RebindMask(i, hn::Ge(x, threshold))));
}

// Whole vectors.
HWY_INLINE VI encode(const srgb_detail::Encoder& encoder, float gain, Pixels p) {
  const I i;
  p.alpha = hn::Min(tame(p.alpha), set(1.0f));
  const auto is_seen = hn::Gt(p.alpha, hn::Zero(D()));
  const V scale = hn::IfThenElse(is_seen, hn::Div(set(gain), p.alpha), set(gain));
  p.red = tame(hn::Mul(p.red, scale));
  p.green = tame(hn::Mul(p.green, scale));
  p.blue = tame(hn::Mul(p.blue, scale));
  compress(p);
  const VI red = srgb_code(encoder, p.red);
  const VI green = hn::ShiftLeft<8>(srgb_code(encoder, p.green));
  const VI blue = hn::ShiftLeft<16>(srgb_code(encoder, p.blue));
  const VI alpha = hn::ConvertTo(i, hn::MulAdd(p.alpha, set(255.0f), set(0.5f)));
  return hn::Or(hn::Or(red, green), hn::Or(blue, hn::ShiftLeft<24>(alpha)));
}

void tonemap_kernel(const srgb_detail::Encoder& encoder, const float* in, size_t pixels, float gain,
                    uint8_t* out) {
  const D d;
  const hn::Repartition<uint8_t, D> bytes;
  const size_t lanes = hn::Lanes(d);
  constexpr size_t kMost = HWY_MAX_BYTES / sizeof(float);
  HWY_ALIGN float last_in[4 * kMost] = {};
  HWY_ALIGN uint8_t last_out[4 * kMost];
  for (size_t i = 0; i < pixels; i += lanes) {
    const size_t count = HWY_MIN(lanes, pixels - i);
    const bool whole = count == lanes;
    for (size_t k = 0; !whole && k < 4 * count; ++k) last_in[k] = in[4 * i + k];
    Pixels p;
    hn::LoadInterleaved4(d, whole ? in + 4 * i : last_in, p.red, p.green, p.blue, p.alpha);
    hn::StoreU(hn::BitCast(bytes, encode(encoder, gain, p)), bytes, whole ? out + 4 * i : last_out);
    for (size_t k = 0; !whole && k < 4 * count; ++k) out[4 * i + k] = last_out[k];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(tonemap_kernel);

void tonemap_pixels(const vec4* in, size_t pixels, float gain, uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(tonemap_kernel)
  (srgb_detail::encoder(), reinterpret_cast<const float*>(in), pixels, gain, out);
}

}  // namespace sinew
#endif  // HWY_ONCE
