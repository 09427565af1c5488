// Bins of primitives with their boxes in all frames, for build_over_frames().
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/frames/build_frames_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <limits>

#include "sinew/bvh/frames/build_frames_kernels.h"
#include "sinew/bvh/frames/frame_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <uint32_t kRow>
void measure(const BinJob& job, float* range) {
  using Ops = FrameBoxOps<kRow>;
  const typename Ops::D d;
  const Ops ops(job.g, job.padding);
  const uint32_t row = ops.row();
  for (const uint32_t primitive : job.primitives) {
    const float* const box = job.box(primitive);
    for (uint32_t i = 0; i < 3 * row; i += Ops::lanes()) {
      const auto center = hn::Sub(hn::Load(d, box + 3 * row + i), hn::Load(d, box + i));
      float* const low = range + i;
      float* const high = range + 3 * row + i;
      hn::Store(hn::Max(hn::Load(d, low), hn::Neg(center)), d, low);
      hn::Store(hn::Max(hn::Load(d, high), center), d, high);
    }
  }
}

template <uint32_t kRow>
uint32_t* counts_of(const FrameBoxOps<kRow>& ops, size_t axes, uint32_t bins, float* filled) {
  return reinterpret_cast<uint32_t*>(filled + axes * bins * ops.box_floats());
}

template <uint32_t kRow>
void fill(const BinJob& job, std::span<const BinAxis> axes, uint32_t bins, float* out) {
  const FrameBoxOps<kRow> ops(job.g, job.padding);
  const size_t box_floats = ops.box_floats();
  std::fill_n(out, axes.size() * bins * box_floats, -std::numeric_limits<float>::infinity());
  uint32_t* const counts = counts_of(ops, axes.size(), bins, out);
  std::fill_n(counts, axes.size() * bins, 0u);
  for (const uint32_t primitive : job.primitives) {
    const float* const box = job.box(primitive);
    for (size_t a = 0; a < axes.size(); ++a) {
      const size_t bin = a * bins + axes[a].bin(box, ops.row(), bins);
      ops.join(out + bin * box_floats, box, out + bin * box_floats);
      ++counts[bin];
    }
  }
}

template <uint32_t kRow>
void merge(const BinJob& job, size_t axes, uint32_t bins, const float* other, float* out) {
  const FrameBoxOps<kRow> ops(job.g, job.padding);
  const size_t box_floats = ops.box_floats();
  const uint32_t* const add = counts_of(ops, axes, bins, const_cast<float*>(other));
  uint32_t* const counts = counts_of(ops, axes, bins, out);
  for (size_t bin = 0; bin < axes * bins; ++bin) {
    ops.join(out + bin * box_floats, other + bin * box_floats, out + bin * box_floats);
    counts[bin] += add[bin];
  }
}

// Sweeps over the bins of one axis, from the right and then from the left.
template <uint32_t kRow>
void sweep(const FrameBoxOps<kRow>& ops, const float* boxes, const uint32_t* counts, uint32_t bins,
           float* swept, float& least, uint32_t& least_bin) {
  float right_cost[kMaxFrameBins];
  uint32_t right_count[kMaxFrameBins];
  const size_t box_floats = ops.box_floats();
  std::copy_n(boxes + (bins - 1) * box_floats, box_floats, swept);
  uint32_t count = 0;
  for (uint32_t b = bins - 1; b > 0; --b) {
    count += counts[b];
    if (counts[b] > 0) {
      ops.join(swept, boxes + b * box_floats, swept);
      right_cost[b] = ops.area(swept) * static_cast<float>(count);
    } else if (b + 1 < bins) {
      right_cost[b] = right_cost[b + 1];
    }
    right_count[b] = count;
  }
  std::copy_n(boxes, box_floats, swept);
  count = 0;
  float left_cost = 0.0f;
  for (uint32_t b = 1; b < bins && right_count[b] > 0; ++b) {
    if (counts[b - 1] == 0) continue;
    count += counts[b - 1];
    ops.join(swept, boxes + (b - 1) * box_floats, swept);
    left_cost = ops.area(swept) * static_cast<float>(count);
    if (left_cost + right_cost[b] < least) {
      least = left_cost + right_cost[b];
      least_bin = b;
    }
  }
}

template <uint32_t kRow>
FrameSplit best(const BinJob& job, size_t axes, uint32_t bins, float* filled, float* swept) {
  const FrameBoxOps<kRow> ops(job.g, job.padding);
  const uint32_t* const counts = counts_of(ops, axes, bins, filled);
  FrameSplit out;
  float least = std::numeric_limits<float>::infinity();
  for (size_t a = 0; a < axes; ++a) {
    const float before = least;
    sweep(ops, filled + a * bins * ops.box_floats(), counts + a * bins, bins, swept, least,
          out.bin);
    if (least < before) out.axis = static_cast<uint32_t>(a);
  }
  return out;
}

void measure_kernel(const BinJob& job, float* range) {
  SINEW_FOR_ROW(job.padding, measure, (job, range));
}

void fill_kernel(const BinJob& job, std::span<const BinAxis> axes, uint32_t bins, float* out) {
  SINEW_FOR_ROW(job.padding, fill, (job, axes, bins, out));
}

void merge_kernel(const BinJob& job, size_t axes, uint32_t bins, const float* other, float* out) {
  SINEW_FOR_ROW(job.padding, merge, (job, axes, bins, other, out));
}

FrameSplit best_kernel(const BinJob& job, size_t axes, uint32_t bins, float* filled, float* swept) {
  SINEW_FOR_ROW(job.padding, best, (job, axes, bins, filled, swept));
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(measure_kernel);
HWY_EXPORT(fill_kernel);
HWY_EXPORT(merge_kernel);
HWY_EXPORT(best_kernel);

void measure_centers(const BinJob& job, float* range) {
  HWY_DYNAMIC_DISPATCH(measure_kernel)(job, range);
}

void fill_bins(const BinJob& job, std::span<const BinAxis> axes, uint32_t bins, float* out) {
  HWY_DYNAMIC_DISPATCH(fill_kernel)(job, axes, bins, out);
}

void merge_bins(const BinJob& job, size_t axes, uint32_t bins, const float* other, float* out) {
  HWY_DYNAMIC_DISPATCH(merge_kernel)(job, axes, bins, other, out);
}

FrameSplit best_frame_split(const BinJob& job, size_t axes, uint32_t bins, float* filled,
                            float* swept) {
  return HWY_DYNAMIC_DISPATCH(best_kernel)(job, axes, bins, filled, swept);
}

}  // namespace sinew
#endif
