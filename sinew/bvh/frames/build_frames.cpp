// Binned SAH over several frames, top down. Based on: I. Wald, "On fast Construction of SAH-based
// Bounding Volume Hierarchies", 2007; the cost is T's (J. Bittner, D. Meister, "T-SAH", 2015,
// equation 2). Differs: a plane lies on an axis in one of the frames, but both sides are judged by
// their boxes in all.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build_common.h"
#include "sinew/bvh/frames/build_frames_kernels.h"
#include "sinew/bvh/frames/optimize.h"

namespace sinew {
namespace {

constexpr size_t kChunk = 16384;  // primitives binned by one task

// Frames whose axes are tried. With those of all of ten frames, building took twice the time, and
// trees were no better after they had been optimised.
constexpr uint32_t kMostFrames = 5;
constexpr uint32_t kMostAxes = 3 * kMostFrames;

class FrameBuilder {
 public:
  FrameBuilder(const FrameBoxes& frames, std::span<const double> g)
      : frames_(frames.frame_count()),
        padding_(row_padding(frames_)),
        rows_(size_t{frames.primitive_count()} * kBoxRows * padding_),
        g_(padding_),
        order_(frames.primitive_count()) {
    std::fill_n(g_.data(), padding_, 0.0f);
    for (uint32_t f = 0; f < frames_; ++f) g_[f] = static_cast<float>(g[f]);
    const RelativeFrames relative(frames);
    parallel_for(order_.size(), kChunk, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        order_[i] = static_cast<uint32_t>(i);
        relative.write_rows(order_[i], rows_.data() + i * kBoxRows * padding_);
      }
    });
  }

  Tree run() {
    Tree tree;
    if (order_.empty()) return tree;
    tree.nodes.resize(2 * order_.size() - 1);
    Scratch scratch(padding_);
    build(tree, scratch, 0, 0, order_.size(), 0);
    tree.primitives = std::move(order_);
    return tree;
  }

 private:
  // Memory of one thread's way down.
  struct Scratch {
    explicit Scratch(uint32_t padding)
        : range(2 * 3 * padding),
          swept(kBoxRows * padding),
          bins(kMostAxes * kMaxFrameBins * (kBoxRows * padding + 1)) {
      axes.reserve(kMostAxes);
    }
    Buffer<float> range, swept, bins;
    std::vector<BinAxis> axes;
  };

  BinJob job(size_t begin, size_t end) const {
    return {rows_.data(), g_.data(), padding_, std::span(order_).subspan(begin, end - begin)};
  }

  void build(Tree& tree, Scratch& scratch, uint32_t node, size_t begin, size_t end, int depth) {
    const size_t count = end - begin;
    if (count == 1) {
      tree.nodes[node] = TreeNode::leaf(static_cast<uint32_t>(begin), 1);
      return;
    }
    const size_t middle = split(scratch, begin, end, depth);
    const uint32_t left = build_detail::left_slot(node);
    const uint32_t right = build_detail::right_slot(node, middle - begin);
    tree.nodes[node] = TreeNode::inner(left, right);
    if (count > build_detail::kTaskSize) {
      parallel_invoke([&] { build(tree, scratch, left, begin, middle, depth + 1); },
                      [&] {
                        Scratch own(padding_);
                        build(tree, own, right, middle, end, depth + 1);
                      });
    } else {
      build(tree, scratch, left, begin, middle, depth + 1);
      build(tree, scratch, right, middle, end, depth + 1);
    }
  }

  // Reorders the range and returns where the right child begins.
  size_t split(Scratch& scratch, size_t begin, size_t end, int depth) {
    const size_t count = end - begin, halves = begin + count / 2;
    if (count == 2 || depth >= build_detail::kBalanceDepth) return halves;
    const auto bins = static_cast<uint32_t>(std::min<size_t>(count, kMaxFrameBins));
    measure(scratch, begin, end);
    choose_axes(scratch, bins);
    if (scratch.axes.empty()) return halves;
    fill(scratch, begin, end, bins);
    const FrameSplit best = best_frame_split(job(begin, end), scratch.axes.size(), bins,
                                             scratch.bins.data(), scratch.swept.data());
    if (best.axis >= scratch.axes.size()) return halves;
    const BinAxis axis = scratch.axes[best.axis];
    const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto middle = std::partition(at(begin), at(end), [&](uint32_t primitive) {
      return axis.bin(job(begin, end).box(primitive), padding_, bins) < best.bin;
    });
    return static_cast<size_t>(middle - order_.begin());
  }

  void measure(Scratch& scratch, size_t begin, size_t end) const {
    const size_t floats = scratch.range.size();
    std::fill_n(scratch.range.data(), floats, -std::numeric_limits<float>::infinity());
    if (end - begin <= kChunk) return measure_centers(job(begin, end), scratch.range.data());
    const size_t chunks = (end - begin + kChunk - 1) / kChunk;
    Buffer<float> parts(chunks * floats);
    parallel_for(end - begin, kChunk, [&](size_t first, size_t last) {
      float* const part = parts.data() + first / kChunk * floats;
      std::fill_n(part, floats, -std::numeric_limits<float>::infinity());
      measure_centers(job(begin + first, begin + last), part);
    });
    for (size_t i = 0; i < parts.size(); ++i) {
      scratch.range[i % floats] = std::max(scratch.range[i % floats], parts[i]);
    }
  }

  // The axes of all frames, or, of many, of some that are spread evenly.
  void choose_axes(Scratch& scratch, uint32_t bins) const {
    scratch.axes.clear();
    const uint32_t used = std::min(frames_, kMostFrames);
    for (uint32_t i = 0; i < used; ++i) {
      const uint32_t f = used == 1 ? 0 : i * (frames_ - 1) / (used - 1);
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint32_t row = axis * padding_ + f;
        const float low = -scratch.range[row], extent = scratch.range[3 * padding_ + row] - low;
        const float scale = static_cast<float>(bins) * 0.99999f / extent;
        if (g_[f] > 0.0f && extent > 0.0f && scale < std::numeric_limits<float>::max()) {
          scratch.axes.push_back({row, low, scale});
        }
      }
    }
  }

  void fill(Scratch& scratch, size_t begin, size_t end, uint32_t bins) const {
    if (end - begin <= kChunk) {
      return fill_bins(job(begin, end), scratch.axes, bins, scratch.bins.data());
    }
    const size_t chunks = (end - begin + kChunk - 1) / kChunk;
    const size_t floats = job(begin, end).bin_floats(scratch.axes.size(), bins);
    Buffer<float> parts(chunks * floats);
    parallel_for(end - begin, kChunk, [&](size_t first, size_t last) {
      fill_bins(job(begin + first, begin + last), scratch.axes, bins,
                parts.data() + first / kChunk * floats);
    });
    std::copy_n(parts.data(), floats, scratch.bins.data());
    for (size_t i = 1; i < chunks; ++i) {
      merge_bins(job(begin, end), scratch.axes.size(), bins, parts.data() + i * floats,
                 scratch.bins.data());
    }
  }

  uint32_t frames_;
  uint32_t padding_;
  Buffer<float> rows_;  // [primitive][row][padding]
  Buffer<float> g_;
  std::vector<uint32_t> order_;
};

}  // namespace

Tree build_over_frames(const FrameBoxes& frames, const OptimizeConfig& config) {
  Tree tree = FrameBuilder(frames, frames.weights).run();
  if (config.exponent == 0 || tree.nodes.size() < 4) return tree;
  // Weights depend on what the frames cost, which only a tree can tell. Those of half the exponent
  // were better than the full ones: this first tree makes dear frames too dear.
  const std::vector<double> costs = frame_costs(tree, frames, config.cost);
  const double most = *std::max_element(costs.begin(), costs.end());
  if (!(most > 0.0)) return tree;
  std::vector<double> g = frames.weights;
  for (size_t f = 0; f < g.size(); ++f) g[f] *= std::pow(costs[f] / most, 0.5 * config.exponent);
  return FrameBuilder(frames, g).run();
}

}  // namespace sinew
