#include "sinew/bvh/choose.h"

namespace sinew {
namespace {

// Where a body changes from thrifty to full and back; apart, so that it does not go to and fro.
constexpr float kMostlyReached = 0.75f, kPartlyReached = 0.55f;

// A full update says nothing about what rays reach, so every so often one pose is tried without.
constexpr uint32_t kFramesBetweenTrials = 32;

}  // namespace

UpdateMode choose_mode(UpdateMode thrifty, std::optional<float> reached, UpdateHistory& history) {
  UpdateChoice& choice = history.choice;
  if (choice.mode == UpdateMode::full) {
    if (++history.full_frames < kFramesBetweenTrials) return choice.mode;
    choice.mode = thrifty;
    choice.why = "a trial after many full updates";
    return choice.mode;
  }
  choice.mode = thrifty;
  if (!reached) return choice.mode;
  choice.reached = *reached;
  const bool on_trial = history.full_frames > 0;
  const bool full = *reached > (on_trial ? kPartlyReached : kMostlyReached);
  choice.mode = full ? UpdateMode::full : thrifty;
  choice.why = full ? "rays reached most of it" : "rays reached a part of it";
  history.full_frames = 0;
  return choice.mode;
}

}  // namespace sinew
