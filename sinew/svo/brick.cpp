// Colours of a brick as two ends and steps between them.
// Based on: J. van Waveren, "Real-Time DXT Compression", 2006 (ends of the box's diagonal that the
// colours lie along). Differs: as many colours as a brick has voxels, not 16.
#include "sinew/svo/brick.h"

#include <algorithm>

namespace sinew {
namespace {

// Red, green, blue; red and blue in steps of 2, so that all are alike.
struct Steps {
  int at[3];
};
Steps steps_of(uint16_t packed) {
  return {{packed >> 11 << 1, packed >> 5 & 63, (packed & 31) << 1}};
}
uint16_t packed_of(const Steps& s) {
  return static_cast<uint16_t>(s.at[0] >> 1 << 11 | s.at[1] << 5 | s.at[2] >> 1);
}

// Which diagonal of the box: the ends of channels that fall where the widest one rises are swapped.
void choose_diagonal(const uint16_t* colors, uint32_t count, Steps& a, Steps& b) {
  int widest = 1;
  for (const int i : {0, 2}) {
    if (b.at[i] - a.at[i] > b.at[widest] - a.at[widest]) widest = i;
  }
  int together[3] = {};
  for (uint32_t v = 0; v < count; ++v) {
    const Steps c = steps_of(colors[v]);
    const int along = 2 * c.at[widest] - a.at[widest] - b.at[widest];
    for (int i = 0; i < 3; ++i) together[i] += along * (2 * c.at[i] - a.at[i] - b.at[i]);
  }
  for (int i = 0; i < 3; ++i) {
    if (together[i] < 0) std::swap(a.at[i], b.at[i]);
  }
}

}  // namespace

void fit_colors(const uint16_t* colors, uint32_t count, SvoColorEnds& ends, uint8_t* selectors) {
  Steps a = steps_of(colors[0]), b = a;
  bool same = true;
  for (uint32_t v = 1; v < count; ++v) {
    if (colors[v] == colors[0]) continue;
    same = false;
    const Steps c = steps_of(colors[v]);
    for (int i = 0; i < 3; ++i) {
      a.at[i] = std::min(a.at[i], c.at[i]);
      b.at[i] = std::max(b.at[i], c.at[i]);
    }
  }
  std::fill(selectors, selectors + count, uint8_t{0});
  ends = {colors[0], colors[0]};
  if (same) return;
  choose_diagonal(colors, count, a, b);
  ends = {packed_of(a), packed_of(b)};
  int d[3], size = 0;
  for (int i = 0; i < 3; ++i) {
    d[i] = b.at[i] - a.at[i];
    size += d[i] * d[i];
  }
  const float scale = 3.0f / static_cast<float>(size);
  for (uint32_t v = 0; v < count; ++v) {
    const Steps c = steps_of(colors[v]);
    int along = 0;
    for (int i = 0; i < 3; ++i) along += d[i] * (c.at[i] - a.at[i]);
    selectors[v] = static_cast<uint8_t>(scale * static_cast<float>(along) + 0.5f);
  }
}

}  // namespace sinew
