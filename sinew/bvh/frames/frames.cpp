#include "sinew/bvh/frames/frames.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kPrimitivesPerTask = 4096;

// The frame nearest to `frame` in which the primitive is there.
std::optional<size_t> nearest_frame(const std::vector<std::vector<Box>>& frames, size_t frame,
                                    size_t primitive) {
  for (size_t away = 0; away < frames.size(); ++away) {
    if (away <= frame && is_there(frames[frame - away][primitive])) return frame - away;
    if (frame + away < frames.size() && is_there(frames[frame + away][primitive])) {
      return frame + away;
    }
  }
  return std::nullopt;
}

vec3 middle_of(const std::vector<std::vector<Box>>& frames) {
  Box all;
  for (const std::vector<Box>& boxes : frames) {
    for (const Box& box : boxes) {
      if (is_there(box)) all.extend(box);
    }
  }
  return all.empty() ? vec3(0.0f) : 0.5f * all.min + 0.5f * all.max;  // a sum might overflow
}

// Powers of costs are those of shares of the highest one, which do not overflow.
double highest(std::span<const double> costs) {
  return costs.empty() ? 0.0 : *std::ranges::max_element(costs);
}

}  // namespace

FrameBoxes make_frame_boxes(std::vector<std::vector<Box>> frames) {
  FrameBoxes out;
  for (const std::vector<Box>& boxes : frames) {
    SINEW_CHECK(boxes.size() == frames.front().size());
  }
  struct Repair {
    size_t frame, primitive;
    Box box;
  };
  const vec3 middle = middle_of(frames);
  std::vector<Repair> repairs;  // all known before the first is made
  for (size_t f = 0; f < frames.size(); ++f) {
    for (size_t p = 0; p < frames[f].size(); ++p) {
      if (is_there(frames[f][p])) continue;
      const std::optional<size_t> near = nearest_frame(frames, f, p);
      repairs.push_back({f, p, near ? frames[*near][p] : Box{middle, middle}});
    }
  }
  out.frames = std::move(frames);
  for (const Repair& repair : repairs) out.frames[repair.frame][repair.primitive] = repair.box;
  const size_t count = std::max<size_t>(out.frames.size(), 1);
  out.weights.assign(out.frames.size(), 1.0 / static_cast<double>(count));
  return out;
}

std::vector<double> frame_costs(const Tree& tree, const FrameBoxes& frames,
                                const CostModel& model) {
  std::vector<double> costs(frames.frame_count());
  parallel_for(costs.size(), 1, [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) {
      costs[f] = sah_cost(tree, refit(tree, frames.frames[f]), model);
    }
  });
  return costs;
}

double tsah_cost(std::span<const double> costs, std::span<const double> weights, double exponent) {
  const double most = highest(costs);
  if (!(most > 0.0)) return 0.0;
  double sum = 0.0, weight_sum = 0.0;
  for (size_t i = 0; i < costs.size(); ++i) {
    const double w = weights[i] * std::pow(costs[i] / most, exponent);
    sum += w * costs[i];
    weight_sum += w;
  }
  return weight_sum > 0.0 ? sum / weight_sum : 0.0;
}

double power_cost(std::span<const double> costs, std::span<const double> weights, double exponent) {
  const double most = highest(costs);
  if (!(most > 0.0)) return 0.0;
  double sum = 0.0;
  for (size_t i = 0; i < costs.size(); ++i) {
    sum += weights[i] * std::pow(costs[i] / most, exponent + 1.0);
  }
  return most * std::pow(sum, 1.0 / (exponent + 1.0));
}

std::vector<double> area_weights(const Tree& tree, const FrameBoxes& frames,
                                 std::span<const double> costs, double exponent) {
  std::vector<double> g(frames.frame_count(), 0.0);
  const double most = highest(costs);
  if (tree.empty() || !(most > 0.0)) return g;
  double sum = 0.0;
  for (size_t f = 0; f < g.size(); ++f) {
    Box root;
    for (const Box& box : frames.frames[f]) root.extend(box);
    const double area = exact_half_area(root);
    if (area > 0.0) g[f] = frames.weights[f] * std::pow(costs[f] / most, exponent) / area;
    sum += g[f];
  }
  for (double& value : g) value = sum > 0.0 ? value / sum : 0.0;
  return g;
}

std::vector<float> weighted_areas(const Tree& tree, const FrameBoxes& frames,
                                  std::span<const double> g) {
  std::vector<float> areas(tree.nodes.size(), 0.0f);
  for (size_t f = 0; f < frames.frame_count(); ++f) {
    if (g[f] == 0.0) continue;
    const Bounds bounds = refit(tree, frames.frames[f]);
    parallel_for(areas.size(), kPrimitivesPerTask, [&](size_t begin, size_t end) {
      for (size_t n = begin; n < end; ++n) {
        areas[n] += static_cast<float>(g[f] * exact_half_area(bounds[n]));
      }
    });
  }
  return areas;
}

}  // namespace sinew
