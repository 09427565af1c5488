// Where voxels that are skinned one by one are on the screen: stands in for the trilinear map of a
// cell. See thesis_skinned.h. Included once for each target, see rasterize_tile_kernels.cpp.
#if defined(SINEW_SVO_THESIS_PLACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_THESIS_PLACE_INL_H
#undef SINEW_SVO_THESIS_PLACE_INL_H
#else
#define SINEW_SVO_THESIS_PLACE_INL_H
#endif

#include "sinew/svo/draw/rasterize_voxels-inl.h"
#include "sinew/svo/thesis/thesis_skinned.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// A cell of the opponent.
struct SkinnedCell {
  const uint16_t* first_spot = nullptr;  // where the cell's list begins
  const uint32_t* joints = nullptr;      // of its first voxel; slots, if they are in the palette
  const uint32_t* weights = nullptr;
  float x = 0.0f, y = 0.0f, z = 0.0f;  // middle of the voxel with spot 0, in voxels
  float side = 1.0f;                   // voxels
  float offset_x = 0.0f, offset_y = 0.0f;
};

struct GatherMap : SkinnedCell {
  const float* rows = nullptr;
};

// Lane j of row[c] is number c of joint j of the palette.
struct PaletteMap : SkinnedCell {
  alignas(64) float row[12][16];
};

HWY_INLINE Vi influence(Vu packed, int k) {
  const Du du;
  const Vu byte = k == 0   ? packed
                  : k == 1 ? hn::ShiftRight<8>(packed)
                  : k == 2 ? hn::ShiftRight<16>(packed)
                           : hn::ShiftRight<24>(packed);
  return hn::BitCast(Di(), hn::And(byte, hn::Set(du, 255u)));
}

HWY_INLINE Vf looked_up(const GatherMap& map, int c, Vi joint) {
  return hn::GatherIndex(Df(), map.rows + c, hn::ShiftLeft<4>(joint));
}
HWY_INLINE Vf looked_up(const PaletteMap& map, int c, Vi slot) {
  const Df d;
  return hn::TableLookupLanes(hn::Load(d, map.row[c]), hn::IndicesFromVec(d, slot));
}

template <class Map>
HWY_INLINE VoxelVector place_skinned(const Map& map, const uint16_t* spots, bool perspective) {
  const Df d;
  const Du du;
  const SpotVector at = load_spots(spots);
  VoxelVector out;
  out.spot = at.spot;
  const Vf side = hn::Set(d, map.side);
  const Vf x = hn::MulAdd(at.x, side, hn::Set(d, map.x));
  const Vf y = hn::MulAdd(at.y, side, hn::Set(d, map.y));
  const Vf z = hn::MulAdd(at.z, side, hn::Set(d, map.z));
  const size_t first = static_cast<size_t>(spots - map.first_spot);
  const Vu joints = hn::LoadU(du, map.joints + first);
  const Vu weights = hn::LoadU(du, map.weights + first);
  Vf sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int k = 0; k < 4; ++k) {
    const Vi joint = influence(joints, k);
    const Vf weight = hn::Mul(hn::ConvertTo(d, influence(weights, k)), hn::Set(d, 1.0f / 255.0f));
    for (int row = 0; row < 3; ++row) {
      Vf value = looked_up(map, 4 * row + 3, joint);
      value = hn::MulAdd(looked_up(map, 4 * row, joint), x, value);
      value = hn::MulAdd(looked_up(map, 4 * row + 1, joint), y, value);
      value = hn::MulAdd(looked_up(map, 4 * row + 2, joint), z, value);
      sum[row] = hn::MulAdd(weight, value, sum[row]);
    }
  }
  out.x = sum[0];
  out.y = sum[1];
  out.depth = sum[2];
  if (perspective) {
    const Vf inverse = hn::Div(hn::Set(d, 1.0f), out.depth);
    out.x = hn::Mul(out.x, inverse);
    out.y = hn::Mul(out.y, inverse);
  }
  out.x = hn::Sub(out.x, hn::Set(d, map.offset_x));
  out.y = hn::Sub(out.y, hn::Set(d, map.offset_y));
  return out;
}

HWY_INLINE VoxelVector place_voxels(const GatherMap& map, const uint16_t* spots, bool perspective) {
  return place_skinned(map, spots, perspective);
}
HWY_INLINE VoxelVector place_voxels(const PaletteMap& map, const uint16_t* spots,
                                    bool perspective) {
  return place_skinned(map, spots, perspective);
}

// What both lookups have in common; `joints` are still to be set.
HWY_INLINE void set_cell(const SkinnedTable& table, const SvoBlock& block, const SvoCell& cell,
                         uint32_t first, uint32_t level, const Spots& spots, float offset_x,
                         float offset_y, SkinnedCell& out) {
  out.first_spot = spots.spot;
  out.weights = table.voxels->levels[level].weights.data() + first;
  out.side = static_cast<float>(1u << level);
  const uint32_t place = cell.place;
  const auto middle = [&](uint32_t of_block, uint32_t of_cell) {
    return static_cast<float>(kBlockSide * of_block + kCellSide * of_cell) + 0.5f * out.side;
  };
  out.x = middle(block.x, place & 7);
  out.y = middle(block.y, place >> 3 & 7);
  out.z = middle(block.z, place >> 6);
  out.offset_x = offset_x;
  out.offset_y = offset_y;
}

HWY_INLINE void set_palette(const SkinnedTable& table, uint32_t cell, PaletteMap& out) {
  const auto& palette = table.voxels->palettes[cell];
  for (uint32_t j = 0; j < table.voxels->palette_sizes[cell]; ++j) {
    const float* const row = table.rows.data() + size_t{16} * palette[j];
    for (uint32_t c = 0; c < 12; ++c) out.row[c][j] = row[c];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
