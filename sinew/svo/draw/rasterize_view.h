// What the parts of the rasteriser pass on to each other within a frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sinew/math/vec.h"
#include "sinew/svo/draw/rasterize.h"

namespace sinew {

inline constexpr uint32_t kTileSide = 64;  // pixels: both planes of a tile stay in the first cache
inline constexpr uint32_t kNoBlock = 0xffffffffu;

// Four roundings in the view's functions, seven in a trilinear map and a few behind them, for the
// point and for the bound, each half a unit in the last place: see docs/voxels.md.
inline constexpr float kRasterGamma = 32.0f * 5.97e-8f;

// A view of one instance: linear functions of (p, 1), p in the instance's object space.
struct ClipMap {
  vec4 x{0.0f}, y{0.0f}, depth{0.0f};
  float near = 0.0f;
  bool perspective = true;  // divide x and y by depth; else they are pixels
};
inline bool is_perspective(const RasterView& view) {
  return view.w == view.depth;
}
ClipMap map_of(const RasterView& view, const Affine& placement);

// (x, y, depth, 0) of a point: homogeneous, so trilinear maps of it are exact.
struct alignas(16) ClipPoint {
  float x = 0.0f, y = 0.0f, depth = 0.0f, unused = 0.0f;
};
static_assert(sizeof(ClipPoint) == 16);

// A block in the view.
struct RasterBlock {
  const Svo* svo = nullptr;
  uint32_t instance = 0;
  uint32_t block = 0;
  uint32_t node = 0;          // the block's
  uint32_t first_corner = 0;  // of ClipPoints
  uint32_t first_cell = 0;    // of RasterCells
  uint32_t cells = 0;         // of these, in the view
  uint32_t first_unit = 0;    // of the instance
  bool resident = true;       // else its cells are drawn as such
  bool later = false;         // ... or, of a picture in parts, only hide other blocks
  float voxel = 0.0f;         // pixels: the largest voxel of level 0, as far as it is in the view
  float reach[4] = {};        // no |x|, |y|, |depth| of a corner is greater, nor any term of theirs
};

enum class RasterPath : uint8_t {
  rectangle,  // one box: a cell, or a node
  voxels,     // many boxes of one size
  near,       // crosses the near plane: the boxes of its voxels are found one by one
};

// A cell (or node) in the view.
struct RasterCell {
  uint32_t unit = 0;          // among all instances'
  uint32_t block = kNoBlock;  // of RasterBlocks
  uint32_t cell = 0;          // of Svo::cells
  float near_depth = 0.0f;    // nothing of it is drawn before
  float far_depth = 0.0f;     // or behind; a rectangle is there
  float half_x = 0.0f;        // pixels, of a voxel's box, padded
  float half_y = 0.0f;
  int16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels whose centres it may cover, inclusive
  uint8_t level = 0;
  RasterPath path = RasterPath::voxels;
  uint16_t fine = 0;  // whether something finer than the cell is to be drawn, be it there or not;
                      // or kStandIn
};
inline constexpr uint16_t kStandIn = 2;  // it is drawn in another part of the picture
static_assert(sizeof(RasterCell) == 40);

// Whether its voxels are drawn as boxes with faces.
inline bool is_large(const RasterSettings& settings, const RasterCell& cell) {
  return 2.0f * std::max(cell.half_x, cell.half_y) > settings.large;
}

// A box on the screen, in pixels.
struct ScreenBox {
  float x0 = 0.0f, y0 = 0.0f, x1 = -1.0f, y1 = -1.0f;
  float near_depth = 0.0f, far_depth = -1.0f;
  bool seen() const { return near_depth <= far_depth; }
};

// A hull's points beyond the near plane: its corners there, and where lines between corners meet
// the plane, its edges among them. x and y are divided by depth in perspective.
struct SeenPoints {
  static constexpr uint32_t kMost = 8 + 16;
  double at[kMost][3];
  uint32_t count = 0;

  void add(double x, double y, double depth, bool perspective) {
    const double scale = perspective ? 1.0 / depth : 1.0;
    at[count][0] = x * scale;
    at[count][1] = y * scale;
    at[count][2] = depth;
    ++count;
  }
};
SeenPoints seen_points(const ClipPoint corners[8], float near, bool perspective);

// What rounding may move a point on the screen by: at most `farthest` pixels from 0 along the axis,
// at this depth, `reach` as in RasterBlock. The most that any point of a hull needs is added on all
// sides; where that is much, close to the eye, each of its points has what it needs itself.
double point_pad(double farthest, double depth, bool perspective, float reach, float depth_reach);
inline constexpr double kWidePad = 0.25;  // pixels

// The box of what of the hull of eight points lies beyond the near plane. `reach` as in
// RasterBlock; the box is padded for the rounding of points within the hull.
ScreenBox project_hull(const ClipPoint corners[8], float near, bool perspective,
                       const float reach[3]);

// Lines on the screen, in pixels. In space each is a plane through the eye.
struct SideLines {
  float x0 = 0.0f, y0 = 0.0f, x1 = 0.0f, y1 = 0.0f;
};
// Whether all of the hull, as far as it is before the eye, is beyond one of the lines: found
// without a division by depth, so it holds close to the eye, where boxes on the screen are of no
// use.
bool misses(const ClipPoint corners[8], bool perspective, const float reach[3],
            const SideLines& lines);

// Corners of a voxel of a cell.
void voxel_corners(const ClipPoint* points, const SvoCell& cell, VoxelCode code, ClipPoint out[8]);

// Pixels whose centres lie in [low, high]: the first and the last. Values beyond the 16 bits of
// RasterCell are moved to its ends, NaN gives none.
struct PixelRange {
  int first = 0, last = -1;
  bool empty() const { return first > last; }
};
inline PixelRange pixel_range(float low, float high) {
  constexpr float kEnd = 32000.0f;
  if (!(low <= high)) return {};
  return {static_cast<int>(std::ceil(std::clamp(low - 0.5f, -kEnd, kEnd))),
          static_cast<int>(std::floor(std::clamp(high - 0.5f, -kEnd, kEnd)))};
}

}  // namespace sinew
