#include "sinew/bvh/update/choose.h"

#include <utility>

namespace sinew {
namespace {

// A full update says nothing about what rays reach, so every so often, or when the number of rays
// has changed much, one pose is tried without.
constexpr uint32_t kFramesBetweenTrials = 32;
constexpr double kOtherRays = 2.0;

// So many times of treelets count half of what very many do.
constexpr double kFewTimed = 8.0;

// A mode must promise to be so much cheaper than the last one to replace it.
constexpr double kGain = 0.93;

// Interrupted threads make times longer, never shorter: longer ones count less.
void learn(double measured, double& cost, double weight = 1.0) {
  if (!(measured > 0.0)) return;
  cost += weight * (measured < cost ? 0.5 : 0.15) * (measured - cost);
}

void learn(const UpdateOutcome& last, UpdateHistory& history) {
  UpdateCosts& costs = history.costs;
  if (!(last.treelets > 0.0)) return;
  const bool lazy = last.mode == UpdateMode::lazy;
  // A mode's first pose makes its memory, which says nothing about the next ones.
  if (std::exchange(history.seen[static_cast<size_t>(last.mode)], true)) {
    double& update = last.mode == UpdateMode::full ? costs.full : lazy ? costs.lazy : costs.hybrid;
    learn(last.update_ns / last.treelets, update);
    double& make = lazy ? costs.make_lazy : costs.make_hybrid;
    if (last.timed > 0.0) {
      learn(last.make_ns / last.timed, make, last.timed / (last.timed + kFewTimed));
    }
  }
  if (last.mode == UpdateMode::full) return;
  history.choice.reached = static_cast<float>(last.made / last.treelets);
  history.rays = last.rays;
  history.ray_share = last.ray_share;
  history.full_frames = 0;
}

bool wants_trial(const UpdateOutcome& last, UpdateHistory& history) {
  if (last.mode != UpdateMode::full) return false;
  return ++history.full_frames >= kFramesBetweenTrials || last.rays > kOtherRays * history.rays ||
         kOtherRays * last.rays < history.rays;
}

double expected_ns(UpdateMode mode, double treelets, const UpdateHistory& history) {
  const UpdateCosts& costs = history.costs;
  const double made = history.choice.reached;
  if (mode == UpdateMode::full) return treelets * costs.full;
  const double rays = history.rays * history.ray_share;
  if (mode == UpdateMode::hybrid) {
    return treelets * (costs.hybrid + made * costs.make_hybrid) + rays * costs.linked;
  }
  // A body that no ray comes to has no boxes derived either.
  const double derived = made > 0.0 ? costs.lazy : 0.0;
  return treelets * (derived + made * costs.make_lazy) + rays * (costs.linked + costs.loose);
}

}  // namespace

UpdateMode choose_mode(bool derivable, const std::optional<UpdateOutcome>& last,
                       UpdateHistory& history) {
  UpdateChoice& choice = history.choice;
  const UpdateMode thrifty = derivable ? UpdateMode::lazy : UpdateMode::hybrid;
  if (!last) {
    if (choice.mode == UpdateMode::automatic) choice.mode = thrifty;
    return choice.mode;
  }
  const bool known = history.seen[static_cast<size_t>(last->mode)];
  learn(*last, history);
  if (!known && last->mode != UpdateMode::full) {
    choice.mode = last->mode;
    choice.why = "a second pose, to see what it costs";
    return choice.mode;
  }
  if (wants_trial(*last, history)) {
    history.full_frames = 0;
    history.rays = last->rays;
    choice.mode = thrifty;
    choice.why = "a trial after full updates, to see what rays reach";
    return choice.mode;
  }
  UpdateMode best = last->mode;
  double best_ns = kGain * expected_ns(best, last->treelets, history);
  for (const UpdateMode mode : {UpdateMode::lazy, UpdateMode::hybrid, UpdateMode::full}) {
    if (mode == UpdateMode::lazy && !derivable) continue;
    const double ns = expected_ns(mode, last->treelets, history);
    if (ns >= best_ns) continue;
    best = mode;
    best_ns = ns;
  }
  choice.mode = best;
  choice.why = best == UpdateMode::full ? "to make all of it at once costs least"
               : best == UpdateMode::hybrid
                   ? "to make what rays reach of it costs least, from all its vertices"
                   : "to move only what rays reach of it costs least";
  return choice.mode;
}

}  // namespace sinew
