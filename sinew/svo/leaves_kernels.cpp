// Boxes of voxels, a slice of a brick at a time: sixteen voxels that have z in common. In a plane
// of constant z the cell's map is a + b x + c y + d x y; a voxel has four corners in each of its
// two planes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/svo/leaves_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <cmath>

#include "sinew/svo/leaves.h"
#include "sinew/svo/leaves_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::FixedTag<float, 4>;
using D16 = hn::CappedTag<float, 16>;
using D16u = hn::CappedTag<uint32_t, 16>;
using V16 = hn::Vec<D16>;

constexpr uint32_t kMostVoxels = 512;
constexpr uint32_t kRoom = kMostVoxels + 16;  // whole vectors are stored
constexpr float kSide = static_cast<float>(kCellSide);

// Boxes as they are found, without holes.
struct BoxRows {
  uint32_t count = 0;
  alignas(64) float row[6][kRoom];  // as those of a node
  alignas(64) uint32_t primitive[kRoom];
};

// a, b, c, d of a plane; rows of x, y, z.
struct alignas(16) PlaneMap {
  float of[4][4];
};

HWY_INLINE void map_plane(const CellCorners& corners, float z, PlaneMap& out) {
  const D4 d;
  const auto share = hn::Set(d, z * (1.0f / kSide));
  const auto at = [&](int i) {
    const auto low = hn::Load(d, corners.at[i]), high = hn::Load(d, corners.at[i + 4]);
    return hn::MulAdd(share, hn::Sub(high, low), low);
  };
  const auto p = at(0), px = at(1), py = at(2), pxy = at(3);
  const auto once = hn::Set(d, 1.0f / kSide), twice = hn::Set(d, 1.0f / (kSide * kSide));
  hn::Store(p, d, out.of[0]);
  hn::Store(hn::Mul(hn::Sub(px, p), once), d, out.of[1]);
  hn::Store(hn::Mul(hn::Sub(py, p), once), d, out.of[2]);
  hn::Store(hn::Mul(hn::Sub(hn::Sub(pxy, px), hn::Sub(py, p)), twice), d, out.of[3]);
}

// Where voxels begin and end along x and y, in voxels of the cell.
struct Spans {
  V16 x0, x1, y0, y1;
};

HWY_INLINE void extend(const PlaneMap& map, uint32_t axis, const Spans& s, V16& low, V16& high) {
  const D16 d;
  const V16 a = hn::Set(d, map.of[0][axis]), b = hn::Set(d, map.of[1][axis]);
  const V16 c = hn::Set(d, map.of[2][axis]), e = hn::Set(d, map.of[3][axis]);
  const V16 r0 = hn::MulAdd(s.y0, c, a), r1 = hn::MulAdd(s.y1, c, a);
  const V16 s0 = hn::MulAdd(s.y0, e, b), s1 = hn::MulAdd(s.y1, e, b);
  const V16 p00 = hn::MulAdd(s.x0, s0, r0), p10 = hn::MulAdd(s.x1, s0, r0);
  const V16 p01 = hn::MulAdd(s.x0, s1, r1), p11 = hn::MulAdd(s.x1, s1, r1);
  low = hn::Min(low, hn::Min(hn::Min(p00, p10), hn::Min(p01, p11)));
  high = hn::Max(high, hn::Max(hn::Max(p00, p10), hn::Max(p01, p11)));
}

// 4^3 voxels, some of which are there: bit x + 4 y + 16 z.
struct VoxelCube {
  uint64_t mask;
  uint32_t x, y, z;  // where it begins, in its voxels
};

// What depends on the level: the voxels' side, and how their codes are numbered.
struct Grid {
  float side, pad;
  uint32_t y_step, z_step;
};

template <class M>
HWY_INLINE void append(const CellCorners& corners, float pad_factor, const V16* low,
                       const V16* high, hn::Vec<D16u> primitive, M kept, uint32_t count,
                       BoxRows& out) {
  const D16 d;
  const D16u du;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const V16 pad = hn::Set(d, pad_factor * corners.pad[axis]);
    const V16 base = hn::Set(d, corners.base[axis]);
    const V16 from = hn::Add(base, hn::Sub(low[axis], pad));
    const V16 to = hn::Add(base, hn::Add(high[axis], pad));
    hn::StoreU(hn::Compress(from, kept), d, out.row[axis] + out.count);
    hn::StoreU(hn::Compress(to, kept), d, out.row[axis + 3] + out.count);
  }
  hn::StoreU(hn::Compress(primitive, hn::RebindMask(du, kept)), du, out.primitive + out.count);
  out.count += count;
}

HWY_INLINE void box_cube(const CellCorners& corners, const PlaneMap* planes, const Grid& grid,
                         const VoxelCube& cube, uint32_t first_primitive, BoxRows& out) {
  const D16 d;
  const D16u du;
  const hn::RebindToSigned<D16> di;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(d));
  const V16 side = hn::Set(d, grid.side), margin = hn::Set(d, kRayMargin);
  for (uint32_t i = 0; i < 16; i += lanes) {
    const auto spot = hn::Iota(du, i);
    const auto x = hn::And(spot, hn::Set(du, 3u)), y = hn::ShiftRight<2>(spot);
    const auto begin = [&](auto local, uint32_t from) {
      const auto at = hn::BitCast(di, hn::Add(local, hn::Set(du, from)));
      return hn::Mul(hn::ConvertTo(d, at), side);
    };
    Spans spans;
    const V16 x0 = begin(x, cube.x), y0 = begin(y, cube.y);
    spans.x0 = hn::Sub(x0, margin);
    spans.x1 = hn::Add(hn::Add(x0, side), margin);
    spans.y0 = hn::Sub(y0, margin);
    spans.y1 = hn::Add(hn::Add(y0, side), margin);
    const auto code = hn::Add(x, hn::Mul(y, hn::Set(du, grid.y_step)));
    for (uint32_t z = 0; z < 4; ++z) {
      const auto bits = static_cast<uint32_t>(cube.mask >> (16 * z + i)) & ((1u << lanes) - 1u);
      if (bits == 0) continue;
      V16 low[3], high[3];
      for (uint32_t axis = 0; axis < 3; ++axis) {
        low[axis] = hn::Set(d, __builtin_inff());
        high[axis] = hn::Set(d, -__builtin_inff());
        for (uint32_t end = 0; end < 2; ++end) {
          extend(planes[2 * (cube.z + z) + end], axis, spans, low[axis], high[axis]);
        }
      }
      uint8_t bytes[8] = {static_cast<uint8_t>(bits), static_cast<uint8_t>(bits >> 8)};
      append(corners, grid.pad, low, high,
             hn::Add(code, hn::Set(du, first_primitive + z * grid.z_step)),
             hn::LoadMaskBits(d, bytes), static_cast<uint32_t>(__builtin_popcount(bits)), out);
    }
  }
}

// Cuts the rows into packets.
HWY_INLINE void write_packets(BoxRows& rows, Node8* out) {
  const hn::CappedTag<float, 8> d;
  const hn::CappedTag<uint32_t, 8> du;
  const uint32_t full = (rows.count + kWidth - 1) / kWidth * kWidth;
  for (uint32_t i = rows.count; i < full; ++i) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      rows.row[axis][i] = __builtin_inff();
      rows.row[axis + 3][i] = -__builtin_inff();
    }
    rows.primitive[i] = kNoChild;
  }
  for (uint32_t i = 0; i < full; i += kWidth, ++out) {
    for (uint32_t k = 0; k < kWidth; k += static_cast<uint32_t>(hn::Lanes(d))) {
      for (uint32_t axis = 0; axis < 3; ++axis) {
        hn::Store(hn::Load(d, rows.row[axis] + i + k), d, out->low[axis] + k);
        hn::Store(hn::Load(d, rows.row[axis + 3] + i + k), d, out->high[axis] + k);
      }
      hn::Store(hn::Load(du, rows.primitive + i + k), du, out->child + k);
    }
  }
}

// The cell's voxels of a level, as cubes of 4^3.
HWY_INLINE uint32_t cubes_of(const SvoCell& cell, const uint64_t* bricks, uint32_t level,
                             VoxelCube cubes[8]) {
  if (level == 1) {
    cubes[0] = {coarse_voxels(cell, bricks), 0, 0, 0};
    return 1;
  }
  uint32_t count = 0;
  uint64_t mask = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    if (!(cell.bricks >> i & 1)) continue;
    const uint32_t x = i & 1, y = i >> 1 & 1, z = i >> 2;
    mask |= uint64_t{1} << (x + 4 * y + 16 * z);
    if (level == 0) cubes[count] = {bricks[count], 4 * x, 4 * y, 4 * z};
    ++count;
  }
  if (level == 0) return count;
  cubes[0] = {mask, 0, 0, 0};
  return 1;
}

uint32_t box_voxels_kernel(const CellCorners& corners, const SvoCell& cell, const uint64_t* bricks,
                           uint32_t level, uint32_t first_primitive, Node8* packets) {
  const auto side = static_cast<float>(1u << level);
  const Grid grid{side, static_cast<float>(1 + level), level == 2 ? 2u : 4u, level == 2 ? 4u : 16u};
  VoxelCube cubes[8];
  const uint32_t count = cubes_of(cell, bricks, level, cubes);
  PlaneMap planes[2 * kCellSide];
  for (uint32_t z = 0; z < kCellSide >> level; ++z) {
    const float at = side * static_cast<float>(z);
    map_plane(corners, at - kRayMargin, planes[2 * z]);
    map_plane(corners, at + side + kRayMargin, planes[2 * z + 1]);
  }
  BoxRows rows;
  for (uint32_t i = 0; i < count; ++i) {
    // Of level 0 a brick's first code depends on where it is.
    const uint32_t brick = cubes[i].x / 4 + cubes[i].y / 2 + cubes[i].z;
    const uint32_t code = level == 0 ? 64 * brick : kFirstCode[level];
    box_cube(corners, planes, grid, cubes[i], first_primitive + code, rows);
  }
  write_packets(rows, packets);
  return rows.count;
}

CellCorners cell_corners_kernel(const SvoCell& cell, const vec3* positions) {
  const D4 d;
  const auto point = [&](uint32_t i) {
    const vec3& p = positions[cell.corner[i]];
    alignas(16) const float row[4] = {p.x, p.y, p.z, 0.0f};
    return hn::Load(d, row);
  };
  CellCorners out;
  const auto base = point(0);
  auto most = hn::Abs(base), reach = hn::Zero(d);
  hn::Store(base, d, out.base);
  for (uint32_t i = 0; i < 8; ++i) {
    const auto p = point(i), relative = hn::Sub(p, base);
    hn::Store(relative, d, out.at[i]);
    most = hn::Max(most, hn::Abs(p));
    reach = hn::Max(reach, hn::Abs(relative));
  }
  // A point's image, relative to the base, is some 70 roundings of terms of the cell's size; then
  // the base is added.
  hn::Store(hn::MulAdd(most, hn::Set(d, 0x1p-22f), hn::Mul(reach, hn::Set(d, 0x1p-17f))), d,
            out.pad);
  return out;
}

CellBox cell_box_kernel(const CellCorners& corners) {
  const D4 d;
  hn::Vec<D4> p[8];
  for (uint32_t i = 0; i < 8; ++i) p[i] = hn::Load(d, corners.at[i]);
  const auto margin = hn::Set(d, kRayMargin / kSide);
  float longest = 0.0f;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    for (uint32_t i = 0; i < 8; ++i) {
      const uint32_t j = i | 1u << axis;
      if (i == j) continue;
      const auto edge = hn::Sub(p[j], p[i]);
      longest = std::max(longest, hn::GetLane(hn::SumOfLanes(d, hn::Mul(edge, edge))));
      p[i] = hn::NegMulAdd(margin, edge, p[i]);
      p[j] = hn::MulAdd(margin, edge, p[j]);
    }
  }
  auto low = p[0], high = p[0];
  for (uint32_t i = 1; i < 8; ++i) {
    low = hn::Min(low, p[i]);
    high = hn::Max(high, p[i]);
  }
  const auto base = hn::Load(d, corners.base);
  const auto pad =
      hn::Mul(hn::Set(d, static_cast<float>(1 + kCellLevel)), hn::Load(d, corners.pad));
  alignas(16) float from[4], to[4];
  hn::Store(hn::Add(base, hn::Sub(low, pad)), d, from);
  hn::Store(hn::Add(base, hn::Add(high, pad)), d, to);
  CellBox out;
  out.box = {vec3(from[0], from[1], from[2]), vec3(to[0], to[1], to[2])};
  out.longest = std::sqrt(longest);
  return out;
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(box_voxels_kernel);
HWY_EXPORT(cell_corners_kernel);
HWY_EXPORT(cell_box_kernel);

uint32_t box_voxels(const CellCorners& corners, const SvoCell& cell, const uint64_t* bricks,
                    uint32_t level, uint32_t first_primitive, Node8* packets) {
  return HWY_DYNAMIC_DISPATCH(box_voxels_kernel)(corners, cell, bricks, level, first_primitive,
                                                 packets);
}

CellCorners cell_corners(const SvoCell& cell, const vec3* positions) {
  return HWY_DYNAMIC_DISPATCH(cell_corners_kernel)(cell, positions);
}

CellBox cell_box(const CellCorners& corners) {
  return HWY_DYNAMIC_DISPATCH(cell_box_kernel)(corners);
}

}  // namespace sinew
#endif
