// Where every animal of study:herd runs.
#pragma once

#include "sinew/scene/procedural/horse_gallop.h"

namespace sinew {

inline constexpr uint32_t kHerdFrames = 96;
inline constexpr double kHerdFps = 24.0;

// The gallop of animal `index` of `count`, over the terrain.
Gallop herd_gallop(uint32_t index, uint32_t count);

}  // namespace sinew
