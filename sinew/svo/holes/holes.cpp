#include "sinew/svo/holes/holes.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"

namespace sinew {
namespace {

// Whether the surface is at most kExcessPixels from the centre of pixel (x, y).
bool is_near(const SurfacePicture& surface, int x, int y) {
  constexpr int kReach = 2;  // pixels in which something so near may lie
  constexpr float kLimit = kExcessPixels * kExcessPixels;
  for (int v = std::max(y - kReach, 0); v <= std::min(y + kReach, int(surface.height) - 1); ++v) {
    for (int u = std::max(x - kReach, 0); u <= std::min(x + kReach, int(surface.width) - 1); ++u) {
      const size_t pixel = size_t(v) * surface.width + size_t(u);
      const auto dx = static_cast<float>(u - x), dy = static_cast<float>(v - y);
      if (std::isfinite(surface.depth[pixel]) && dx * dx + dy * dy <= kLimit) return true;
      for (uint32_t bits = surface.touched[pixel]; bits != 0; bits &= bits - 1) {
        const auto bit = std::countr_zero(bits);
        const float sx = dx + (static_cast<float>(bit & 3) - 1.5f) * 0.25f;
        const float sy = dy + (static_cast<float>(bit >> 2) - 1.5f) * 0.25f;
        if (sx * sx + sy * sy <= kLimit) return true;
      }
    }
  }
  return false;
}

}  // namespace

HoleCount& HoleCount::operator+=(const HoleCount& more) {
  surface += more.surface;
  covered += more.covered;
  holes += more.holes;
  excess += more.excess;
  return *this;
}

HoleCount count_holes(const SurfacePicture& surface, const Visibility& picture,
                      std::vector<uint8_t>* marks) {
  SINEW_CHECK(surface.width == picture.width && surface.height == picture.height);
  HoleCount out;
  if (marks != nullptr) marks->assign(picture.keys.size(), 0);
  for (size_t pixel = 0; pixel < picture.keys.size(); ++pixel) {
    const VisibilityKey key = picture.keys[pixel];
    const bool on_surface = std::isfinite(surface.depth[pixel]), covered = key != kNothing;
    out.surface += on_surface;
    out.covered += covered;
    uint8_t mark = 0;
    if (on_surface) {
      const float limit = surface.depth[pixel] + kHoleVoxels * surface.size[pixel];
      mark = !covered || key_depth(key) > limit ? 1 : 0;
    } else if (covered) {
      const auto x = static_cast<int>(pixel % picture.width);
      const auto y = static_cast<int>(pixel / picture.width);
      mark = is_near(surface, x, y) ? 0 : 2;
    }
    out.holes += mark == 1;
    out.excess += mark == 2;
    if (marks != nullptr) (*marks)[pixel] = mark;
  }
  return out;
}

}  // namespace sinew
