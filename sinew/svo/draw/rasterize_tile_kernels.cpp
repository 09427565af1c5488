// A tile: hierarchical z in two phases, and the way of drawing each cell.
// Two phases after: N. Greene, M. Kass, G. Miller, "Hierarchical Z-Buffer Visibility", 1993,
// section 4 (temporal coherence). Hidden is only what lies behind all pixels that it might cover,
// so it changes no pixel, and the picture does not depend on what was seen before.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/svo/draw/rasterize_tile_kernels.cpp"
#define HWY_WANT_AVX3_DL  // for its compress of 16-bit values
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/cache_control.h>
#include <hwy/highway.h>
// clang-format on

#include <atomic>

#include "sinew/svo/draw/rasterize_dense-inl.h"
#include "sinew/svo/draw/rasterize_faces-inl.h"
#include "sinew/svo/draw/rasterize_kernels.h"
#include "sinew/svo/draw/rasterize_sides-inl.h"
#include "sinew/svo/thesis/thesis_place-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

// The farthest depth in squares of the tile.
struct FarDepths {
  static constexpr int kSquare = 8, kSide = static_cast<int>(kTileSide) / kSquare;
  float far[kSide][kSide];
};

HWY_INLINE void update(const TilePlanes& planes, FarDepths& out) {
  const Df d;
  for (int row = 0; row < FarDepths::kSide; ++row) {
    for (int x = 0; x < static_cast<int>(kTileSide); x += static_cast<int>(lanes())) {
      Vf most = hn::Zero(d);
      for (int y = 0; y < FarDepths::kSquare; ++y) {
        const int at = (row * FarDepths::kSquare + y) * static_cast<int>(kTileSide) + x;
        most = hn::Max(most, hn::LoadU(d, planes.depth + at));
      }
      alignas(64) float values[16];
      hn::Store(most, d, values);
      for (int i = 0; i < static_cast<int>(lanes()); ++i) {
        float& square = out.far[row][(x + i) / FarDepths::kSquare];
        const bool first = (x + i) % FarDepths::kSquare == 0;
        square = first ? values[i] : std::max(square, values[i]);
      }
    }
  }
}

HWY_INLINE bool is_hidden(const TileJob& job, const RasterCell& cell, const FarDepths& depths) {
  const TileBox box = clip_to_tile(job, cell.x0, cell.y0, cell.x1, cell.y1);
  for (int y = box.y0 / FarDepths::kSquare; y <= box.y1 / FarDepths::kSquare; ++y) {
    for (int x = box.x0 / FarDepths::kSquare; x <= box.x1 / FarDepths::kSquare; ++x) {
      if (!(cell.near_depth > depths.far[y][x])) return false;
    }
  }
  return true;
}

HWY_INLINE bool was_seen(const uint64_t* seen, uint32_t unit) {
  return (seen[unit >> 6] >> (unit & 63) & 1) != 0;
}

// Different tiles see the same cells.
HWY_INLINE void set_seen(uint64_t* seen, uint32_t unit) {
  std::atomic_ref<uint64_t> word(seen[unit >> 6]);
  const uint64_t bit = uint64_t{1} << (unit & 63);
  if ((word.load(std::memory_order_relaxed) & bit) == 0) {
    word.fetch_or(bit, std::memory_order_relaxed);
  }
}

// Different tiles draw the same block.
HWY_INLINE void set_touched(uint8_t& touched) {
  std::atomic_ref<uint8_t> flag(touched);
  if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
}

struct TileBuffers {
  TilePlanes planes;
  DensePlanes dense;
  Spots spots;
  FarDepths far;
};

// Voxels of a cell that crosses the near plane.
template <bool kKeys>
HWY_NOINLINE void draw_near(const TileJob& job, const RasterCell& cell, const RasterBlock& block,
                            uint32_t id, const Spots& spots, TilePlanes& planes) {
  const SvoCell& lattice = block.svo->cells[cell.cell];
  for (uint32_t i = 0; i < spots.count; ++i) {
    const VoxelCode code = code_of_spot(spots.spot[i], cell.level);
    ClipPoint corners[8];
    voxel_corners(job.points + block.first_corner, lattice, code, corners);
    const ScreenBox box = project_hull(corners, job.near, job.perspective, block.reach);
    if (!box.seen()) continue;
    const PixelRange x = pixel_range(box.x0, box.x1), y = pixel_range(box.y0, box.y1);
    if (x.empty() || y.empty()) continue;
    const TileBox pixels = clip_to_tile(job, x.first, y.first, x.last, y.last);
    if (pixels.empty()) continue;
    if (std::max(box.x1 - box.x0, box.y1 - box.y0) > job.settings->large) {
      draw_faces<kKeys>(job, cell, corners, block.reach, id | code, planes);
      continue;
    }
    float middle = 0.0f;
    for (const ClipPoint& corner : corners) middle += 0.125f * corner.depth;
    put_box<kKeys>(planes, pixels,
                   std::clamp(middle, std::max(box.near_depth, cell.near_depth), box.far_depth),
                   id | code);
  }
}

// The listed voxels of a cell, placed by any map.
template <bool kKeys, class Map>
HWY_INLINE void draw_voxels(const TileJob& job, const RasterCell& cell, const Map& map, uint32_t id,
                            TileBuffers& buffers) {
  DenseShape shape;
  if (cell.level < 2 && is_dense(cell, shape)) {
    draw_dense<kKeys>(job, cell, shape, map, buffers.spots, id, buffers.dense, buffers.planes);
  } else {
    draw_boxes<kKeys>(job, cell, map, buffers.spots, id, buffers.planes);
  }
}

// The same for the opponent that skins every voxel.
template <bool kKeys>
HWY_NOINLINE void draw_skinned(const TileJob& job, const RasterCell& cell, uint32_t id,
                               float offset_x, float offset_y, TileBuffers& buffers) {
  const RasterBlock& block = job.blocks[cell.block];
  const SkinnedTable& table = *job.skinned;
  const SvoBlock& place = block.svo->blocks[block.block];
  const SvoCell& lattice = block.svo->cells[cell.cell];
  const uint32_t first = table.voxels->first[cell.cell][cell.level];
  const SkinnedLevel& level = table.voxels->levels[cell.level];
  const uint32_t joints = table.voxels->palette_sizes[cell.cell];
  if (table.lookup == SkinnedLookup::palette && joints != 0 && joints <= lanes()) {
    PaletteMap map;
    set_cell(table, place, lattice, first, cell.level, buffers.spots, offset_x, offset_y, map);
    map.joints = level.palette_slots.data() + first;
    set_palette(table, cell.cell, map);
    return draw_voxels<kKeys>(job, cell, map, id, buffers);
  }
  GatherMap map;
  set_cell(table, place, lattice, first, cell.level, buffers.spots, offset_x, offset_y, map);
  map.joints = level.joints.data() + first;
  map.rows = table.rows.data();
  draw_voxels<kKeys>(job, cell, map, id, buffers);
}

// A cell of large voxels, or one that crosses the near plane: of its voxels only those that may
// meet the tile are looked at. Returns how many.
template <bool kKeys>
HWY_NOINLINE uint32_t draw_wide(const TileJob& job, const RasterCell& cell, uint32_t id,
                                TileBuffers& buffers) {
  const RasterBlock& block = job.blocks[cell.block];
  const SvoCell& lattice = block.svo->cells[cell.cell];
  const CellSides sides = sides_of(job, block, lattice);
  if (misses_tile(sides)) return 0;
  Spots& spots = buffers.spots;
  list_spots(*block.svo, block.svo->blocks[block.block], lattice, cell.level, spots);
  keep_in_tile(sides, cell.level, spots);
  if (cell.path == RasterPath::near) {
    draw_near<kKeys>(job, cell, block, id, spots, buffers.planes);
  } else {
    draw_large<kKeys>(job, cell, block, spots, id, buffers.planes);
  }
  return spots.count;
}

template <bool kKeys>
HWY_INLINE void draw_cell(const TileJob& job, uint32_t place, TileBuffers& buffers,
                          TileCounts& counts) {
  const RasterCell& cell = job.cells[job.list[place]];
  const uint32_t id = (place + 1) << 10;
  if (cell.path == RasterPath::rectangle) {
    const TileBox box = clip_to_tile(job, cell.x0, cell.y0, cell.x1, cell.y1);
    const uint32_t code = cell.block == kNoBlock ? 0 : kFirstCode[cell.level];
    put_box<kKeys>(buffers.planes, box, cell.far_depth, id | code);
    counts.voxels += 1;
    counts.nodes += cell.block == kNoBlock ? 1 : 0;
    return;
  }
  if (cell.path == RasterPath::near || is_large(*job.settings, cell)) {
    const uint32_t drawn = draw_wide<kKeys>(job, cell, id, buffers);
    counts.voxels += drawn;
    counts.leaves += cell.level == 0 ? drawn : 0;
    return;
  }
  const RasterBlock& block = job.blocks[cell.block];
  const SvoCell& lattice = block.svo->cells[cell.cell];
  Spots& spots = buffers.spots;
  list_spots(*block.svo, block.svo->blocks[block.block], lattice, cell.level, spots);
  counts.voxels += spots.count;
  counts.leaves += cell.level == 0 ? spots.count : 0;
  const float offset_x = static_cast<float>(cell.x0) + 0.5f + cell.half_x;
  const float offset_y = static_cast<float>(cell.y0) + 0.5f + cell.half_y;
  if (job.skinned != nullptr) {
    return draw_skinned<kKeys>(job, cell, id, offset_x, offset_y, buffers);
  }
  const CellMap map = map_of(job.points + block.first_corner, lattice.corner, cell.level,
                             job.perspective, offset_x, offset_y);
  draw_voxels<kKeys>(job, cell, map, id, buffers);
}

// Asks for what drawing the cells at and some way behind `i` of the order reads: the nearer they
// are, the more can be followed.
HWY_INLINE void prefetch_cells(const TileJob& job, uint32_t i, uint32_t end) {
  constexpr uint32_t kCell = 12, kLattice = 6, kCorners = 3;
  if (i + kCell < end) hwy::Prefetch(&job.cells[job.list[job.order[i + kCell]]]);
  if (i + kLattice < end) {
    const RasterCell& cell = job.cells[job.list[job.order[i + kLattice]]];
    if (cell.path != RasterPath::rectangle) {
      hwy::Prefetch(&job.blocks[cell.block].svo->cells[cell.cell]);
    }
  }
  if (i + kCorners < end) {
    const RasterCell& cell = job.cells[job.list[job.order[i + kCorners]]];
    if (cell.path == RasterPath::rectangle) return;
    const RasterBlock& block = job.blocks[cell.block];
    const SvoCell& lattice = block.svo->cells[cell.cell];
    hwy::Prefetch(block.svo->bricks.data() + block.svo->blocks[block.block].first_brick +
                  lattice.first_brick);
    for (const uint16_t corner : lattice.corner) {
      hwy::Prefetch(job.points + block.first_corner + corner);
    }
  }
}

// Draws a part of the list that ids suffice for, but for stand-ins.
template <bool kKeys>
HWY_INLINE void draw_list(const TileJob& job, TileBuffers& buffers, TileCounts& counts) {
  const bool occlusion = job.settings->occlusion;
  job.units[0] = job.marks[0] = 0;
  // The cells of the first phase, then, from the end backwards, those of the second.
  uint32_t first = 0, second = job.count;
  for (uint32_t i = 0; i < job.count; ++i) {
    const uint32_t unit = job.cells[job.list[i]].unit;
    job.units[i + 1] = unit;
    job.marks[i + 1] = 0;
    if (job.cells[job.list[i]].fine == kStandIn) continue;
    const bool now = !occlusion || was_seen(job.seen_before, unit);
    job.order[now ? first++ : --second] = i;
  }
  std::reverse(job.order + second, job.order + job.count);
  if (job.settings->front_to_back) sort_front_to_back(job, first, second);
  for (uint32_t i = 0; i < first; ++i) {
    prefetch_cells(job, i, first);
    draw_cell<kKeys>(job, job.order[i], buffers, counts);
  }
  // Depths are looked at anew every so often: that costs about as much as one cell.
  constexpr uint32_t kRenew = 64;
  uint32_t drawn = kRenew;
  for (uint32_t i = second; i < job.count; ++i) {
    if (drawn == kRenew) {
      update(buffers.planes, buffers.far);
      drawn = 0;
    }
    if (is_hidden(job, job.cells[job.list[job.order[i]]], buffers.far)) {
      ++counts.cells_hidden;
      if (!kKeys) job.marks[job.order[i] + 1] = 1;  // stays hidden
      continue;
    }
    draw_cell<kKeys>(job, job.order[i], buffers, counts);
    ++drawn;
  }
}

// Depths name no cells: what is not hidden now counts as seen.
HWY_INLINE void note_not_hidden(const TileJob& job, TileBuffers& buffers) {
  update(buffers.planes, buffers.far);
  for (uint32_t i = 0; i < job.count; ++i) {
    if (job.marks[i + 1] != 0) continue;
    const RasterCell& cell = job.cells[job.list[i]];
    if (!is_hidden(job, cell, buffers.far)) set_seen(job.seen_now, cell.unit);
  }
}

// Blocks whose cells are not hidden now need their detail. What hides them may be drawn coarsely,
// so that other blocks are found once it is finer. Whoever wins a pixel is not hidden: when no
// block that is found lacks its detail, the picture is that of the whole octree.
HWY_INLINE void note_touched(const TileJob& job, TileBuffers& buffers) {
  update(buffers.planes, buffers.far);
  for (uint32_t i = 0; i < job.count; ++i) {
    const RasterCell& cell = job.cells[job.list[i]];
    if (cell.fine != 0 && !is_hidden(job, cell, buffers.far)) set_touched(job.touched[cell.block]);
  }
}

// Stand-ins hide each other and what else is still to be drawn, but show nothing.
HWY_INLINE void lay_stand_ins(const TileJob& job, TilePlanes& planes) {
  for (uint32_t i = 0; i < job.count; ++i) {
    const RasterCell& cell = job.cells[job.list[i]];
    if (cell.fine != kStandIn) continue;
    put_box<false>(planes, clip_to_tile(job, cell.x0, cell.y0, cell.x1, cell.y1), cell.far_depth,
                   0);
  }
}

// What is drawn is in front already. A key of equal depth, but of a lesser unit, must win still, so
// that keys' depths are taken to be the least bit farther: see merge().
template <bool kKeys>
HWY_INLINE void load_front(const TileJob& job, TilePlanes& planes) {
  const float* const from = kKeys ? job.front : job.depth;
  for (uint32_t y = 0; y < job.height; ++y) {
    for (uint32_t x = 0; x < job.width; ++x) {
      const float depth = from[size_t{y} * job.stride + x];
      uint32_t bits;
      std::memcpy(&bits, &depth, sizeof(bits));
      if (kKeys && depth < __builtin_inff()) ++bits;
      std::memcpy(planes.depth + y * kTileSide + x, &bits, sizeof(bits));
    }
  }
}

// Puts what won on top of what is in `keys` and `front`, and marks it as seen. Ids are used up.
HWY_NOINLINE void merge(const TileJob& job, TilePlanes& planes) {
  const Du du;
  for (uint32_t y = 0; y < job.height; ++y) {
    for (uint32_t x = 0; x < kTileSide; x += lanes()) {
      uint32_t* const ids = planes.id + y * kTileSide + x;
      if (hn::AllTrue(du, hn::Eq(hn::Load(du, ids), hn::Zero(du)))) continue;
      for (uint32_t i = x; i < std::min(x + lanes(), job.width); ++i) {
        const uint32_t id = ids[i - x];
        if (id == 0) continue;
        job.marks[id >> 10] = 1;
        const size_t at = size_t{y} * job.stride + i;
        const float depth = planes.depth[y * kTileSide + i];
        const VisibilityKey key = make_key(depth, job.units[id >> 10], id & 1023);
        if (depth > job.front[at] || (depth == job.front[at] && key > job.keys[at])) continue;
        job.front[at] = depth;
        job.keys[at] = key;
      }
      hn::Store(hn::Zero(du), du, ids);
    }
  }
}

// Keys of a vector of pixels, as 32-bit halves: upper, depth 27 | unit 5; lower, unit 22 | code 10.
struct KeyHalves {
  Vu upper, lower;
};
HWY_INLINE KeyHalves keys_of(const TileJob& job, Vu id, Vf depth) {
  const Du du;
  const auto some = hn::Ne(id, hn::Zero(du));
  const Vu nothing = hn::Set(du, 0xffffffffu);
  const Vu place = hn::ShiftRight<10>(id);
  const Vu unit = hn::GatherIndex(du, job.units, hn::BitCast(Di(), place));
  const Vu steps = hn::ShiftRight<4>(hn::BitCast(du, depth));
  const Vu upper = hn::Or(hn::ShiftLeft<5>(steps), hn::ShiftRight<22>(unit));
  const Vu lower = hn::Or(hn::ShiftLeft<10>(unit), hn::And(id, hn::Set(du, 1023)));
  return {hn::IfThenElse(some, upper, nothing), hn::IfThenElse(some, lower, nothing)};
}

// Marks the cells of these pixels as seen, without a branch: place 0 is none.
HWY_INLINE void mark(const TileJob& job, Vu id) {
  alignas(64) uint32_t place[16];
  hn::Store(hn::ShiftRight<10>(id), Du(), place);
  std::atomic_signal_fence(std::memory_order_seq_cst);
  for (uint32_t i = 0; i < lanes(); ++i) job.marks[place[i]] = 1;
}

// `count` keys, for a whole vector without a call or a loop.
HWY_INLINE void write_keys(const VisibilityKey* from, uint32_t count, VisibilityKey* to) {
  const hn::CappedTag<uint64_t, 8> d;
  if (HWY_LIKELY(count == lanes())) {
    for (uint32_t i = 0; i < lanes(); i += static_cast<uint32_t>(hn::MaxLanes(d))) {
      hn::StoreU(hn::Load(d, from + i), d, to + i);
    }
  } else {
    for (uint32_t i = 0; i < count; ++i) to[i] = from[i];
  }
}

// Names what won, and marks it as seen. Ids are used up. `first`: nothing is in `keys` yet.
HWY_NOINLINE void resolve(const TileJob& job, bool first, TilePlanes& planes) {
  const Df d;
  const Du du;
  alignas(64) VisibilityKey nothing[16], keys[16];
  for (VisibilityKey& key : nothing) key = kNothing;
  for (uint32_t y = 0; y < job.height; ++y) {
    VisibilityKey* const out = job.keys + size_t{y} * job.stride;
    for (uint32_t x = 0; x < job.width; x += lanes()) {
      const uint32_t at = y * kTileSide + x;
      const Vu id = hn::Load(du, planes.id + at);
      const uint32_t count = std::min(lanes(), job.width - x);
      if (hn::AllTrue(du, hn::Eq(id, hn::Zero(du)))) {
        if (first) write_keys(nothing, count, out + x);
        continue;
      }
      mark(job, id);
      const KeyHalves halves = keys_of(job, id, hn::Load(d, planes.depth + at));
      hn::Store(hn::Zero(du), du, planes.id + at);
      alignas(64) uint32_t mixed[32];
      hn::StoreInterleaved2(halves.lower, halves.upper, du, mixed);
      std::memcpy(keys, mixed, lanes() * sizeof(VisibilityKey));
      if (!first) {
        for (uint32_t i = 0; i < count; ++i) keys[i] = std::min(out[x + i], keys[i]);
      }
      write_keys(keys, count, out + x);
    }
  }
}

// Keeps what was marked, for the next frame. `marks` and `units` begin one before the list.
HWY_INLINE void keep_marks(const TileJob& job) {
  for (uint32_t i = 1; i <= job.count; ++i) {
    if (job.marks[i] != 0) set_seen(job.seen_now, job.units[i]);
  }
}

HWY_INLINE void write_depth(const TileJob& job, const TilePlanes& planes) {
  for (uint32_t y = 0; y < job.height; ++y) {
    std::memcpy(job.depth + size_t{y} * job.stride, planes.depth + y * kTileSide,
                job.width * sizeof(float));
  }
}

template <bool kKeys>
HWY_INLINE TileCounts draw(const TileJob& job) {
  TileBuffers buffers;
  if (job.adds && job.count == 0) return {};
  clear(job, buffers.planes);
  if (job.adds) load_front<kKeys>(job, buffers.planes);
  clear(buffers.dense);
  TileCounts counts;
  uint32_t at = 0;
  do {
    TileJob part = job;
    part.list = job.list + at;
    part.order = job.order + at;
    part.count = std::min(job.count - at, kMostListed);
    draw_list<kKeys>(part, buffers, counts);
    if (job.touched != nullptr && !job.adds) note_touched(part, buffers);
    if (kKeys) {
      if (job.adds) {
        merge(part, buffers.planes);
      } else {
        resolve(part, at == 0, buffers.planes);
      }
      if (job.settings->occlusion) keep_marks(part);
    } else if (job.settings->occlusion) {
      note_not_hidden(part, buffers);
    }
    at += part.count;
  } while (at < job.count);
  if (!kKeys) write_depth(job, buffers.planes);
  if (job.touched != nullptr && job.adds) {
    lay_stand_ins(job, buffers.planes);
    note_touched(job, buffers);
  }
  return counts;
}

TileCounts draw_keys_kernel(const TileJob& job) {
  return draw<true>(job);
}
TileCounts draw_depth_kernel(const TileJob& job) {
  return draw<false>(job);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(draw_keys_kernel);
HWY_EXPORT(draw_depth_kernel);

TileCounts draw_tile(const TileJob& job) {
  return job.keys != nullptr ? HWY_DYNAMIC_DISPATCH(draw_keys_kernel)(job)
                             : HWY_DYNAMIC_DISPATCH(draw_depth_kernel)(job);
}

}  // namespace sinew
#endif
