// The planes of a tile, and boxes drawn straight into them. Included once for each target.
#if defined(SINEW_SVO_RASTERIZE_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_PLANES_INL_H
#undef SINEW_SVO_RASTERIZE_PLANES_INL_H
#else
#define SINEW_SVO_RASTERIZE_PLANES_INL_H
#endif

#include "sinew/svo/rasterize_voxels-inl.h"

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
  for (uint32_t i = 0; i < TilePlanes::kSize; ++i) {
    planes.depth_storage[i] = 0.0f;
    planes.id_storage[i] = 0;
  }
  for (uint32_t y = 0; y < job.height; ++y) {
    for (uint32_t x = 0; x < job.width; ++x) {
      planes.depth[y * kTileSide + x] = __builtin_inff();
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

HWY_INLINE Vi to_pixel(Vf v) {
  const Df d;
  return hn::ConvertTo(Di(), hn::Min(hn::Max(v, hn::Set(d, -32000.0f)), hn::Set(d, 32000.0f)));
}

// Voxels of a cell one by one: for those of more than a few pixels.
template <bool kKeys, class Map>
HWY_INLINE void draw_boxes(const TileJob& job, const RasterCell& cell, const Map& map,
                           const Spots& spots, uint32_t id, TilePlanes& planes) {
  const Df d;
  const Vf wide = hn::Set(d, 2.0f * cell.half_x), high = hn::Set(d, 2.0f * cell.half_y);
  const Vf near = hn::Set(d, cell.near_depth), far = hn::Set(d, cell.far_depth);
  for (uint32_t i = 0; i < spots.count; i += lanes()) {
    const VoxelVector voxels = place_voxels(map, spots.spot + i, job.perspective);
    alignas(64) int32_t x0[16], y0[16], x1[16], y1[16];
    alignas(64) float depth[16];
    const Di di;
    hn::Store(to_pixel(hn::Ceil(voxels.x)), di, x0);
    hn::Store(to_pixel(hn::Ceil(voxels.y)), di, y0);
    hn::Store(to_pixel(hn::Floor(hn::Add(voxels.x, wide))), di, x1);
    hn::Store(to_pixel(hn::Floor(hn::Add(voxels.y, high))), di, y1);
    hn::Store(hn::Min(hn::Max(voxels.depth, near), far), d, depth);
    const uint32_t count = std::min(lanes(), spots.count - i);
    for (uint32_t k = 0; k < count; ++k) {
      const TileBox box =
          clip_to_tile(job, cell.x0 + x0[k], cell.y0 + y0[k], cell.x0 + x1[k], cell.y0 + y1[k]);
      if (box.empty()) continue;
      put_box<kKeys>(planes, box, depth[k], id | code_of_spot(spots.spot[i + k], cell.level));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
