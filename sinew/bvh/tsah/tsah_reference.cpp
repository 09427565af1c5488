#include "sinew/bvh/tsah/tsah_reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/tsah/tsah_search.h"
#include "sinew/bvh/tsah/tsah_selection.h"
#include "sinew/bvh/tsah/tsah_tree.h"

namespace sinew {
namespace {

class Optimizer {
 public:
  Optimizer(const Tree& start, const FrameBoxes& frames, const TsahConfig& config)
      : config_(config),
        frame_weights_(frames.weights),
        tree_(start, frames),
        selector_(tree_, config) {}

  Tree run() {
    const auto batch = static_cast<uint32_t>(
        std::max(1.0, std::round(config_.batch * static_cast<double>(tree_.node_count()))));
    measure();
    best_ = tree_.state();
    double best_cost = step_.cost;
    uint32_t without_gain = 0;
    bool go_on = report() && selector_.can_select();
    while (go_on && without_gain < config_.patience) {
      run_batch(batch);
      const bool gain = step_.cost < best_cost - config_.least_gain * best_cost;
      without_gain = gain ? 0 : without_gain + 1;
      if (step_.cost < best_cost) {
        best_cost = step_.cost;
        best_ = tree_.state();
      }
      go_on = report();
      if (selector_.batch_ended(without_gain)) without_gain = 0;
    }
    return MovableTree::to_tree(best_);
  }

 private:
  // Costs, and the weights and factors that hold during the next batch.
  void measure() {
    step_.costs = tree_.costs(config_.cost);
    step_.cost = tsah_cost(step_.costs, frame_weights_, config_.exponent);
    weights_.resize(step_.costs.size());
    for (size_t f = 0; f < weights_.size(); ++f) {
      weights_[f] = frame_weights_[f] * std::pow(step_.costs[f], config_.exponent);
    }
    factors_ = area_factors(tree_, weights_, config_.cost.traversal);
  }

  void run_batch(uint32_t size) {
    selector_.start_batch(weights_, size);
    for (uint32_t i = 0; i < size; ++i) {
      const uint32_t node = selector_.next(weights_);
      if (node == MovableTree::kNone) break;
      if (config_.move == TsahMove::node) {
        move_node(node);
      } else {
        move_children(node);
      }
    }
    ++step_.batch;
    measure();
  }

  void move_node(uint32_t node) {
    const uint32_t before = tree_.sibling(node);
    const uint32_t link = tree_.remove(node);
    put(node, before, link);
  }

  // The freed node and its freed parent become the new parents of the children.
  void move_children(uint32_t node) {
    uint32_t first = tree_.child(node, 0), second = tree_.child(node, 1);
    if (cost_of_area(first) < cost_of_area(second)) std::swap(first, second);
    const uint32_t before = tree_.sibling(node);
    const uint32_t link = tree_.remove(node);
    put(first, before, link);
    put(second, first, node);
  }

  void put(uint32_t node, uint32_t before, uint32_t link) {
    const InsertPosition known{before, search_.cost_at(tree_, factors_, node, before)};
    const InsertPosition best = search_.find(tree_, factors_, node, known);
    if (best.at != before) ++step_.moved;
    tree_.insert(node, best.at, link);
  }

  double cost_of_area(uint32_t node) const { return contribution(tree_.boxes(node), factors_); }

  bool report() {
    if (!config_.on_batch) return true;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    step_.seconds = passed.count();
    return config_.on_batch(step_);
  }

  const TsahConfig& config_;
  const std::vector<double>& frame_weights_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  MovableTree tree_;
  NodeSelector selector_;
  InsertionSearch search_;
  TsahStep step_;
  std::vector<double> weights_, factors_;  // of the frames, for this batch
  MovableTree::State best_;
};

}  // namespace

Tree optimize_tsah(const Tree& start, const FrameBoxes& frames, const TsahConfig& config) {
  SINEW_CHECK(config.exponent >= 0.0 && config.batch >= 0.0 && config.least_gain >= 0.0);
  SINEW_CHECK(frames.weights.size() == frames.frames.size());
  if (start.empty() || frames.frames.empty()) return start;
  return Optimizer(start, frames, config).run();
}

Tree build_tsah(const FrameBoxes& frames, const TsahConfig& config) {
  if (frames.frames.empty()) return {};
  BuildConfig sweep;
  sweep.max_leaf = 1;
  sweep.leaf_block = 1;
  return optimize_tsah(build_sweep(frames.frames.front(), sweep), frames, config);
}

Tree optimize_insertion(const Tree& start, std::span<const Box> boxes, const TsahConfig& config) {
  FrameBoxes frame;
  frame.frames.emplace_back(boxes.begin(), boxes.end());
  frame.weights = {1.0};
  return optimize_tsah(start, frame, config);
}

double contribution(std::span<const Box> boxes, std::span<const double> weights) {
  double sum = 0.0;
  for (size_t f = 0; f < boxes.size(); ++f) sum += weights[f] * exact_half_area(boxes[f]);
  return sum;
}

}  // namespace sinew
