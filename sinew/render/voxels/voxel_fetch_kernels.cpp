// Winners of pixels -> what shading needs of them. Neighbouring pixels show voxels of a few cells,
// so what the voxels of a cell share is prepared once and kept in a small table: where its voxels'
// attributes begin, and the trilinear maps of points and normals as polynomials in x, y and z.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/render/voxels/voxel_fetch_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/cache_control.h>
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <bit>

#include "sinew/base/check.h"
#include "sinew/render/voxels/voxel_batch.h"
#include "sinew/svo/brick.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::CappedTag<float, 4>;
using D8 = hn::CappedTag<float, 8>;
using D16 = hn::CappedTag<float, 16>;

constexpr uint32_t kCachedBits = 7;
constexpr uint32_t kCached = 1u << kCachedBits;  // cells; more than a batch mostly shows

// A cell that is ready for its voxels. A map is the sum of its coefficients times 1, x, y, xy, z,
// xz, yz, xyz, where x, y and z go from 0 to 1 in the cell.
struct alignas(64) PreparedCell {
  alignas(64) float normal[8][12];  // of the map of normals in the object: columns of 4, 3 used
  float behind_normal[4];           // read with the last row
  alignas(64) float point[8][4];    // of the map of points to the world
  uint64_t masks[8];                // bricks by their place
  uint16_t before[8];               // voxels in the bricks before
  uint32_t first_voxel;             // where they begin
  uint32_t first_brick;             // where its bricks do
  uint32_t index;                   // of the cell
  uint32_t block;
  uint32_t bricks;
  uint32_t material;
  float diagonal;  // of a voxel of level 0, deformed
  bool turns;      // else `normal` is constant
};

HWY_INLINE uint32_t bits_below(uint64_t mask, uint32_t bit) {
  return static_cast<uint32_t>(std::popcount(mask & ((uint64_t{1} << bit) - 1)));
}

// Turns the values at the corners into the coefficients.
template <uint32_t kStride>
HWY_INLINE void make_polynomial(float (&c)[8][kStride], uint32_t used) {
  const D4 d;
  for (uint32_t step = 1; step < 8; step *= 2) {
    for (uint32_t i = 0; i < 8; ++i) {
      if ((i & step) == 0) continue;
      for (uint32_t k = 0; k < used; k += static_cast<uint32_t>(hn::Lanes(d))) {
        hn::Store(hn::Sub(hn::Load(d, c[i] + k), hn::Load(d, c[i ^ step] + k)), d, c[i] + k);
      }
    }
  }
}

// Turns three columns, and perhaps an origin, of three floats each into columns of four.
struct alignas(16) Columns {
  float value[4][4] = {};

  Columns() = default;
  explicit Columns(const mat3& m) {
    for (int c = 0; c < 3; ++c) set(c, m[c]);
  }
  explicit Columns(const Affine& m) {
    for (int c = 0; c < 4; ++c) set(c, m[c]);
  }
  void set(int c, vec3 v) {
    for (int i = 0; i < 3; ++i) value[c][i] = v[i];
  }
};

// The sum of the unit normals of up to eight voxels; `packed` is filled up with anything.
HWY_INLINE vec3 sum_of_normals(const uint16_t* packed, uint32_t count) {
  const D8 d;
  const hn::RebindToSigned<D8> di;
  const hn::Rebind<uint16_t, D8> d16;
  const auto zero = hn::Zero(d), middle = hn::Set(d, 127.0f);
  auto sum_x = zero, sum_y = zero, sum_z = zero;
  for (uint32_t i = 0; i < count; i += static_cast<uint32_t>(hn::Lanes(d))) {
    const auto both = hn::PromoteTo(di, hn::Load(d16, packed + i));
    const auto x = hn::Sub(hn::ConvertTo(d, hn::And(both, hn::Set(di, 255))), middle);
    const auto y = hn::Sub(hn::ConvertTo(d, hn::ShiftRight<8>(both)), middle);
    // As unit_normal().
    const auto z = hn::Sub(hn::Sub(middle, hn::Abs(x)), hn::Abs(y));
    const auto fold = hn::Max(hn::Neg(z), zero);
    const auto nx = hn::Sub(x, hn::CopySign(fold, x)), ny = hn::Sub(y, hn::CopySign(fold, y));
    const auto length2 = hn::MulAdd(nx, nx, hn::MulAdd(ny, ny, hn::Mul(z, z)));
    const auto scale =
        hn::IfThenElseZero(hn::FirstN(d, count - i), hn::Div(hn::Set(d, 1.0f), hn::Sqrt(length2)));
    sum_x = hn::MulAdd(nx, scale, sum_x);
    sum_y = hn::MulAdd(ny, scale, sum_y);
    sum_z = hn::MulAdd(z, scale, sum_z);
  }
  const auto all = [&](auto v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
  return vec3(all(sum_x), all(sum_y), all(sum_z));
}

// Remembers where the last winners came from.
class Fetch {
 public:
  explicit Fetch(std::span<const VoxelInstance> instances) : instances_(instances) {
    for (uint32_t& unit : units_) unit = kMostUnits;
  }

  // Memory is asked for before it is read: of cells, then of what moves them, then of voxels.
  void run(std::span<const VisibilityKey> keys, VoxelBatch& out) {
    constexpr uint32_t kAhead = 16;
    SINEW_CHECK(keys.size() <= kMostWinners);
    out.count = static_cast<uint32_t>(keys.size());
    find_cells(keys);
    for (uint32_t i = 0; i < std::min(out.count, kAhead); ++i) prefetch_voxel(keys[i]);
    for (uint32_t i = 0; i < out.count; ++i) {
      if (i + kAhead < out.count) prefetch_voxel(keys[i + kAhead]);
      const uint32_t unit = key_unit(keys[i]);
      find_instance(unit);
      const uint32_t local = unit - instance_->first_unit;
      if (local >= cells_) {
        out.set(i, sample_voxel(instances_, keys[i]));
        continue;
      }
      const uint32_t slot = slot_of(unit);
      if (HWY_UNLIKELY(units_[slot] != unit)) {
        units_[slot] = unit;
        prepare(local, table_[slot]);
      }
      fetch(table_[slot], key_code(keys[i]), i, out);
    }
    out.pad();
  }

 private:
  static HWY_INLINE uint32_t slot_of(uint32_t unit) {
    return (unit * 0x9e3779b9u) >> (32 - kCachedBits);
  }

  // Prepares the keys' cells, as far as they do not get into each other's way.
  void find_cells(std::span<const VisibilityKey> keys) {
    uint32_t fresh[kMostWinners], count = 0;
    for (const VisibilityKey key : keys) {
      const uint32_t unit = key_unit(key), slot = slot_of(unit);
      if (units_[slot] == unit) continue;
      find_instance(unit);
      if (unit - first_unit_ >= cells_) continue;
      units_[slot] = unit;
      fresh[count++] = unit;
      hwy::Prefetch(&svo_->cells[unit - first_unit_]);
    }
    for (uint32_t i = 0; i < count; ++i) {
      find_instance(fresh[i]);
      prefetch_cell(fresh[i] - first_unit_);
    }
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t slot = slot_of(fresh[i]);
      if (units_[slot] != fresh[i]) continue;  // another's by now
      find_instance(fresh[i]);
      prepare(fresh[i] - first_unit_, table_[slot]);
    }
  }

  HWY_INLINE void prefetch_cell(uint32_t index) {
    find_block(index);
    const SvoCell& cell = svo_->cells[index];
    hwy::Prefetch(svo_->bricks.data() + svo_->blocks[block_].first_brick + cell.first_brick);
    for (const uint16_t corner : cell.corner) {
      hwy::Prefetch(&posed_.positions[corner]);
      if (!posed_.cofactors.empty()) hwy::Prefetch(&posed_.cofactors[corner]);
    }
  }

  // Of level 0 and 1: near enough to its attributes.
  HWY_INLINE void prefetch_voxel(VisibilityKey key) {
    const uint32_t unit = key_unit(key), slot = slot_of(unit), code = key_code(key);
    if (units_[slot] != unit || code >= kFirstCode[2]) return;
    find_instance(unit);
    const PreparedCell& cell = table_[slot];
    const bool fine = code < kFirstCode[1];
    const uint32_t brick = fine ? code >> 6 : brick_above(code - kFirstCode[1]);
    const uint32_t bit = fine ? code & 63 : first_below(code - kFirstCode[1]);
    const uint32_t voxel =
        cell.first_voxel + cell.before[brick] + bits_below(cell.masks[brick], bit);
    hwy::Prefetch(svo_->normals.data() + voxel);
    if (svo_->colors.empty()) {
      hwy::Prefetch(svo_->color_selectors.data() + (voxel >> 4));
      hwy::Prefetch(svo_->color_ends.data() + cell.first_brick + bits_below(cell.bricks, brick));
    } else {
      hwy::Prefetch(svo_->colors.data() + voxel);
    }
  }

  HWY_INLINE void find_instance(uint32_t unit) {
    if (unit - first_unit_ < units_of_) return;
    const auto after = std::upper_bound(
        instances_.begin(), instances_.end(), unit,
        [](uint32_t u, const VoxelInstance& instance) { return u < instance.first_unit; });
    instance_ = &*(after - 1);
    svo_ = &instance_->posed->svo();
    first_unit_ = instance_->first_unit;
    units_of_ = unit_count(*svo_);
    cells_ = static_cast<uint32_t>(svo_->cells.size());
    block_first_ = block_end_ = 0;
    placement_ = Columns(instance_->placement);
    normal_map_ = Columns(cofactor(instance_->placement));
    placed_ = instance_->placement != identity_affine();
  }

  HWY_INLINE void find_block(uint32_t cell) {
    if (cell >= block_first_ && cell < block_end_) return;
    const auto after =
        std::upper_bound(svo_->blocks.begin(), svo_->blocks.end(), cell,
                         [](uint32_t c, const SvoBlock& block) { return c < block.first_cell; });
    const auto block = after - 1;
    block_ = static_cast<uint32_t>(block - svo_->blocks.begin());
    block_first_ = block->first_cell;
    block_end_ = after->first_cell;
    posed_ = instance_->posed->block(block_);
  }

  void prepare(uint32_t index, PreparedCell& out) {
    find_block(index);
    const SvoCell& cell = svo_->cells[index];
    const SvoBlock& block = svo_->blocks[block_];
    out.bricks = cell.bricks;
    out.material = cell.material;
    out.first_voxel = block.first_voxel + cell.first_voxel;
    out.first_brick = block.first_brick + cell.first_brick;
    out.index = index;
    out.block = block_;
    const uint64_t* mask = svo_->bricks.data() + out.first_brick;
    uint32_t before = 0;
    for (uint32_t i = 0; i < 8; ++i) {
      out.before[i] = static_cast<uint16_t>(before);
      out.masks[i] = (cell.bricks >> i & 1) != 0 ? *mask++ : 0;
      before += static_cast<uint32_t>(std::popcount(out.masks[i]));
    }
    prepare_maps(cell, out);
  }

  void prepare_maps(const SvoCell& cell, PreparedCell& out) {
    const D4 d;
    for (uint32_t i = 0; i < 8; ++i) {
      const vec3 p = posed_.positions[cell.corner[i]];
      hn::Store(apply(placement_, p.x, p.y, p.z, hn::Load(d, placement_.value[3])), d,
                out.point[i]);
    }
    float longest2 = 0.0f;
    for (uint32_t i = 0; i < 4; ++i) {
      const float *const a = out.point[i], *const b = out.point[7 - i];
      const vec3 diagonal(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      longest2 = std::max(longest2, dot(diagonal, diagonal));
    }
    out.diagonal = std::sqrt(longest2) / static_cast<float>(kCellSide);
    make_polynomial(out.point, 4);
    out.turns = !posed_.cofactors.empty();
    if (!out.turns) return;
    for (uint32_t i = 0; i < 8; ++i) {
      const float* const from = &posed_.cofactors[cell.corner[i]][0][0];
      hn::Store(hn::LoadU(d, from), d, out.normal[i]);
      hn::Store(hn::LoadU(d, from + 3), d, out.normal[i] + 4);
      // Not a float beyond the last matrix is read.
      hn::Store(hn::ShiftRightLanes<1>(d, hn::LoadU(d, from + 5)), d, out.normal[i] + 8);
    }
    make_polynomial(out.normal, 12);
  }

  // columns * (x, y, z) + origin
  static HWY_INLINE hn::Vec<D4> apply(const Columns& columns, float x, float y, float z,
                                      hn::Vec<D4> origin) {
    const D4 d;
    auto sum = hn::MulAdd(hn::Set(d, x), hn::Load(d, columns.value[0]), origin);
    sum = hn::MulAdd(hn::Set(d, y), hn::Load(d, columns.value[1]), sum);
    return hn::MulAdd(hn::Set(d, z), hn::Load(d, columns.value[2]), sum);
  }

  HWY_INLINE void fetch(const PreparedCell& cell, VoxelCode code, uint32_t i, VoxelBatch& out) {
    vec3 direction, color;
    out.normal[i][3] = 1.0f;
    const uint32_t brick = code >> 6;
    if (HWY_LIKELY(code < kFirstCode[1])) {
      const uint32_t rank = bits_below(cell.masks[brick], code & 63);
      const VoxelIndex at{cell.first_voxel + cell.before[brick] + rank,
                          cell.first_brick + bits_below(cell.bricks, brick)};
      direction = unpack_direction(svo_->normals[at.voxel]);
      color = voxel_color(*svo_, at);
    } else if (code < kFirstCode[2]) {
      out.normal[i][3] = fetch_coarse(cell, code - kFirstCode[1], direction, color);
    } else {
      const VoxelAttributes a =
          voxel_attributes(*svo_, svo_->blocks[cell.block], svo_->cells[cell.index], code);
      direction = a.normal;
      color = a.color;
      out.normal[i][3] = a.spread;
    }
    const float spread = out.normal[i][3];
    out.material[i] = cell.material;
    for (int c = 0; c < 3; ++c) out.color[i][c] = color[c];
    out.color[i][3] = 0.0f;
    const VoxelPlace place = place_of(code);
    const float side = static_cast<float>(place.side);
    const vec3 at = (vec3(place.min) + 0.5f * side) * (1.0f / static_cast<float>(kCellSide));
    map(cell, at, direction, i, out);
    out.place[i][3] = cell.diagonal * side;
    out.normal[i][3] = spread;
  }

  // Means over the voxels of one of level 1, as voxel_attributes(); returns the spread.
  HWY_INLINE float fetch_coarse(const PreparedCell& cell, uint32_t bit, vec3& direction,
                                vec3& color) {
    const uint32_t brick = brick_above(bit), first = cell.first_voxel + cell.before[brick];
    const uint64_t mask = cell.masks[brick];
    const VoxelIndex at{0, cell.first_brick + bits_below(cell.bricks, brick)};
    alignas(16) uint16_t normals[8] = {};
    uint32_t count = 0, selectors = 0, squares = 0;
    vec3 colors(0.0f);
    for (uint64_t rest = mask & kEight << first_below(bit); rest != 0; rest &= rest - 1) {
      const uint32_t voxel =
          first + bits_below(mask, static_cast<uint32_t>(std::countr_zero(rest)));
      normals[count++] = svo_->normals[voxel];
      if (HWY_LIKELY(svo_->colors.empty())) {
        const uint32_t selector = svo_->color_selectors[voxel >> 4] >> (2 * (voxel & 15)) & 3;
        selectors += selector;
        squares += selector * selector;
      } else {
        colors += voxel_color(*svo_, {voxel, at.brick});
      }
    }
    const float share = 1.0f / static_cast<float>(count);
    if (HWY_LIKELY(svo_->colors.empty())) {
      // The mean of (a + s / 3 (b - a))^2 over the voxels' selectors s.
      const SvoColorEnds ends = svo_->color_ends[at.brick];
      const vec3 a = color_root(ends.a), b = color_root(ends.b) - a;
      const float s = static_cast<float>(selectors) * share * (1.0f / 3.0f);
      const float s2 = static_cast<float>(squares) * share * (1.0f / 9.0f);
      color = a * a + (2.0f * s) * a * b + s2 * b * b;
    } else {
      color = colors * share;
    }
    direction = sum_of_normals(normals, count);
    const float size = std::sqrt(dot(direction, direction));
    if (!(size > 0.0f)) direction = vec3(0.0f, 0.0f, 1.0f);
    return mean_length(size, static_cast<float>(count));
  }

  // Moves the voxel's middle and its normal to the world.
  HWY_INLINE void map(const PreparedCell& cell, vec3 at, vec3 direction, uint32_t i,
                      VoxelBatch& out) {
    const D4 d4;
    const D16 d16;
    const float factor[8] = {1.0f, at.x,        at.y,        at.x * at.y,
                             at.z, at.x * at.z, at.y * at.z, at.x * at.y * at.z};
    auto point = hn::Load(d4, cell.point[0]);
    for (uint32_t k = 1; k < 8; ++k) {
      point = hn::MulAdd(hn::Set(d4, factor[k]), hn::Load(d4, cell.point[k]), point);
    }
    hn::Store(point, d4, out.place[i]);
    if (cell.turns) {
      alignas(64) Columns columns;
      for (uint32_t lane = 0; lane < 12; lane += static_cast<uint32_t>(hn::Lanes(d16))) {
        auto sum = hn::LoadU(d16, cell.normal[0] + lane);
        for (uint32_t k = 1; k < 8; ++k) {
          sum = hn::MulAdd(hn::Set(d16, factor[k]), hn::LoadU(d16, cell.normal[k] + lane), sum);
        }
        hn::StoreU(sum, d16, columns.value[0] + lane);
      }
      const auto turned = apply(columns, direction.x, direction.y, direction.z, hn::Zero(d4));
      hn::Store(turned, d4, out.normal[i]);
      direction = vec3(out.normal[i][0], out.normal[i][1], out.normal[i][2]);
    }
    if (placed_ || !cell.turns) {
      const auto placed = apply(normal_map_, direction.x, direction.y, direction.z, hn::Zero(d4));
      hn::Store(placed, d4, out.normal[i]);
    }
  }

  // As unpack_normal(), but not of unit length.
  static HWY_INLINE vec3 unpack_direction(uint16_t packed) {
    const float x = static_cast<float>(packed & 255) / 127.0f - 1.0f;
    const float y = static_cast<float>(packed >> 8) / 127.0f - 1.0f;
    const float z = 1.0f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.0f);
    return vec3(x - std::copysign(fold, x), y - std::copysign(fold, y), z);
  }

  std::span<const VoxelInstance> instances_;
  const VoxelInstance* instance_ = nullptr;
  const Svo* svo_ = nullptr;
  uint32_t first_unit_ = 0, units_of_ = 0, cells_ = 0;
  uint32_t block_ = 0, block_first_ = 0, block_end_ = 0;
  PosedBlock posed_;
  Columns placement_, normal_map_;
  bool placed_ = false;  // else both are identities
  uint32_t units_[kCached];
  PreparedCell table_[kCached];
};

void fetch_kernel(std::span<const VoxelInstance> instances, std::span<const VisibilityKey> keys,
                  VoxelBatch& out) {
  Fetch(instances).run(keys, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(fetch_kernel);

void fetch_voxels(std::span<const VoxelInstance> instances, std::span<const VisibilityKey> keys,
                  VoxelBatch& out) {
  SINEW_CHECK(keys.size() <= kMostWinners);
  if (keys.empty()) {
    out.count = 0;
    return;
  }
  HWY_DYNAMIC_DISPATCH(fetch_kernel)(instances, keys, out);
}

}  // namespace sinew
#endif
