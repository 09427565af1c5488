// Corners of blocks on the screen, and what follows for cells: their boxes, the size of their
// voxels, the level to draw. One vector holds x, y and depth of a point; cells are done one by one,
// because their corners stand anywhere in the block.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/svo/draw/rasterize_cells_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/svo/draw/rasterize_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;

HWY_INLINE V4 row_of(const vec4& x, const vec4& y, const vec4& depth, int i) {
  alignas(16) const float row[4] = {x[i], y[i], depth[i], 0.0f};
  return hn::Load(D4(), row);
}

// A box in x, y (pixels) and depth.
struct RowBox {
  V4 low, high;

  // Written out: an implicit constructor would not be compiled for the target.
  HWY_INLINE RowBox()
      : low(hn::Set(D4(), __builtin_inff())), high(hn::Set(D4(), -__builtin_inff())) {}
  void extend(V4 p) {
    low = hn::Min(low, p);
    high = hn::Max(high, p);
  }
};

// The points, their places on the screen, and how far the terms of their coordinates reach.
HWY_INLINE RowBox project_corners(const BlockJob& job, float reach[4]) {
  const D4 d;
  const ClipMap& m = *job.map;
  const V4 mx = row_of(m.x, m.y, m.depth, 0), my = row_of(m.x, m.y, m.depth, 1);
  const V4 mz = row_of(m.x, m.y, m.depth, 2), mt = row_of(m.x, m.y, m.depth, 3);
  V4 most = hn::Zero(d);
  RowBox box;
  for (uint32_t i = 0; i < job.corners; ++i) {
    const vec3 p = job.positions[i];
    const V4 x = hn::Mul(mx, hn::Set(d, p.x)), y = hn::Mul(my, hn::Set(d, p.y));
    const V4 z = hn::Mul(mz, hn::Set(d, p.z));
    const V4 point = hn::Add(hn::Add(x, y), hn::Add(z, mt));
    hn::Store(point, d, &job.points[i].x);
    most =
        hn::Max(most, hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Add(hn::Abs(z), hn::Abs(mt))));
    V4 screen = point;
    if (m.perspective) {
      const V4 depth = hn::Broadcast<2>(point);
      screen = hn::IfThenElse(hn::FirstN(d, 2), hn::Div(point, depth), point);
    }
    hn::Store(screen, d, &job.screen[i].x);
    box.extend(screen);
  }
  hn::StoreU(most, d, reach);
  return box;
}

HWY_INLINE V4 length_of(V4 a, V4 b) {
  return hn::Abs(hn::Sub(a, b));
}

// Rounding of a point between `low` and `high`, and of its sums with whole pixels:
// gamma ((|X| + |s| |W|) / W + |s|).
HWY_INLINE V4 pad_of(V4 low, V4 high, bool perspective, V4 reach) {
  const V4 farthest = hn::Max(hn::Abs(low), hn::Abs(high));
  V4 terms = reach;
  if (perspective) {
    terms = hn::Div(hn::MulAdd(farthest, hn::Broadcast<2>(reach), reach), hn::Broadcast<2>(low));
  }
  return hn::Mul(hn::Set(D4(), kRasterGamma), hn::Add(terms, farthest));
}

// What a cell looks like on the screen, lane 0 for x, 1 for y, 2 for depth.
struct CellShape {
  V4 low, high;  // of its corners
  V4 half;       // of a voxel's box, level 0, not padded
  V4 pad;
};

// Let c be the middle of a voxel, s(c) its place on the screen, and F(u) = X(u) - s(c) W(u), which
// is trilinear and 0 at c. A point c + e of the voxel is at s(c) + F(c + e) / W(c + e). Along one
// axis F changes by |e_a| times a mean of the four edges' (dX - s(c) dW) / 8, and dX - s(c) dW
// = ds (W0 + W1) / 2 + ((s0 + s1) / 2 - s(c)) dW. So with |e_a| = 1/2, the cell's side being 8,
//   |s(c + e) - s(c)| <= 1/16 sum_a max_edges (|ds| W_max + extent |dW|) / W_min.
HWY_INLINE CellShape shape_of(const ClipPoint* screen, const uint16_t* corner, bool perspective,
                              V4 reach) {
  const D4 d;
  V4 p[8];
  for (int i = 0; i < 8; ++i) p[i] = hn::Load(d, &screen[corner[i]].x);
  CellShape out;
  out.low = hn::Min(hn::Min(hn::Min(p[0], p[1]), hn::Min(p[2], p[3])),
                    hn::Min(hn::Min(p[4], p[5]), hn::Min(p[6], p[7])));
  out.high = hn::Max(hn::Max(hn::Max(p[0], p[1]), hn::Max(p[2], p[3])),
                     hn::Max(hn::Max(p[4], p[5]), hn::Max(p[6], p[7])));
  const V4 x = hn::Max(hn::Max(length_of(p[0], p[1]), length_of(p[2], p[3])),
                       hn::Max(length_of(p[4], p[5]), length_of(p[6], p[7])));
  const V4 y = hn::Max(hn::Max(length_of(p[0], p[2]), length_of(p[1], p[3])),
                       hn::Max(length_of(p[4], p[6]), length_of(p[5], p[7])));
  const V4 z = hn::Max(hn::Max(length_of(p[0], p[4]), length_of(p[1], p[5])),
                       hn::Max(length_of(p[2], p[6]), length_of(p[3], p[7])));
  const V4 sum = hn::Mul(hn::Add(hn::Add(x, y), z), hn::Set(d, 1.0f / 16.0f));
  out.half = sum;
  if (perspective) {
    const V4 inverse = hn::Div(hn::Set(d, 1.0f), hn::Broadcast<2>(out.low));
    const V4 extent = hn::Sub(out.high, out.low);
    const V4 turned = hn::Mul(extent, hn::Broadcast<2>(sum));
    out.half = hn::Mul(hn::MulAdd(sum, hn::Broadcast<2>(out.high), turned), inverse);
  }
  // Beside it, the rounding of `half` itself.
  out.pad = hn::MulAdd(hn::Set(d, 2.0f * kRasterGamma), out.half,
                       pad_of(out.low, out.high, perspective, reach));
  return out;
}

HWY_INLINE bool in_view(const BlockJob& job, PixelRange x, PixelRange y, RasterCell& out) {
  if (x.empty() || y.empty() || x.last < 0 || y.last < 0) return false;
  if (x.first >= static_cast<int>(job.width) || y.first >= static_cast<int>(job.height)) {
    return false;
  }
  out.x0 = static_cast<int16_t>(x.first);
  out.x1 = static_cast<int16_t>(x.last);
  out.y0 = static_cast<int16_t>(y.first);
  out.y1 = static_cast<int16_t>(y.last);
  return true;
}

HWY_INLINE uint8_t level_to_draw(const RasterSettings& settings, float size) {
  uint8_t level = 0;
  if (!settings.lod) return level;
  for (; level < kCellLevel && size < settings.smallest; ++level) size += size;
  return level;
}

HWY_INLINE float middle_depth(const BlockJob& job, const SvoCell& cell) {
  float sum = 0.0f;
  for (const uint16_t c : cell.corner) sum += job.points[c].depth;
  return 0.125f * sum;
}

// A cell whose block is not there: its one box instead of its voxels. It is hidden by what hides
// these, so that a block which is seen no more is not asked for either.
HWY_INLINE void draw_as_cell(const BlockJob& job, const SvoCell& cell, const RasterBlock& block,
                             RasterCell& out) {
  if (block.later) out.fine = kStandIn;
  out.path = RasterPath::rectangle;
  out.level = kCellLevel;
  out.far_depth = std::clamp(middle_depth(job, cell), out.near_depth, out.far_depth);
}

// A cell that crosses the near plane.
HWY_NOINLINE bool view_near_cell(const BlockJob& job, const SvoCell& cell, const float* reach,
                                 RasterBlock& block, RasterCell& out) {
  ClipPoint corners[8];
  for (int i = 0; i < 8; ++i) corners[i] = job.points[cell.corner[i]];
  const SideLines view{0.0f, 0.0f, static_cast<float>(job.width), static_cast<float>(job.height)};
  if (misses(corners, job.map->perspective, reach, view)) return false;
  const ScreenBox box = project_hull(corners, job.map->near, job.map->perspective, reach);
  if (!box.seen()) return false;
  out.path = RasterPath::near;
  out.near_depth = box.near_depth;
  out.far_depth = box.far_depth;
  out.fine = 1;
  block.voxel = std::max(block.voxel, static_cast<float>(std::max(job.width, job.height)));
  if (!block.resident) draw_as_cell(job, cell, block, out);
  return in_view(job, pixel_range(box.x0, box.x1), pixel_range(box.y0, box.y1), out);
}

HWY_INLINE bool view_cell(const BlockJob& job, const SvoCell& cell, V4 reach_row,
                          RasterBlock& block, RasterCell& out) {
  const D4 d;
  const CellShape shape = shape_of(job.screen, cell.corner, job.map->perspective, reach_row);
  alignas(16) float low[4], high[4], half[4], pad[4];
  hn::Store(shape.low, d, low);
  hn::Store(shape.high, d, high);
  if (!(low[2] > job.map->near)) {
    return high[2] > job.map->near && view_near_cell(job, cell, block.reach, block, out);
  }
  hn::Store(shape.half, d, half);
  hn::Store(shape.pad, d, pad);
  out.level = level_to_draw(*job.settings, 2.0f * std::max(half[0], half[1]));
  out.near_depth = low[2];
  out.far_depth = high[2];
  float grow_x = pad[0], grow_y = pad[1];
  if (out.level == kCellLevel) {
    // The one box of a cell is that of its corners.
    out.path = RasterPath::rectangle;
    out.near_depth = out.far_depth = std::clamp(middle_depth(job, cell), low[2], high[2]);
  } else {
    // Middles of voxels lie among the corners, and their boxes reach half their size beyond.
    const float side = static_cast<float>(1u << out.level);
    const float wide = side + 2.0f * job.settings->margin;
    out.half_x = wide * half[0] + pad[0];
    out.half_y = wide * half[1] + pad[1];
    if (is_large(*job.settings, out)) {
      // They are drawn within their own outlines, which lie among the corners but for rounding.
      grow_x = grow_y = 2.0f * std::max(pad[0], pad[1]);
    } else {
      grow_x += out.half_x;
      grow_y += out.half_y;
    }
    out.fine = 1;
    block.voxel = std::max(block.voxel, 2.0f * std::max(half[0], half[1]));
    if (!block.resident) draw_as_cell(job, cell, block, out);
  }
  return in_view(job, pixel_range(low[0] - grow_x, high[0] + grow_x),
                 pixel_range(low[1] - grow_y, high[1] + grow_y), out);
}

// Boxes of a block's eight octants, from the places of all corners on their closed cubes.
HWY_INLINE void extend_octants(const BlockJob& job, const uint16_t* places, RowBox octants[8]) {
  constexpr uint32_t kHalf = kBlockSide / kCellSide / 2, kSide = 2 * kHalf + 1;
  for (uint32_t i = 0; i < job.corners; ++i) {
    const uint32_t at[3] = {places[i] % kSide, places[i] / kSide % kSide,
                            places[i] / (kSide * kSide)};
    const V4 p = hn::Load(D4(), &job.screen[i].x);
    for (uint32_t octant = 0; octant < 8; ++octant) {
      bool within = true;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        within &= (octant >> axis & 1) != 0 ? at[axis] >= kHalf : at[axis] <= kHalf;
      }
      if (within) octants[octant].extend(p);
    }
  }
}

HWY_INLINE uint32_t octant_of(const SvoCell& cell) {
  return (cell.place >> 2 & 1) | (cell.place >> 5 & 1) << 1 | (cell.place >> 8 & 1) << 2;
}

// Lists the nodes of level 5 of a block that is a few pixels large; none of it is before the near
// plane. They are drawn as their boxes.
HWY_NOINLINE void view_nodes(const BlockJob& job, V4 reach, RasterBlock& block) {
  const D4 d;
  const Svo& svo = *block.svo;
  const SvoBlock& at = svo.blocks[block.block];
  RowBox octants[8];
  extend_octants(job, svo.corner_places.data() + at.first_corner, octants);
  const SvoNode& whole = svo.nodes[job.node];
  for (uint32_t n = whole.first; n < whole.first + whole.count; ++n) {
    const RowBox& box = octants[octant_of(svo.cells[svo.nodes[svo.nodes[n].first].first])];
    alignas(16) float low[4], high[4], pad[4];
    hn::Store(box.low, d, low);
    hn::Store(box.high, d, high);
    hn::Store(pad_of(box.low, box.high, job.map->perspective, reach), d, pad);
    RasterCell& out = job.cells[block.cells];
    out = RasterCell{.unit = block.first_unit + static_cast<uint32_t>(svo.cells.size()) + n};
    out.path = RasterPath::rectangle;
    out.near_depth = out.far_depth = std::clamp(0.5f * (low[2] + high[2]), low[2], high[2]);
    if (in_view(job, pixel_range(low[0] - pad[0], high[0] + pad[0]),
                pixel_range(low[1] - pad[1], high[1] + pad[1]), out)) {
      ++block.cells;
    }
  }
}

// Whether even nodes of level 4 are too small to draw.
HWY_INLINE bool is_small(const BlockJob& job, const RowBox& box) {
  alignas(16) float size[4], low[4];
  hn::Store(hn::Sub(box.high, box.low), D4(), size);
  hn::Store(box.low, D4(), low);
  return job.settings->lod && low[2] > job.map->near &&
         std::max(size[0], size[1]) < 4.0f * job.settings->smallest;
}

void view_block_kernel(const BlockJob& job, uint32_t index, RasterBlock& block) {
  const RowBox box = project_corners(job, block.reach);
  const V4 reach_row = hn::LoadU(D4(), block.reach);
  block.cells = 0;
  block.voxel = 0.0f;
  if (is_small(job, box)) return view_nodes(job, reach_row, block);
  const Svo& svo = *block.svo;
  const uint32_t first = svo.blocks[block.block].first_cell;
  const uint32_t end = svo.blocks[block.block + 1].first_cell;
  for (uint32_t c = first; c < end; ++c) {
    RasterCell& out = job.cells[block.cells];
    out = RasterCell{.unit = block.first_unit + c, .block = index, .cell = c};
    if (view_cell(job, svo.cells[c], reach_row, block, out)) ++block.cells;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(view_block_kernel);

void view_block(const BlockJob& job, uint32_t index, RasterBlock& block) {
  HWY_DYNAMIC_DISPATCH(view_block_kernel)(job, index, block);
}

}  // namespace sinew
#endif
