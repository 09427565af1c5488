// The voxels of a cell: which there are, and where they are on the screen. Included once for each
// target, see rasterize_tile_kernels.cpp.
#if defined(SINEW_SVO_RASTERIZE_VOXELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SINEW_SVO_RASTERIZE_VOXELS_INL_H
#undef SINEW_SVO_RASTERIZE_VOXELS_INL_H
#else
#define SINEW_SVO_RASTERIZE_VOXELS_INL_H
#endif

#include <bit>
#include <cstring>

#include "sinew/svo/brick.h"
#include "sinew/svo/draw/rasterize_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;
using Df = hn::CappedTag<float, 16>;
using Du = hn::RebindToUnsigned<Df>;
using Di = hn::RebindToSigned<Df>;
using Vf = hn::Vec<Df>;
using Vu = hn::Vec<Du>;
using Vi = hn::Vec<Di>;
HWY_INLINE constexpr uint32_t lanes() {
  return static_cast<uint32_t>(hn::MaxLanes(Df()));
}

// Voxels of a cell. A *spot* names one of the drawn level in 9 bits as codes of level 0 and 1 do,
// less the level's first: x in bits 0, 1 and 6, y in 2, 3 and 7, z in 4, 5 and 8.
struct Spots {
  static constexpr uint32_t kMost = 512, kSlack = 48;
  alignas(64) uint16_t spot[kMost + kSlack];
  uint32_t count = 0;
};

HWY_INLINE uint32_t append_mask(uint64_t mask, uint32_t first, uint32_t count, uint16_t* out) {
  const hn::CappedTag<uint16_t, 32> d;
  constexpr uint32_t kStep = static_cast<uint32_t>(hn::MaxLanes(hn::CappedTag<uint16_t, 32>()));
  const auto start = hn::Iota(d, static_cast<uint16_t>(first));
  for (uint32_t i = 0; i < 64; i += kStep) {
    // Bytes, as far as the vector has lanes; the mask's lowest come first on all our machines.
    const uint64_t part = mask >> i;
    uint8_t bits[8];
    std::memcpy(bits, &part, 8);
    const auto spots = hn::Add(start, hn::Set(d, static_cast<uint16_t>(i)));
    hn::StoreU(hn::Compress(spots, hn::LoadMaskBits(d, bits)), d, out + count);
    const uint64_t within = kStep == 64 ? part : part & ((uint64_t{1} << (kStep & 63)) - 1);
    count += static_cast<uint32_t>(std::popcount(within));
  }
  return count;
}

HWY_INLINE void list_spots(const Svo& svo, const SvoBlock& block, const SvoCell& cell,
                           uint32_t level, Spots& out) {
  out.count = 0;
  const uint64_t* mask = &svo.bricks[block.first_brick + cell.first_brick];
  if (level == 0) {
    for (uint32_t rest = cell.bricks; rest != 0; rest &= rest - 1) {
      const uint32_t brick = static_cast<uint32_t>(std::countr_zero(rest));
      out.count = append_mask(*mask++, brick << 6, out.count, out.spot);
    }
  } else if (level == 1) {
    uint64_t coarse = 0;  // coarse_voxels(), inlined
    for (uint32_t rest = cell.bricks; rest != 0; rest &= rest - 1) {
      const uint32_t brick = static_cast<uint32_t>(std::countr_zero(rest));
      coarse |= coarse_of_brick(*mask++) << coarse_shift(brick);
    }
    out.count = append_mask(coarse, 0, 0, out.spot);
  } else {
    for (uint32_t rest = cell.bricks; rest != 0; rest &= rest - 1) {
      const uint32_t bit = static_cast<uint32_t>(std::countr_zero(rest));
      out.spot[out.count++] = static_cast<uint16_t>((bit & 1) | (bit & 2) << 1 | (bit & 4) << 2);
    }
  }
  if (out.count == 0) return;
  // What fills the last vector are copies of a voxel: they change nothing.
  for (uint32_t i = 0; i < 16; ++i) out.spot[out.count + i] = out.spot[out.count - 1];
}

HWY_INLINE VoxelCode code_of_spot(uint32_t spot, uint32_t level) {
  if (level == 2) return kFirstCode[2] + ((spot & 1) | (spot >> 1 & 2) | (spot >> 2 & 4));
  return kFirstCode[level] + spot;
}

// The trilinear map of a cell's voxels, in whole steps from the first voxel's middle: row k, of
// (x, y, depth), is the factor of the product of the steps along the axes that are the bits of k.
struct CellMap {
  alignas(16) float row[8][4];
};

struct AxisPair {
  V4 base, slope;
};
HWY_INLINE AxisPair along(V4 a, V4 b, V4 first, V4 step) {
  const V4 d = hn::Sub(b, a);
  return {hn::MulAdd(first, d, a), hn::Mul(step, d)};
}

// `offset` in pixels is taken off the places on the screen.
HWY_INLINE CellMap map_of(const ClipPoint* points, const uint16_t* corner, uint32_t level,
                          bool perspective, float offset_x, float offset_y) {
  const D4 d;
  const float side = static_cast<float>(1u << level) / static_cast<float>(kCellSide);
  const V4 step = hn::Set(d, side), first = hn::Set(d, 0.5f * side);
  V4 base[4], slope[4];  // by y and z
  for (int i = 0; i < 4; ++i) {
    const AxisPair x = along(hn::Load(d, &points[corner[2 * i]].x),
                             hn::Load(d, &points[corner[2 * i + 1]].x), first, step);
    base[i] = x.base;
    slope[i] = x.slope;
  }
  V4 value[4][2];  // [bits of x and y][z]
  for (int z = 0; z < 2; ++z) {
    const AxisPair b = along(base[2 * z], base[2 * z + 1], first, step);
    const AxisPair s = along(slope[2 * z], slope[2 * z + 1], first, step);
    value[0][z] = b.base;
    value[2][z] = b.slope;
    value[1][z] = s.base;
    value[3][z] = s.slope;
  }
  alignas(16) const float offsets[4] = {offset_x, offset_y, 0.0f, 0.0f};
  const V4 offset = hn::Load(d, offsets);
  CellMap out;
  for (int i = 0; i < 4; ++i) {
    AxisPair z = along(value[i][0], value[i][1], first, step);
    if (perspective) {
      z.base = hn::NegMulAdd(offset, hn::Broadcast<2>(z.base), z.base);
      z.slope = hn::NegMulAdd(offset, hn::Broadcast<2>(z.slope), z.slope);
    } else if (i == 0) {
      z.base = hn::Sub(z.base, offset);
    }
    hn::Store(z.base, d, out.row[i]);
    hn::Store(z.slope, d, out.row[i + 4]);
  }
  return out;
}

HWY_INLINE Vf trilinear(const CellMap& map, int value, Vf x, Vf y, Vf z) {
  const Df d;
  const Vf a = hn::MulAdd(x, hn::Set(d, map.row[1][value]), hn::Set(d, map.row[0][value]));
  const Vf b = hn::MulAdd(x, hn::Set(d, map.row[3][value]), hn::Set(d, map.row[2][value]));
  const Vf e = hn::MulAdd(x, hn::Set(d, map.row[5][value]), hn::Set(d, map.row[4][value]));
  const Vf f = hn::MulAdd(x, hn::Set(d, map.row[7][value]), hn::Set(d, map.row[6][value]));
  return hn::MulAdd(z, hn::MulAdd(y, f, e), hn::MulAdd(y, b, a));
}

// A vector of voxels: their least covered coordinates, less the map's offset, and depths.
struct VoxelVector {
  Vu spot;
  Vf x, y, depth;
};

// A vector of spots, and where in their cell these are: whole numbers, 0 to 7.
struct SpotVector {
  Vu spot;
  Vf x, y, z;
};

HWY_INLINE SpotVector load_spots(const uint16_t* spots) {
  const Df d;
  const Du du;
  const Di di;
  SpotVector out;
  out.spot = hn::PromoteTo(du, hn::LoadU(hn::Rebind<uint16_t, Du>(), spots));
  const Vu low = hn::Set(du, 3), high = hn::Set(du, 4);
  const Vu ix = hn::Or(hn::And(out.spot, low), hn::And(hn::ShiftRight<4>(out.spot), high));
  const Vu iy =
      hn::Or(hn::And(hn::ShiftRight<2>(out.spot), low), hn::And(hn::ShiftRight<5>(out.spot), high));
  const Vu iz =
      hn::Or(hn::And(hn::ShiftRight<4>(out.spot), low), hn::And(hn::ShiftRight<6>(out.spot), high));
  out.x = hn::ConvertTo(d, hn::BitCast(di, ix));
  out.y = hn::ConvertTo(d, hn::BitCast(di, iy));
  out.z = hn::ConvertTo(d, hn::BitCast(di, iz));
  return out;
}

HWY_INLINE VoxelVector place_voxels(const CellMap& map, const uint16_t* spots, bool perspective) {
  const SpotVector at = load_spots(spots);
  VoxelVector out;
  out.spot = at.spot;
  out.depth = trilinear(map, 2, at.x, at.y, at.z);
  out.x = trilinear(map, 0, at.x, at.y, at.z);
  out.y = trilinear(map, 1, at.x, at.y, at.z);
  if (perspective) {
    const Vf inverse = hn::Div(hn::Set(Df(), 1.0f), out.depth);
    out.x = hn::Mul(out.x, inverse);
    out.y = hn::Mul(out.y, inverse);
  }
  return out;
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();
#endif
