// Voxels of a pixel or two, the common case. A cell is drawn into a picture of its own of 16 by 16
// pixels, and that is laid over the tile.
//
// All voxels of a cell have boxes of one size, so a box covers m or m + 1 columns and n or n + 1
// rows. Each of these four classes has a plane, in which a voxel is noted with a single minimum at
// the first pixel of its box; when the cell is complete, rows of the planes are spread over as many
// columns and rows as their class says, a vector at a time. So the cost of a voxel does not depend
// on how much it covers, and what it depends on are 32-bit values of one size and alignment.
// A noted voxel is
//   31        9 8    0
//   [ depth 23 | spot ]    depth in steps between the cell's least and greatest
// or, if only depth is wanted, the bits of its depth.
#if defined(SINEW_SVO_RASTERIZE_DENSE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_DENSE_INL_H
#undef SINEW_SVO_RASTERIZE_DENSE_INL_H
#else
#define SINEW_SVO_RASTERIZE_DENSE_INL_H
#endif

#include <atomic>

#include "sinew/svo/draw/rasterize_planes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

inline constexpr int kDenseSide = 16;    // pixels
inline constexpr int kDenseClasses = 4;  // 0 to 3 columns, or rows; of 0 nothing is ever read
inline constexpr uint32_t kEmpty = 0xffffffffu;

struct DensePlanes {
  // One row more, before the first, that stays empty.
  static constexpr int kPlane = (kDenseSide + 1) * kDenseSide;
  static constexpr int kSize = kDenseClasses * kDenseClasses * kPlane;
  alignas(64) uint32_t noted[kSize];
  alignas(64) uint32_t place[16], value[16];  // on their way from vectors

  uint32_t* plane(int columns, int rows) {
    return noted + (rows * kDenseClasses + columns) * kPlane + kDenseSide;
  }
};

HWY_INLINE void clear(DensePlanes& planes) {
  for (uint32_t& v : planes.noted) v = kEmpty;
}

struct DenseShape {
  int columns = 0, rows = 0;  // that every box covers at least: m, n
  int width = 0, height = 0;  // pixels of the cell
};

// How many pixel centres an interval of this length contains at least; rounding may find one less,
// or one more if that is exactly the length.
HWY_INLINE int least_count(float length) {
  return static_cast<int>(length + 1e-4f);
}

HWY_INLINE bool is_dense(const RasterCell& cell, DenseShape& shape) {
  shape.columns = least_count(2.0f * std::min(cell.half_x, 100.0f));
  shape.rows = least_count(2.0f * std::min(cell.half_y, 100.0f));
  shape.width = cell.x1 - cell.x0 + 1;
  shape.height = cell.y1 - cell.y0 + 1;
  // A row spread by m must not reach into the one before: the last m columns stay empty.
  return shape.columns + 1 < kDenseClasses && shape.rows + 1 < kDenseClasses &&
         shape.width <= kDenseSide - shape.columns && shape.height <= kDenseSide;
}

// Depth as steps.
struct DepthScale {
  static constexpr float kSteps = 8388606.0f;  // 2^23 - 2: all ones is no depth
  float near = 0.0f, to_steps = 0.0f, from_steps = 0.0f;
};
HWY_INLINE DepthScale depth_scale(const RasterCell& cell) {
  const float range = cell.far_depth - cell.near_depth;
  if (!(range > 1e-30f)) return {cell.near_depth, 0.0f, 0.0f};
  return {cell.near_depth, DepthScale::kSteps / range, range / DepthScale::kSteps};
}

// The nearest whole number, 0 to 2^23 - 1, in the lower 23 bits; above them is the exponent.
HWY_INLINE Vu whole_bits(Vf v) {
  return hn::BitCast(Du(), hn::Add(v, hn::Set(Df(), 8388608.0f)));
}

HWY_INLINE void note(uint32_t* first, Vu places, Vu values, uint32_t count, DensePlanes& planes) {
  const Du du;
  hn::Store(places, du, planes.place);
  hn::Store(values, du, planes.value);
  // They are to be read back: taking vectors apart lane by lane takes longer.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  for (uint32_t k = 0; k < count; ++k) {
    uint32_t* const at = first + planes.place[k];
    const uint32_t old = *at, now = planes.value[k];
    *at = now < old ? now : old;
  }
}

template <bool kKeys, class Map>
HWY_INLINE void note_voxels(const RasterCell& cell, const DenseShape& shape, const Map& map,
                            const Spots& spots, bool perspective, DensePlanes& planes) {
  const Df d;
  const Du du;
  const DepthScale scale = depth_scale(cell);
  const Vf wide = hn::Set(d, 2.0f * cell.half_x), high = hn::Set(d, 2.0f * cell.half_y);
  const Vf zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const Vf last_x = hn::Set(d, static_cast<float>(shape.width - 1));
  const Vf last_y = hn::Set(d, static_cast<float>(shape.height - 1));
  const Vf less_columns = hn::Set(d, static_cast<float>(shape.columns - 1));
  const Vf less_rows = hn::Set(d, static_cast<float>(shape.rows - 1));
  uint32_t* const first = planes.plane(shape.columns, shape.rows);
  for (uint32_t i = 0; i < spots.count; i += lanes()) {
    const VoxelVector v = place_voxels(map, spots.spot + i, perspective);
    const Vf x0 = hn::Ceil(v.x), y0 = hn::Ceil(v.y);
    // 0 or 1 more than what all cover.
    const Vf more_x = hn::Sub(hn::Sub(hn::Floor(hn::Add(v.x, wide)), x0), less_columns);
    const Vf more_y = hn::Sub(hn::Sub(hn::Floor(hn::Add(v.y, high)), y0), less_rows);
    Vf at =
        hn::MulAdd(hn::Min(hn::Max(y0, zero), last_y), hn::Set(d, static_cast<float>(kDenseSide)),
                   hn::Min(hn::Max(x0, zero), last_x));
    at = hn::MulAdd(hn::Min(hn::Max(more_x, zero), one),
                    hn::Set(d, static_cast<float>(DensePlanes::kPlane)), at);
    at = hn::MulAdd(hn::Min(hn::Max(more_y, zero), one),
                    hn::Set(d, static_cast<float>(kDenseClasses * DensePlanes::kPlane)), at);
    Vu noted;
    if (kKeys) {
      const Vf steps =
          hn::Mul(hn::Sub(v.depth, hn::Set(d, scale.near)), hn::Set(d, scale.to_steps));
      const Vf kept = hn::Min(hn::Max(steps, zero), hn::Set(d, DepthScale::kSteps));
      noted = hn::Or(hn::ShiftLeft<9>(whole_bits(kept)), v.spot);
    } else {
      noted = hn::BitCast(
          du, hn::Min(hn::Max(v.depth, hn::Set(d, cell.near_depth)), hn::Set(d, cell.far_depth)));
    }
    note(first, hn::And(whole_bits(at), hn::Set(du, 0xffffu)), noted,
         std::min(lanes(), spots.count - i), planes);
  }
}

// The row of all voxels that cover kRows rows from here on, spread over their columns.
template <int kColumns>
HWY_INLINE Vu spread_columns(const uint32_t* fewer, const uint32_t* more) {
  const Du du;
  Vu least = hn::LoadU(du, more);
  for (int k = 1; k <= kColumns; ++k) least = hn::Min(least, hn::LoadU(du, more - k));
  for (int k = 0; k < kColumns; ++k) least = hn::Min(least, hn::LoadU(du, fewer - k));
  return least;
}

// Where the cell's picture goes, and as what.
struct DenseTarget {
  int x = 0, y = 0;  // of its first pixel in the tile, maybe negative
  uint32_t id = 0;
  uint32_t tile_width = 0, tile_height = 0;
  DepthScale scale;
};

template <bool kKeys>
HWY_INLINE void lay_row(const DenseTarget& to, int column, int row, Vu noted, TilePlanes& planes) {
  const Df d;
  const Di di;
  const Du du;
  const Vu pixel = hn::Add(hn::Iota(du, static_cast<uint32_t>(0)),
                           hn::Set(du, static_cast<uint32_t>(to.x + column)));
  const auto inside =
      hn::And(hn::Lt(pixel, hn::Set(du, to.tile_width)), hn::Ne(noted, hn::Set(du, kEmpty)));
  const int at = (to.y + row) * static_cast<int>(kTileSide) + to.x + column;
  if (!kKeys) {
    put<false>(planes, at, hn::RebindMask(d, inside), hn::BitCast(d, noted), noted);
    return;
  }
  const Vf steps = hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<9>(noted)));
  const Vf depth = hn::MulAdd(steps, hn::Set(d, to.scale.from_steps), hn::Set(d, to.scale.near));
  const Vu id = hn::Add(hn::Set(du, to.id), hn::And(noted, hn::Set(du, 511u)));
  put<true>(planes, at, hn::RebindMask(d, inside), depth, id);
}

// Spreads what was noted and lays it over the tile. Leaves the classes' planes empty.
template <bool kKeys, int kColumns, int kRows>
HWY_NOINLINE void lay_cell(const DenseShape& shape, const DenseTarget& to, DensePlanes& dense,
                           TilePlanes& planes) {
  const Du du;
  const Vu empty = hn::Set(du, kEmpty);
  uint32_t* const p00 = dense.plane(kColumns, kRows);
  uint32_t* const p10 = dense.plane(kColumns + 1, kRows);
  uint32_t* const p01 = dense.plane(kColumns, kRows + 1);
  uint32_t* const p11 = dense.plane(kColumns + 1, kRows + 1);
  for (int column = 0; column < shape.width; column += static_cast<int>(lanes())) {
    Vu fewer[3] = {empty, empty, empty}, more[3] = {empty, empty, empty};  // rows before this
    for (int row = 0; row < shape.height; ++row) {
      const int at = row * kDenseSide + column;
      more[0] = spread_columns<kColumns>(p01 + at, p11 + at);
      Vu least = more[0];
      if (kRows > 0) {
        fewer[0] = spread_columns<kColumns>(p00 + at, p10 + at);
        least = hn::Min(least, hn::Min(fewer[0], more[1]));
      }
      if (kRows > 1) least = hn::Min(least, hn::Min(fewer[1], more[2]));
      more[2] = more[1];
      more[1] = more[0];
      fewer[1] = fewer[0];
      if (static_cast<uint32_t>(to.y + row) < to.tile_height) {
        lay_row<kKeys>(to, column, row, least, planes);
      }
    }
  }
  for (int i = 0; i < shape.height * kDenseSide; i += static_cast<int>(lanes())) {
    if (kColumns > 0 && kRows > 0) hn::StoreU(empty, du, p00 + i);
    if (kRows > 0) hn::StoreU(empty, du, p10 + i);
    if (kColumns > 0) hn::StoreU(empty, du, p01 + i);
    hn::StoreU(empty, du, p11 + i);
  }
}

template <bool kKeys, class Map>
HWY_INLINE void draw_dense(const TileJob& job, const RasterCell& cell, const DenseShape& shape,
                           const Map& map, const Spots& spots, uint32_t id, DensePlanes& dense,
                           TilePlanes& planes) {
  note_voxels<kKeys>(cell, shape, map, spots, job.perspective, dense);
  const DenseTarget to{cell.x0 - static_cast<int>(job.x),
                       cell.y0 - static_cast<int>(job.y),
                       id + kFirstCode[cell.level],
                       job.width,
                       job.height,
                       depth_scale(cell)};
  switch (shape.columns * 3 + shape.rows) {
    case 0:
      return lay_cell<kKeys, 0, 0>(shape, to, dense, planes);
    case 1:
      return lay_cell<kKeys, 0, 1>(shape, to, dense, planes);
    case 2:
      return lay_cell<kKeys, 0, 2>(shape, to, dense, planes);
    case 3:
      return lay_cell<kKeys, 1, 0>(shape, to, dense, planes);
    case 4:
      return lay_cell<kKeys, 1, 1>(shape, to, dense, planes);
    case 5:
      return lay_cell<kKeys, 1, 2>(shape, to, dense, planes);
    case 6:
      return lay_cell<kKeys, 2, 0>(shape, to, dense, planes);
    case 7:
      return lay_cell<kKeys, 2, 1>(shape, to, dense, planes);
    default:
      return lay_cell<kKeys, 2, 2>(shape, to, dense, planes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
