// A small palette for many colours. Based on: P. Heckbert, "Color Image Quantization for Frame
// Buffer Display", SIGGRAPH 1982 (boxes of colours cut in two). Differs: the box that errs most is
// cut next, at its mean.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace sinew::vox {

// A colour as packed by pack_color(), of one kind of surface.
struct SurfaceColor {
  uint32_t surface = 0;
  uint16_t color = 0;
  auto operator<=>(const SurfaceColor&) const = default;
};

struct PaletteEntry {
  uint32_t surface = 0;
  std::array<uint8_t, 3> srgb{};
};

struct Palette {
  std::vector<PaletteEntry> entries;
  std::map<SurfaceColor, uint8_t> index;  // of each colour's entry
};

// `counts` says how often each colour is there; there are at most `most` surfaces, which share no
// entry. If there are at most `most` colours each has its own.
Palette quantize(const std::map<SurfaceColor, uint64_t>& counts, size_t most);

}  // namespace sinew::vox
