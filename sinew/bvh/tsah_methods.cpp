#include "sinew/bvh/tsah_methods.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

// Frames whose boxes, or trees, are in memory at once.
constexpr uint32_t kAtOnce = 4;

FrameBoxes frame_of(const AnimatedBoxes& animation, uint32_t frame) {
  std::vector<std::vector<Box>> boxes(1);
  boxes.front().resize(animation.primitive_count);
  animation.boxes(frame, boxes.front());
  return make_frame_boxes(std::move(boxes));
}

double weight_of(const AnimatedBoxes& animation, uint32_t frame) {
  return animation.weights.empty() ? 1.0 : animation.weights[frame];
}

AnimationCosts summed_up(std::vector<double> costs, const AnimatedBoxes& animation) {
  AnimationCosts out;
  double weights = 0.0;
  for (uint32_t f = 0; f < costs.size(); ++f) {
    out.average += weight_of(animation, f) * costs[f];
    weights += weight_of(animation, f);
    out.maximum = std::max(out.maximum, costs[f]);
  }
  if (weights > 0.0) out.average /= weights;
  out.costs = std::move(costs);
  return out;
}

Tree collapsed(const Tree& tree, const FrameBoxes& frames, double exponent,
               const MethodConfig& config) {
  if (config.max_leaf <= 1) return tree;
  const CostModel& model = config.tsah.cost;
  const std::vector<double> costs = frame_costs(tree, frames, model);
  return collapse_leaves(tree, frames, area_weights(tree, frames, costs, exponent), model,
                         config.leaf_block, config.max_leaf);
}

Tree tree_of(const FrameBoxes& frame, const MethodConfig& config) {
  TsahConfig insertion = config.tsah;
  insertion.on_batch = {};
  const BuildConfig sweep{.leaf_block = 1, .max_leaf = 1};
  Tree tree = build_sweep(frame.frames.front(), sweep);
  if (config.insertion) tree = optimize_insertion(tree, frame.frames.front(), insertion);
  return collapsed(tree, frame, 0.0, config);
}

// Costs of several trees, so that a frame's boxes are made once for all.
std::vector<std::vector<double>> costs_of(std::span<const Tree> trees,
                                          const AnimatedBoxes& animation, const CostModel& model) {
  std::vector<std::vector<double>> costs(trees.size(),
                                         std::vector<double>(animation.frame_count()));
  for (uint32_t f = 0; f < animation.frame_count(); ++f) {
    const FrameBoxes frame = frame_of(animation, f);
    parallel_for(trees.size(), 1, [&](size_t begin, size_t end) {
      for (size_t t = begin; t < end; ++t) {
        costs[t][f] = frame_costs(trees[t], frame, model).front();
      }
    });
  }
  return costs;
}

}  // namespace

AnimationCosts animation_costs(const Tree& tree, const AnimatedBoxes& animation,
                               const CostModel& model) {
  std::vector<double> costs(animation.frame_count());
  for (uint32_t first = 0; first < costs.size(); first += kAtOnce) {
    const size_t count = std::min<size_t>(kAtOnce, costs.size() - first);
    parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const auto f = static_cast<uint32_t>(first + i);
        costs[f] = frame_costs(tree, frame_of(animation, f), model).front();
      }
    });
  }
  return summed_up(std::move(costs), animation);
}

Tree tree_of_frame(std::span<const Box> boxes, const MethodConfig& config) {
  FrameBoxes frame;
  frame.frames.emplace_back(boxes.begin(), boxes.end());
  frame.weights = {1.0};
  return tree_of(frame, config);
}

AnimationCosts rebuild_costs(const AnimatedBoxes& animation, const MethodConfig& config) {
  std::vector<double> costs(animation.frame_count());
  for (uint32_t first = 0; first < costs.size(); first += kAtOnce) {
    const size_t count = std::min<size_t>(kAtOnce, costs.size() - first);
    parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const FrameBoxes frame = frame_of(animation, static_cast<uint32_t>(first + i));
        costs[first + i] = frame_costs(tree_of(frame, config), frame, config.tsah.cost).front();
      }
    });
  }
  return summed_up(std::move(costs), animation);
}

BestOverTime best_over_time(const AnimatedBoxes& animation, std::span<const uint32_t> candidates,
                            const MethodConfig& config) {
  SINEW_CHECK(!candidates.empty());
  BestOverTime best;
  for (size_t first = 0; first < candidates.size(); first += kAtOnce) {
    std::vector<Tree> trees(std::min<size_t>(kAtOnce, candidates.size() - first));
    parallel_for(trees.size(), 1, [&](size_t begin, size_t end) {
      for (size_t t = begin; t < end; ++t) {
        trees[t] = tree_of(frame_of(animation, candidates[first + t]), config);
      }
    });
    std::vector<std::vector<double>> costs = costs_of(trees, animation, config.tsah.cost);
    for (size_t t = 0; t < trees.size(); ++t) {
      AnimationCosts sums = summed_up(std::move(costs[t]), animation);
      if (best.tree.empty() || sums.average < best.costs.average) {
        best = {std::move(trees[t]), candidates[first + t], std::move(sums)};
      }
    }
  }
  return best;
}

Tree tsah_tree(const FrameBoxes& representatives, const MethodConfig& config) {
  return collapsed(build_tsah(representatives, config.tsah), representatives, config.tsah.exponent,
                   config);
}

}  // namespace sinew
