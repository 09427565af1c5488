// Winners of pixels -> what shading needs of them. Neighbouring pixels show voxels of a few cells,
// so what the voxels of a cell share is prepared once and kept in a small table: where its voxels'
// attributes begin, and the trilinear maps of points and normals as polynomials in x, y and z.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/render/voxels/voxel_fetch_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <bit>

#include "sinew/base/check.h"
#include "sinew/render/voxels/voxel_batch.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D4 = hn::CappedTag<float, 4>;
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

// Remembers where the last winners came from.
class Fetch {
 public:
  explicit Fetch(std::span<const VoxelInstance> instances) : instances_(instances) {
    for (uint32_t& unit : units_) unit = kMostUnits;
  }

  void run(std::span<const VisibilityKey> keys, VoxelBatch& out) {
    out.count = static_cast<uint32_t>(keys.size());
    for (uint32_t i = 0; i < out.count; ++i) {
      const uint32_t unit = key_unit(keys[i]);
      find_instance(unit);
      const uint32_t local = unit - instance_->first_unit;
      if (local >= cells_) {
        out.set(i, sample_voxel(instances_, keys[i]));
        continue;
      }
      const uint32_t slot = (unit * 0x9e3779b9u) >> (32 - kCachedBits);
      if (units_[slot] != unit) {
        units_[slot] = unit;
        prepare(local, table_[slot]);
      }
      fetch(table_[slot], key_code(keys[i]), i, out);
    }
    out.pad();
  }

 private:
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
