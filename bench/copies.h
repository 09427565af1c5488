// Scenes for benches: many copies of one file's content side by side, each with joints, placements
// and movement of its own.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "sinew/scene/scene.h"

namespace sinew::bench {

// Parts of the PigMan file that its joints fling far away, at thirty times their size.
inline constexpr std::array<std::string_view, 2> kPigManStrays = {"Object_32", "Object_44"};

// Meshes and materials are shared. Copies stand on a square grid; copy k plays clip k modulo the
// number of clips, so that neighbours move differently. The new clip is as long as the shortest.
// Nodes named in `without` lose their meshes.
Scene copies_of(Scene one, uint32_t copies, std::span<const std::string_view> without = {});

}  // namespace sinew::bench
