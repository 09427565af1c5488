// The planes of a tile, and boxes drawn straight into them. Included once for each target.
#if defined(SINEW_SVO_RASTERIZE_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_PLANES_INL_H
#undef SINEW_SVO_RASTERIZE_PLANES_INL_H
#else
#define SINEW_SVO_RASTERIZE_PLANES_INL_H
#endif

#include "sinew/svo/draw/rasterize_voxels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// What is in front so far. Of equal depths the least id wins, so no order of drawing matters.
//   id   [ place in the tile's list + 1: 22 bits | code: 10 ], 0 where nothing is new
struct TilePlanes {
  static constexpr uint32_t kSlack = 16;  // rows are read and written back by whole vectors
  static constexpr uint32_t kSize = kTileSide * kTileSide + 2 * kSlack;
  alignas(64) float depth_storage[kSize];
  alignas(64) uint32_t id_storage[kSize];
  float* depth = depth_storage + kSlack;
  uint32_t* id = id_storage + kSlack;
};
inline constexpr uint32_t kMostListed = (1u << 22) - 1;

// Pixels beyond the tile's edge are 0: in front of all, and no farthest depth.
HWY_INLINE void clear(const TileJob& job, TilePlanes& planes) {
  const Df d;
  const Du du;
  for (uint32_t i = 0; i < TilePlanes::kSize; i += lanes()) {
    hn::Store(hn::Zero(d), d, planes.depth_storage + i);
    hn::Store(hn::Zero(du), du, planes.id_storage + i);
  }
  const Vf nothing = hn::Set(d, __builtin_inff());
  for (uint32_t y = 0; y < job.height; ++y) {
    for (uint32_t x = 0; x < job.width; x += lanes()) {
      const Vf row = hn::IfThenElseZero(hn::FirstN(d, job.width - x), nothing);
      hn::Store(row, d, planes.depth + y * kTileSide + x);
    }
  }
}

// Puts a vector of pixels at `at`, where `mask` is set and they win.
template <bool kKeys>
HWY_INLINE void put(TilePlanes& planes, int at, hn::Mask<Df> mask, Vf depth, Vu id) {
  const Df d;
  const Du du;
  const Vf old_depth = hn::LoadU(d, planes.depth + at);
  if (!kKeys) {
    const Vf least = hn::Min(depth, old_depth);
    hn::StoreU(hn::IfThenElse(mask, least, old_depth), d, planes.depth + at);
    return;
  }
  const Vu old_id = hn::LoadU(du, planes.id + at);
  const auto equal = hn::And(hn::Eq(depth, old_depth), hn::RebindMask(d, hn::Lt(id, old_id)));
  const auto wins = hn::And(mask, hn::Or(hn::Lt(depth, old_depth), equal));
  hn::StoreU(hn::IfThenElse(wins, depth, old_depth), d, planes.depth + at);
  hn::StoreU(hn::IfThenElse(hn::RebindMask(du, wins), id, old_id), du, planes.id + at);
}

// Pixels of the tile, inclusive.
struct TileBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  bool empty() const { return x0 > x1 || y0 > y1; }
};
HWY_INLINE TileBox clip_to_tile(const TileJob& job, int x0, int y0, int x1, int y1) {
  const int x = static_cast<int>(job.x), y = static_cast<int>(job.y);
  return {std::max(x0 - x, 0), std::max(y0 - y, 0),
          std::min(x1 - x, static_cast<int>(job.width) - 1),
          std::min(y1 - y, static_cast<int>(job.height) - 1)};
}

template <bool kKeys>
HWY_INLINE void put_box(TilePlanes& planes, const TileBox& box, float depth, uint32_t id) {
  const Df d;
  const Vf depths = hn::Set(d, depth);
  const Vu ids = hn::Set(Du(), id);
  for (int x = box.x0; x <= box.x1; x += static_cast<int>(lanes())) {
    const auto mask = hn::FirstN(d, static_cast<size_t>(box.x1 - x + 1));
    for (int y = box.y0; y <= box.y1; ++y) {
      put<kKeys>(planes, y * static_cast<int>(kTileSide) + x, mask, depths, ids);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
