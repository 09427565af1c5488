// Update mode `automatic`: which mode a body gets, from what its last poses cost and what rays
// reached of it. Times are measured, so the choice may differ from run to run; hits never do.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sinew/bvh/update/update.h"

namespace sinew {

// How a body of mode `automatic` was updated last, and why.
struct UpdateChoice {
  UpdateMode mode = UpdateMode::automatic;  // until the first update
  float reached = 0.0f;  // share of its treelets that rays reached, when that was last known
  const char* why = "no ray has come yet";
};

// Nanoseconds of one thread, a treelet, but for the last two. They begin as guesses; those of a ray
// stay what they are.
struct UpdateCosts {
  double full = 550.0;         // vertices, boxes and inside
  double hybrid = 240.0;       // vertices and box
  double lazy = 60.0;          // derived box
  double make_hybrid = 800.0;  // inside, when a ray comes
  double make_lazy = 1600.0;   // vertices and inside, when a ray comes
  double loose = 4.0;          // a ray, through derived boxes rather than exact ones
  double linked = 5.0;         // a ray, through links to treelets, packing what it tests
};

// What became of the last pose.
struct UpdateOutcome {
  UpdateMode mode = UpdateMode::full;
  double treelets = 0.0;
  double made = 0.0;       // treelets, by rays
  double rays = 0.0;       // traced
  double ray_share = 1.0;  // of them that came near the body, about; unknown after a full update
  double update_ns = 0.0;  // of all threads
  double timed = 0.0;      // of the treelets made, those whose time was taken
  double make_ns = 0.0;    // of all threads, for those
};

struct UpdateHistory {
  UpdateChoice choice;
  UpdateCosts costs;
  double rays = 0.0;  // when `reached` was known
  double ray_share = 1.0;
  uint32_t full_frames = 0;    // since then
  std::array<bool, 4> seen{};  // modes
};

// The next mode. `derivable`: boxes follow from poses, so that `lazy` is to be had. No outcome: no
// ray was traced through the last pose.
UpdateMode choose_mode(bool derivable, const std::optional<UpdateOutcome>& last,
                       UpdateHistory& history);

}  // namespace sinew
