// Passes of re-insertion: subtrees look for better places at the same time, in a tree that does not
// change meanwhile; then those that found one move one after another, the greatest gain first, if
// they still gain enough in the tree as it is by then. Meister and Bittner lock what a move touches
// instead, and let sums of gains err. Checking every gain costs little beside the searches, and the
// cost never rises: after four passes over a scattering scene it was 52 where locks left 77.
#include "sinew/bvh/frames/optimize.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <span>
#include <vector>

#include "sinew/base/parallel.h"
#include "sinew/bvh/frames/frame_tree.h"

namespace sinew {
namespace {

constexpr size_t kSearchesPerTask = 256;
constexpr uint32_t kMostLooks = 1000;  // records that a search looks below
// Of the gain that a search found, when it comes to moving: a subtree that would gain less by then
// had better search again. (By up to 0.4% cheaper trees than moving for any gain.)
constexpr float kKept = 0.5f;
constexpr double kLeastRound = 2e-4;  // of the cost, gained by a round that is worth another one
constexpr double kLeastPass = 2e-6;   // the same of a pass over what has changed

class Optimizer {
 public:
  Optimizer(const Tree& start, const FrameBoxes& frames, const OptimizeConfig& config)
      : start_(start),
        frames_(frames),
        config_(config),
        tree_(start, frames, config),
        moves_(tree_.slot_count()),
        again_(tree_.slot_count()) {}

  // A round begins with all subtrees, and goes on with those around what has changed.
  Tree run() {
    const double at_start = cost();
    double before_round = at_start, before_pass = at_start;
    do {
      before_round = cost();
      slots_.resize(tree_.slot_count() - 2);
      std::iota(slots_.begin(), slots_.end(), 2u);
      do {
        before_pass = cost();
        search();
        apply();
        choose_changed();
      } while (report() && gained_since(before_pass) > kLeastPass);
    } while (go_on_ && gained_since(before_round) > kLeastRound);
    if (cost() <= at_start) return tree_.tree();
    return FrameTree(start_, frames_, config_).tree();
  }

 private:
  double cost() const { return power_cost(tree_.costs(), frames_.weights, config_.exponent); }
  double gained_since(double before) const { return before > 0.0 ? 1.0 - cost() / before : 0.0; }

  void search() {
    parallel_for(slots_.size(), kSearchesPerTask, [&](size_t begin, size_t end) {
      find_reinsertions(tree_.view(), std::span(slots_).subspan(begin, end - begin), kMostLooks,
                        moves_.data() + begin);
    });
  }

  // The greatest gain first; of equal ones, the first slot.
  void apply() {
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
      const bool moved = tree_.move(slots_[i], moves_[i].to, kKept * moves_[i].gain);
      moved_ += moved ? 1 : 0;
      again_[slots_[i]] = moved ? 0 : 1;
    }
    tree_.refresh();
  }

  // Those that found something, but did not move, and those whose surroundings have changed.
  void choose_changed() {
    slots_.clear();
    for (uint32_t slot = 2; slot < tree_.slot_count(); ++slot) {
      if (again_[slot] || tree_.changed(slot)) slots_.push_back(slot);
    }
  }

  bool report() {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin_;
    if (config_.on_step) go_on_ = config_.on_step({taken.count(), moved_, tree_.costs()});
    return go_on_;
  }

  const Tree& start_;
  const FrameBoxes& frames_;
  const OptimizeConfig& config_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  FrameTree tree_;
  uint64_t moved_ = 0;
  bool go_on_ = true;
  std::vector<uint32_t> slots_;     // that search in this pass
  std::vector<Reinsertion> moves_;  // what they found
  std::vector<uint32_t> wishes_;    // those that found something, into slots_
  std::vector<uint8_t> again_;      // [slot]: found something, but did not move
};

}  // namespace

Tree optimize(const Tree& start, const FrameBoxes& frames, const OptimizeConfig& config) {
  if (frames.primitive_count() < 2) return start;
  return Optimizer(start, frames, config).run();
}

Tree build_optimized(const FrameBoxes& frames, const OptimizeConfig& config) {
  return optimize(build_over_frames(frames, config), frames, config);
}

}  // namespace sinew
