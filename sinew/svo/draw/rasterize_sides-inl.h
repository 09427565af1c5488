// Which voxels of a cell may meet a tile: for cells that have few voxels in each of many tiles, and
// for those close to the eye, whose boxes on the screen are of no use. Included once for each
// target.
//
// Each side of the tile is a plane through the eye, and so a linear function of homogeneous points
// that is not negative on the tile's side of it, say G = X - left W. It is trilinear in a cell.
// From the middle of a voxel it grows by no more than
//   side / 16 sum_axes max_edges |dG|
// (see shape_of() in rasterize_cells_kernels.cpp); where even that is negative, the voxel misses
// the tile. Nothing is divided by depth.
#if defined(SINEW_SVO_RASTERIZE_SIDES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_SIDES_INL_H
#undef SINEW_SVO_RASTERIZE_SIDES_INL_H
#else
#define SINEW_SVO_RASTERIZE_SIDES_INL_H
#endif

#include "sinew/svo/draw/rasterize_voxels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// The functions of the four sides at the corners of a cell: left, right, top, bottom.
struct CellSides {
  ClipPoint at[8];
  V4 pad;  // rounding
};

HWY_INLINE CellSides sides_of(const TileJob& job, const RasterBlock& block, const SvoCell& cell) {
  const D4 d;
  const float left = static_cast<float>(job.x), right = left + static_cast<float>(job.width);
  const float top = static_cast<float>(job.y), bottom = top + static_cast<float>(job.height);
  alignas(16) const float by_x[4] = {1.0f, -1.0f, 0.0f, 0.0f};
  alignas(16) const float by_y[4] = {0.0f, 0.0f, 1.0f, -1.0f};
  alignas(16) const float by_w[4] = {-left, right, -top, bottom};
  const V4 x = hn::Load(d, by_x), y = hn::Load(d, by_y), w = hn::Load(d, by_w);
  CellSides out;
  for (int i = 0; i < 8; ++i) {
    const ClipPoint& p = job.points[block.first_corner + cell.corner[i]];
    const V4 depth = hn::Set(d, job.perspective ? p.depth : 1.0f);
    const V4 at = hn::MulAdd(hn::Set(d, p.x), x, hn::Mul(hn::Set(d, p.y), y));
    hn::Store(hn::MulAdd(depth, w, at), d, &out.at[i].x);
  }
  const float reach = job.perspective ? block.reach[2] : 1.0f;
  const V4 terms = hn::MulAdd(hn::Set(d, block.reach[0]), hn::Abs(x),
                              hn::Mul(hn::Set(d, block.reach[1]), hn::Abs(y)));
  out.pad =
      hn::Mul(hn::Set(d, 2.0f * kRasterGamma), hn::MulAdd(hn::Set(d, reach), hn::Abs(w), terms));
  return out;
}

// By how much the functions may grow within half a voxel of level 0.
HWY_INLINE V4 growth_of(const ClipPoint* at) {
  const D4 d;
  V4 sum = hn::Zero(d);
  for (int axis = 1; axis < 8; axis *= 2) {
    V4 most = hn::Zero(d);
    for (int i = 0; i < 8; ++i) {
      if ((i & axis) != 0) continue;
      most = hn::Max(most, hn::AbsDiff(hn::Load(d, &at[i].x), hn::Load(d, &at[i | axis].x)));
    }
    sum = hn::Add(sum, most);
  }
  return hn::Mul(sum, hn::Set(d, 1.0f / 16.0f));
}

// Whether some side has the whole cell beyond it.
HWY_INLINE bool misses_tile(const CellSides& sides) {
  const D4 d;
  V4 most = hn::Load(d, &sides.at[0].x);
  for (int i = 1; i < 8; ++i) most = hn::Max(most, hn::Load(d, &sides.at[i].x));
  return !hn::AllFalse(d, hn::Lt(most, hn::Neg(sides.pad)));
}

// Keeps the voxels that may meet the tile.
HWY_NOINLINE void keep_in_tile(const CellSides& sides, uint32_t level, Spots& spots) {
  const D4 d4;
  const Df d;
  constexpr uint16_t kCorners[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  const CellMap map = map_of(sides.at, kCorners, level, false, 0.0f, 0.0f);
  const float side = static_cast<float>(1u << level);
  alignas(16) float least[4];
  hn::Store(hn::Neg(hn::MulAdd(growth_of(sides.at), hn::Set(d4, side), sides.pad)), d4, least);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < spots.count; i += lanes()) {
    const SpotVector at = load_spots(spots.spot + i);
    auto inside = hn::Ge(trilinear(map, 0, at.x, at.y, at.z), hn::Set(d, least[0]));
    for (int k = 1; k < 4; ++k) {
      inside = hn::And(inside, hn::Ge(trilinear(map, k, at.x, at.y, at.z), hn::Set(d, least[k])));
    }
    inside = hn::And(inside, hn::FirstN(d, spots.count - i));
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, inside, bits);
    for (uint32_t rest = bits[0] | bits[1] << 8; rest != 0; rest &= rest - 1) {
      spots.spot[kept++] = spots.spot[i + static_cast<uint32_t>(std::countr_zero(rest))];
    }
  }
  spots.count = kept;
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
