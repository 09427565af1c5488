// Passes of re-insertion: subtrees look for better places at the same time, in a tree that does not
// change meanwhile; then those that found one move one after another, the greatest gain first, if
// they still gain something in the tree as it is by then. Meister and Bittner lock what a move
// touches instead, and let sums of gains err: checking every gain costs little beside the searches,
// finds three times as many moves a pass, and the cost never rises.
#include "sinew/bvh/optimize.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "sinew/base/parallel.h"
#include "sinew/bvh/frame_tree.h"

namespace sinew {
namespace {

constexpr size_t kSearchesPerTask = 256;
constexpr uint32_t kMostLooks = 1000;    // records that a search looks below
constexpr double kLeastProgress = 2e-4;  // of the cost, by a round that is worth another one
constexpr size_t kFewSlots = 64;         // not worth a pass of their own

class Optimizer {
 public:
  Optimizer(const Tree& start, const FrameBoxes& frames, const OptimizeConfig& config)
      : start_(start),
        frames_(frames),
        config_(config),
        tree_(start, frames),
        moves_(tree_.slot_count()),
        again_(tree_.slot_count()) {
    weigh();
    start_cost_ = best_cost_ = cost_;
  }

  // A round begins with all subtrees, and goes on with those around what has changed.
  Tree run() {
    double before = cost_;
    do {
      before = cost_;
      slots_.resize(tree_.slot_count() - 2);
      std::iota(slots_.begin(), slots_.end(), 2u);
      while (slots_.size() > kFewSlots || slots_.size() == tree_.slot_count() - 2) {
        const uint64_t moved_before = step_.moved;
        pass();
        if (!report() || step_.moved == moved_before) break;
      }
    } while (go_on_ && before - cost_ > kLeastProgress * before);
    if (best_) return std::move(*best_);
    return cost_ <= start_cost_ ? tree_.tree() : start_;
  }

 private:
  void pass() {
    parallel_for(slots_.size(), kSearchesPerTask, [&](size_t begin, size_t end) {
      find_reinsertions(tree_.view(), std::span(slots_).subspan(begin, end - begin), kMostLooks,
                        moves_.data() + begin);
    });
    wishes_.clear();
    for (uint32_t i = 0; i < slots_.size(); ++i) {
      if (moves_[i].to != kNoSlot) wishes_.push_back(i);
    }
    std::sort(wishes_.begin(), wishes_.end(), [&](uint32_t a, uint32_t b) {
      return moves_[a].gain > moves_[b].gain || (moves_[a].gain == moves_[b].gain && a < b);
    });
    tree_.forget_changes();
    std::ranges::fill(again_, uint8_t{0});
    for (const uint32_t i : wishes_) {
      if (tree_.move(slots_[i], moves_[i].to)) {
        ++step_.moved;
      } else {
        again_[slots_[i]] = 1;
      }
    }
    slots_.clear();
    for (uint32_t slot = 2; slot < tree_.slot_count(); ++slot) {
      if (again_[slot] || tree_.changed(slot)) slots_.push_back(slot);
    }
    weigh();
    keep_best();
  }

  // The frames' costs now, and what they make areas count. (T: w_i = C_i^k.)
  void weigh() {
    step_.costs = tree_.costs(config_.cost);
    cost_ = power_cost(step_.costs, frames_.weights, config_.exponent);
    if (config_.exponent == 0 && step_.moved > 0) return;
    const double most = *std::max_element(step_.costs.begin(), step_.costs.end());
    std::vector<double> g = frames_.weights;
    for (size_t f = 0; f < g.size() && most > 0.0; ++f) {
      g[f] *= std::pow(step_.costs[f] / most, double(config_.exponent));
    }
    tree_.set_weights(g);
  }

  // With an exponent the weights of a pass are those of its beginning, so it may do harm.
  void keep_best() {
    if (config_.exponent == 0) return;
    if (!best_) best_ = start_;
    if (cost_ < best_cost_) {
      best_cost_ = cost_;
      best_ = tree_.tree();
    }
  }

  bool report() {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin_;
    step_.seconds = taken.count();
    if (config_.on_step) go_on_ = config_.on_step(step_);
    return go_on_;
  }

  const Tree& start_;
  const FrameBoxes& frames_;
  const OptimizeConfig& config_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  FrameTree tree_;
  double start_cost_ = 0.0, cost_ = 0.0, best_cost_ = 0.0;
  std::optional<Tree> best_;  // only with an exponent
  OptimizeStep step_;
  bool go_on_ = true;
  std::vector<uint32_t> slots_;     // that search in this pass
  std::vector<Reinsertion> moves_;  // what they found
  std::vector<uint32_t> wishes_;    // those that found something, into slots_
  std::vector<uint8_t> again_;      // [slot]: found something, but did not move
};

}  // namespace

Tree optimize(const Tree& start, const FrameBoxes& frames, const OptimizeConfig& config) {
  if (frames.primitive_count() < 3) return start;  // there is no other tree
  return Optimizer(start, frames, config).run();
}

Tree build_optimized(const FrameBoxes& frames, const OptimizeConfig& config) {
  return optimize(build_over_frames(frames, config), frames, config);
}

}  // namespace sinew
