// Colours of a brick as two ends and steps between them.
// Based on: J. van Waveren, "Real-Time DXT Compression", 2006 (ends of the box's diagonal that the
// colours lie along). Differs: as many colours as a brick has voxels, not 16.
#include "sinew/svo/brick.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr uint32_t kMost = 64;

// Colours in steps of 1/62 or 1/63: red, green, blue, a row each.
struct Steps {
  int32_t at[3][kMost];
};
void unpack(const uint16_t* colors, uint32_t count, Steps& out) {
  for (uint32_t v = 0; v < count; ++v) {
    out.at[0][v] = colors[v] >> 11 << 1;
    out.at[1][v] = colors[v] >> 5 & 63;
    out.at[2][v] = (colors[v] & 31) << 1;
  }
}
uint16_t packed_of(const int32_t (&c)[3]) {
  return static_cast<uint16_t>(c[0] >> 1 << 11 | c[1] << 5 | c[2] >> 1);
}

// Which diagonal of the box: the ends of channels that fall where the widest one rises are swapped.
void choose_diagonal(const Steps& steps, uint32_t count, int32_t (&a)[3], int32_t (&b)[3]) {
  int widest = 1;
  for (const int i : {0, 2}) {
    if (b[i] - a[i] > b[widest] - a[widest]) widest = i;
  }
  const int32_t middle = a[widest] + b[widest];
  for (int i = 0; i < 3; ++i) {
    int32_t together = 0;
    for (uint32_t v = 0; v < count; ++v) {
      together += (2 * steps.at[widest][v] - middle) * (2 * steps.at[i][v] - a[i] - b[i]);
    }
    if (together < 0) std::swap(a[i], b[i]);
  }
}

}  // namespace

void fit_colors(const uint16_t* colors, uint32_t count, SvoColorEnds& ends, uint8_t* selectors) {
  std::fill(selectors, selectors + count, uint8_t{0});
  ends = {colors[0], colors[0]};
  if (std::all_of(colors, colors + count, [&](uint16_t c) { return c == colors[0]; })) return;
  Steps steps;
  unpack(colors, count, steps);
  int32_t a[3], b[3], d[3], size = 0;
  for (int i = 0; i < 3; ++i) {
    a[i] = b[i] = steps.at[i][0];
    for (uint32_t v = 0; v < count; ++v) a[i] = std::min(a[i], steps.at[i][v]);
    for (uint32_t v = 0; v < count; ++v) b[i] = std::max(b[i], steps.at[i][v]);
  }
  choose_diagonal(steps, count, a, b);
  ends = {packed_of(a), packed_of(b)};
  for (int i = 0; i < 3; ++i) {
    d[i] = b[i] - a[i];
    size += d[i] * d[i];
  }
  const float scale = 3.0f / static_cast<float>(size);
  for (uint32_t v = 0; v < count; ++v) {
    const int32_t along = d[0] * (steps.at[0][v] - a[0]) + d[1] * (steps.at[1][v] - a[1]) +
                          d[2] * (steps.at[2][v] - a[2]);
    selectors[v] = static_cast<uint8_t>(scale * static_cast<float>(along) + 0.5f);
  }
}

}  // namespace sinew
