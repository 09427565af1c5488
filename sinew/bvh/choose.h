// Update mode `automatic`: which mode a body gets, from the share of its treelets that rays reached
// in its last pose.
#pragma once

#include <optional>

#include "sinew/bvh/update.h"

namespace sinew {

// How a body of mode `automatic` was updated last, and why.
struct UpdateChoice {
  UpdateMode mode = UpdateMode::lazy;
  float reached = 0.0f;  // share of its treelets that rays reached, when that was last known
  const char* why = "no ray has come yet";
};

struct UpdateHistory {
  UpdateChoice choice;
  uint32_t full_frames = 0;  // in a row
};

// The next mode. `thrifty` is the mode that makes only what rays reach; `reached` what they reached
// in the last pose, if it was updated in such a mode and rays were traced.
UpdateMode choose_mode(UpdateMode thrifty, std::optional<float> reached, UpdateHistory& history);

}  // namespace sinew
