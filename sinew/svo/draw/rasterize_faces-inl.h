// Voxels of many pixels, drawn as boxes with faces: all pixels within their outline, each with the
// depth of the face that its ray meets first. Based on: D. Bautembach, "Animated Sparse Voxel
// Octrees", 2011, figure 12. Included once for each target.
#if defined(SINEW_SVO_RASTERIZE_FACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_FACES_INL_H
#undef SINEW_SVO_RASTERIZE_FACES_INL_H
#else
#define SINEW_SVO_RASTERIZE_FACES_INL_H
#endif

#include "sinew/svo/draw/rasterize_hull.h"
#include "sinew/svo/draw/rasterize_planes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// A linear function of the pixel, for a row.
HWY_INLINE Vf along_row(const float* f, Vf x, Vf y) {
  const Df d;
  return hn::MulAdd(hn::Set(d, f[0]), x, hn::MulAdd(hn::Set(d, f[1]), y, hn::Set(d, f[2])));
}

HWY_INLINE Vf depth_of_faces(const FaceDepths& faces, Vf x, Vf y) {
  const Df d;
  Vf depth = hn::Set(d, faces.low);
  for (int i = 0; i < 3; ++i) {
    const Vf n = along_row(faces.n[i], x, y), o = along_row(faces.o[i], x, y);
    const Vf enters = hn::Div(hn::Sub(o, hn::CopySign(hn::Set(d, 1.0f), n)), n);
    // What is not a number is left out: of two operands the second is kept.
    depth = hn::Max(enters, depth);
  }
  return hn::Min(depth, hn::Set(d, faces.high));
}

template <bool kKeys>
HWY_NOINLINE void draw_faces(const TileJob& job, const RasterCell& cell, const ClipPoint* corners,
                             const float* reach, uint32_t id, TilePlanes& planes) {
  const Outline outline = outline_of(corners, job.near, job.perspective, reach);
  if (outline.count == 0) return;
  int16_t low[kTileSide], high[kTileSide];
  const int rows = static_cast<int>(job.height), columns = static_cast<int>(job.width);
  rows_of(outline, static_cast<int>(job.y), rows, low, high);
  FaceDepths faces = face_depths(corners, job.near, job.perspective);
  // Exactly as far as hierarchical z takes the cell to be.
  faces.low = std::max(faces.low, cell.near_depth);
  faces.high = std::max(faces.high, cell.near_depth);
  const Df d;
  const Vu ids = hn::Set(Du(), id);
  for (int row = 0; row < rows; ++row) {
    const int first = std::max(low[row] - static_cast<int>(job.x), 0);
    const int last = std::min(high[row] - static_cast<int>(job.x), columns - 1);
    const Vf y = hn::Set(d, static_cast<float>(static_cast<int>(job.y) + row) + 0.5f);
    for (int x = first; x <= last; x += static_cast<int>(lanes())) {
      const Vf column = hn::Iota(d, static_cast<float>(static_cast<int>(job.x) + x) + 0.5f);
      put<kKeys>(planes, row * static_cast<int>(kTileSide) + x,
                 hn::FirstN(d, static_cast<size_t>(last - x + 1)), depth_of_faces(faces, column, y),
                 ids);
    }
  }
}

HWY_INLINE Vi to_pixel(Vf v) {
  const Df d;
  return hn::ConvertTo(Di(), hn::Min(hn::Max(v, hn::Set(d, -32000.0f)), hn::Set(d, 32000.0f)));
}

// Voxels of a cell one by one, as rectangles.
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
      const VoxelCode code = code_of_spot(spots.spot[i + k], cell.level);
      put_box<kKeys>(planes, box, depth[k], id | code);
    }
  }
}

// As boxes with faces.
template <bool kKeys>
HWY_NOINLINE void draw_large(const TileJob& job, const RasterCell& cell, const RasterBlock& block,
                             const Spots& spots, uint32_t id, TilePlanes& planes) {
  const SvoCell& lattice = block.svo->cells[cell.cell];
  for (uint32_t i = 0; i < spots.count; ++i) {
    const VoxelCode code = code_of_spot(spots.spot[i], cell.level);
    ClipPoint corners[8];
    voxel_corners(job.points + block.first_corner, lattice, code, corners);
    draw_faces<kKeys>(job, cell, corners, block.reach, id | code, planes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
