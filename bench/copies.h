// Scenes for benches: many copies of one file's content side by side, each with joints, placements
// and movement of its own.
#pragma once

#include <cstdint>

#include "sinew/scene/scene.h"

namespace sinew::bench {

// Meshes and materials are shared. Copies stand on a square grid; copy k plays clip k modulo the
// number of clips, so that neighbours move differently. The new clip is as long as the shortest.
Scene copies_of(const Scene& one, uint32_t copies);

}  // namespace sinew::bench
