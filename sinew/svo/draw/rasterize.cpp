// The rasteriser's frame: blocks, cells, lists of the tiles, tiles. Everything that is counted or
// listed in parallel is so in fixed chunks, in order.
#include "sinew/svo/draw/rasterize.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>

#include "sinew/base/buffer.h"
#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/draw/rasterize_kernels.h"
#include "sinew/svo/file/stream.h"
#include "sinew/svo/thesis/thesis_skinned.h"

namespace sinew {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// A buffer that only ever grows; what it held is lost then.
template <class T>
T* at_least(Buffer<T>& buffer, size_t size) {
  if (buffer.size() < size) buffer = Buffer<T>(size + size / 4);
  return buffer.data();
}

struct BlockToMake {
  PosedSvo* posed = nullptr;
  uint32_t block = 0;

  bool operator==(const BlockToMake&) const = default;
  bool operator<(const BlockToMake& b) const {
    return posed != b.posed ? std::less<PosedSvo*>()(posed, b.posed) : block < b.block;
  }
};

}  // namespace

struct RasterScratch {
  std::vector<uint32_t> stack;
  std::vector<PosedSvo*> poses;
  std::vector<ClipMap> maps;  // one an instance
  std::vector<RasterBlock> blocks;
  std::vector<RasterCell> nodes;
  std::vector<BlockToMake> to_make;
  std::vector<uint8_t> touched;  // one a block; empty if all detail is there
  Buffer<ClipPoint> points, screen;
  Buffer<RasterCell> cells;
  Buffer<uint32_t> offsets;  // of the entries of each chunk in each tile's list; tile-major
  Buffer<uint32_t> list, order, units;
  Buffer<uint8_t> marks;
  std::vector<float> front;       // of a picture in parts: depths of its keys
  std::vector<uint64_t> seen[2];  // before, now
  std::vector<TileCounts> counts;
};

void RasterScratchDeleter::operator()(RasterScratch* scratch) const {
  delete scratch;
}
RasterScratchPtr make_raster_scratch() {
  return RasterScratchPtr(new RasterScratch);
}

namespace {

// Terms are summed as in project_corners.
ClipPoint project(const ClipMap& m, vec3 p) {
  const auto at = [&](const vec4& f) { return (f.x * p.x + f.y * p.y) + (f.z * p.z + f.w); };
  return {at(m.x), at(m.y), at(m.depth), 0.0f};
}

ScreenBox project_box(const ClipMap& m, const Box& box) {
  ClipPoint corners[8];
  float reach[3] = {};
  for (int i = 0; i < 8; ++i) {
    const vec3 p(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                 i & 4 ? box.max.z : box.min.z);
    corners[i] = project(m, p);
    const vec4 size(abs(p), 1.0f);
    reach[0] = std::max(reach[0], dot(abs(m.x), size));
    reach[1] = std::max(reach[1], dot(abs(m.y), size));
    reach[2] = std::max(reach[2], dot(abs(m.depth), size));
  }
  return project_hull(corners, m.near, m.perspective, reach);
}

// What one call works on.
struct Frame {
  std::span<const VoxelInstance> instances;
  const RasterView& view;
  const RasterSettings& settings;
  RasterScratch& scratch;
  RasterPart part = RasterPart::whole;
  uint32_t tiles_x = 0, tiles_y = 0;
  uint32_t chunks = 0;  // of blocks; one more for nodes
  uint32_t blocks_a_chunk = 1;
  uint32_t first_node = 0;  // in scratch.cells, behind those of blocks
  RasterStats stats = {};

  uint32_t tiles() const { return tiles_x * tiles_y; }
};

// Lists a node for drawing as one box.
void add_node(Frame& frame, const ClipMap& map, const Box& bounds, const ScreenBox& box,
              PixelRange x, PixelRange y, uint32_t unit) {
  RasterCell cell;
  cell.unit = unit;
  cell.near_depth = cell.far_depth =
      std::clamp(project(map, bounds.center()).depth, box.near_depth, box.far_depth);
  cell.x0 = static_cast<int16_t>(x.first);
  cell.x1 = static_cast<int16_t>(x.last);
  cell.y0 = static_cast<int16_t>(y.first);
  cell.y1 = static_cast<int16_t>(y.last);
  cell.path = RasterPath::rectangle;
  frame.scratch.nodes.push_back(cell);
}

// Looks at one node; lists it if it is a block or small, else pushes its children.
void view_node(Frame& frame, uint32_t instance, uint32_t first_block_node, uint32_t n) {
  RasterScratch& scratch = frame.scratch;
  const VoxelInstance& body = frame.instances[instance];
  const Svo& svo = body.posed->svo();
  const SvoNode& node = svo.nodes[n];
  const bool first = frame.part != RasterPart::more;
  if (node.level == kBlockLevel && first) ++frame.stats.blocks;
  const Box bounds = body.posed->bounds(n);
  const ScreenBox box = project_box(scratch.maps[instance], bounds);
  if (!box.seen()) return;
  const PixelRange x = pixel_range(box.x0, box.x1), y = pixel_range(box.y0, box.y1);
  if (x.empty() || y.empty() || x.last < 0 || y.last < 0 ||
      x.first >= static_cast<int>(frame.view.width) ||
      y.first >= static_cast<int>(frame.view.height)) {
    return;
  }
  if (frame.settings.lod && std::max(box.x1 - box.x0, box.y1 - box.y0) < frame.settings.smallest) {
    if (!first) return;
    return add_node(frame, scratch.maps[instance], bounds, box, x, y,
                    body.first_unit + static_cast<uint32_t>(svo.cells.size()) + n);
  }
  if (node.level == kBlockLevel) {
    const auto shown = svo.paging ? svo.paging->shown(n - first_block_node) : BlockShown::detail;
    if (shown == BlockShown::drawn) return;
    scratch.blocks.push_back({.svo = &svo,
                              .instance = instance,
                              .block = n - first_block_node,
                              .node = n,
                              .first_unit = body.first_unit,
                              .resident = shown == BlockShown::detail,
                              .later = shown == BlockShown::later});
    return;
  }
  for (uint32_t i = node.count; i-- > 0;) scratch.stack.push_back(node.first + i);
}

// Whether the instance may have something that the parts before did not draw.
bool has_more(const Frame& frame, const Svo& svo) {
  return frame.part != RasterPart::more || (svo.paging && svo.paging->in_parts());
}

void find_blocks(Frame& frame) {
  RasterScratch& scratch = frame.scratch;
  scratch.maps.clear();
  scratch.blocks.clear();
  scratch.nodes.clear();
  for (uint32_t i = 0; i < frame.instances.size(); ++i) {
    const VoxelInstance& body = frame.instances[i];
    scratch.maps.push_back(map_of(frame.view, body.placement));
    if (body.posed == nullptr || body.posed->svo().block_count() == 0) continue;
    if (!has_more(frame, body.posed->svo())) continue;
    const uint32_t first_block_node = body.posed->svo().first_block_node();
    scratch.stack.assign(1, 0);
    while (!scratch.stack.empty()) {
      const uint32_t n = scratch.stack.back();
      scratch.stack.pop_back();
      view_node(frame, i, first_block_node, n);
    }
  }
  frame.stats.blocks_drawn = scratch.blocks.size();
}

// A pose may be shared by instances, a block is made once.
void make_blocks(Frame& frame) {
  RasterScratch& scratch = frame.scratch;
  scratch.to_make.clear();
  for (const RasterBlock& block : scratch.blocks) {
    PosedSvo* const posed = frame.instances[block.instance].posed;
    if (!posed->is_made(block.block)) scratch.to_make.push_back({posed, block.block});
  }
  scratch.poses.clear();
  for (const VoxelInstance& body : frame.instances) scratch.poses.push_back(body.posed);
  std::sort(scratch.poses.begin(), scratch.poses.end(), std::less<PosedSvo*>());
  if (std::adjacent_find(scratch.poses.begin(), scratch.poses.end()) != scratch.poses.end()) {
    std::sort(scratch.to_make.begin(), scratch.to_make.end());
    const auto end = std::unique(scratch.to_make.begin(), scratch.to_make.end());
    scratch.to_make.erase(end, scratch.to_make.end());
  }
  parallel_for(scratch.to_make.size(), 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      scratch.to_make[i].posed->make_block(scratch.to_make[i].block);
    }
  });
}

// Tiles that a cell may cover pixels of.
struct TileRange {
  uint32_t x0, y0, x1, y1;  // inclusive
};
TileRange tiles_of(const Frame& frame, const RasterCell& cell) {
  const auto at_least_0 = [](int v) { return static_cast<uint32_t>(std::max(v, 0)); };
  return {at_least_0(cell.x0) / kTileSide, at_least_0(cell.y0) / kTileSide,
          std::min(at_least_0(cell.x1) / kTileSide, frame.tiles_x - 1),
          std::min(at_least_0(cell.y1) / kTileSide, frame.tiles_y - 1)};
}

// Calls with (index of the cell, tile) for all cells of a chunk, in order.
template <class F>
void for_each_entry(const Frame& frame, uint32_t chunk, const F& call) {
  const RasterScratch& scratch = frame.scratch;
  const auto visit = [&](uint32_t first, uint32_t count) {
    for (uint32_t c = first; c < first + count; ++c) {
      const TileRange range = tiles_of(frame, scratch.cells[c]);
      for (uint32_t y = range.y0; y <= range.y1; ++y) {
        for (uint32_t x = range.x0; x <= range.x1; ++x) call(c, y * frame.tiles_x + x);
      }
    }
  };
  const uint32_t blocks = static_cast<uint32_t>(scratch.blocks.size());
  if (chunk == frame.chunks) {
    return visit(frame.first_node, static_cast<uint32_t>(scratch.nodes.size()));
  }
  const uint32_t begin = chunk * frame.blocks_a_chunk;
  for (uint32_t b = begin; b < std::min(begin + frame.blocks_a_chunk, blocks); ++b) {
    visit(scratch.blocks[b].first_cell, scratch.blocks[b].cells);
  }
}

// Gives each block its part of the buffers; returns the most corners that one has.
uint32_t place_blocks(Frame& frame) {
  RasterScratch& scratch = frame.scratch;
  size_t corners = 0, cells = 0;
  uint32_t most = 0;
  for (RasterBlock& block : scratch.blocks) {
    const SvoBlock& at = block.svo->blocks[block.block];
    const SvoBlock& next = block.svo->blocks[block.block + 1];
    block.first_corner = static_cast<uint32_t>(corners);
    block.first_cell = static_cast<uint32_t>(cells);
    const uint32_t count = next.first_corner - at.first_corner;
    corners += count;
    cells += next.first_cell - at.first_cell;
    most = std::max(most, count);
  }
  SINEW_CHECK(corners < 0xffffffffu && cells + scratch.nodes.size() < 0xffffffffu);
  frame.first_node = static_cast<uint32_t>(cells);
  at_least(scratch.points, corners);
  RasterCell* const all = at_least(scratch.cells, cells + scratch.nodes.size());
  std::copy(scratch.nodes.begin(), scratch.nodes.end(), all + cells);
  return most;
}

void view_blocks(Frame& frame) {
  RasterScratch& scratch = frame.scratch;
  constexpr uint32_t kMostChunks = 64;
  const uint32_t blocks = static_cast<uint32_t>(scratch.blocks.size());
  const uint32_t most = place_blocks(frame);
  frame.blocks_a_chunk = std::max((blocks + kMostChunks - 1) / kMostChunks, 1u);
  frame.chunks = (blocks + frame.blocks_a_chunk - 1) / frame.blocks_a_chunk;
  at_least(scratch.screen, size_t{frame.chunks} * most);
  parallel_for(blocks, frame.blocks_a_chunk, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) {
      RasterBlock& block = scratch.blocks[b];
      const VoxelInstance& body = frame.instances[block.instance];
      const PosedBlock posed = body.posed->block(block.block);
      BlockJob job;
      job.map = &scratch.maps[block.instance];
      job.settings = &frame.settings;
      job.width = frame.view.width;
      job.height = frame.view.height;
      job.node = block.node;
      job.positions = posed.positions.data();
      job.corners = static_cast<uint32_t>(posed.positions.size());
      job.points = scratch.points.data() + block.first_corner;
      job.screen = scratch.screen.data() + begin / frame.blocks_a_chunk * most;
      job.cells = scratch.cells.data() + block.first_cell;
      view_block(job, static_cast<uint32_t>(b), block);
    }
  });
  for (const RasterBlock& block : scratch.blocks) frame.stats.cells += block.cells;
}

// Lists cells by tiles: counts, sums, lists.
void list_cells(Frame& frame) {
  RasterScratch& scratch = frame.scratch;
  const size_t columns = frame.chunks + 1, size = columns * frame.tiles();
  uint32_t* const offsets = at_least(scratch.offsets, size + 1);
  std::fill_n(offsets, size, 0u);
  parallel_for(columns, 1, [&](size_t begin, size_t) {
    const uint32_t chunk = static_cast<uint32_t>(begin);
    for_each_entry(frame, chunk,
                   [&](uint32_t, uint32_t tile) { ++offsets[tile * columns + chunk]; });
  });
  uint32_t sum = 0;
  for (size_t i = 0; i < size; ++i) {
    const uint32_t count = offsets[i];
    offsets[i] = sum;
    sum += count;
  }
  uint32_t* const list = at_least(scratch.list, sum);
  at_least(scratch.order, sum);
  at_least(scratch.units, sum + frame.tiles());
  at_least(scratch.marks, sum + frame.tiles());
  // Afterwards each offset is where the next one was: the ends.
  parallel_for(columns, 1, [&](size_t begin, size_t) {
    const uint32_t chunk = static_cast<uint32_t>(begin);
    for_each_entry(frame, chunk, [&](uint32_t cell, uint32_t tile) {
      list[offsets[tile * columns + chunk]++] = cell;
    });
  });
}

// `job` has what all tiles share: pointers to the whole picture.
void draw_tiles(Frame& frame, TileJob shared) {
  RasterScratch& scratch = frame.scratch;
  const size_t columns = frame.chunks + 1;
  shared.settings = &frame.settings;
  shared.blocks = scratch.blocks.data();
  shared.points = scratch.points.data();
  shared.cells = scratch.cells.data();
  shared.near = frame.view.near;
  shared.perspective = is_perspective(frame.view);
  shared.seen_before = scratch.seen[0].data();
  shared.seen_now = scratch.seen[1].data();
  shared.stride = frame.view.width;
  scratch.counts.resize(frame.tiles());
  parallel_for(frame.tiles(), 1, [&](size_t begin, size_t) {
    const uint32_t tile = static_cast<uint32_t>(begin);
    TileJob job = shared;
    job.x = tile % frame.tiles_x * kTileSide;
    job.y = tile / frame.tiles_x * kTileSide;
    job.width = std::min(kTileSide, frame.view.width - job.x);
    job.height = std::min(kTileSide, frame.view.height - job.y);
    const uint32_t first = tile == 0 ? 0 : scratch.offsets[tile * columns - 1];
    job.list = scratch.list.data() + first;
    job.order = scratch.order.data() + first;
    job.units = scratch.units.data() + first + tile;
    job.marks = scratch.marks.data() + first + tile;
    job.count = scratch.offsets[(tile + 1) * columns - 1] - first;
    const size_t pixel = size_t{job.y} * shared.stride + job.x;
    if (job.keys != nullptr) job.keys += pixel;
    if (job.depth != nullptr) job.depth += pixel;
    if (job.front != nullptr) job.front += pixel;
    scratch.counts[tile] = draw_tile(job);
  });
  for (const TileCounts& counts : scratch.counts) {
    frame.stats.cells_hidden += counts.cells_hidden;
    frame.stats.voxels_drawn += counts.voxels;
    frame.stats.leaves_drawn += counts.leaves;
    frame.stats.nodes_drawn += counts.nodes;
  }
}

// Asks for the blocks that show something finer than cells, or would if it were there.
void request_blocks(const RasterScratch& scratch) {
  for (size_t b = 0; b < scratch.touched.size(); ++b) {
    const RasterBlock& block = scratch.blocks[b];
    if (scratch.touched[b] == 0 || !block.svo->paging) continue;
    block.svo->paging->request(block.block, block.voxel);
  }
}

// Whether some instance has detail that comes and goes.
bool is_paged(std::span<const VoxelInstance> instances) {
  return std::ranges::any_of(instances, [](const VoxelInstance& body) {
    return body.posed != nullptr && static_cast<bool>(body.posed->svo().paging);
  });
}

void check_units(std::span<const VoxelInstance> instances) {
  uint64_t end = 0;
  for (const VoxelInstance& body : instances) {
    if (body.posed == nullptr) continue;
    SINEW_CHECK(body.first_unit >= end);
    end = uint64_t{body.first_unit} + unit_count(body.posed->svo());
    SINEW_CHECK(end <= kMostUnits);
  }
}

// What was seen now was seen before, in the next frame.
void turn_history(Frame& frame) {
  uint64_t units = 0;
  for (const VoxelInstance& body : frame.instances) {
    if (body.posed != nullptr) units = uint64_t{body.first_unit} + unit_count(body.posed->svo());
  }
  auto& [before, now] = frame.scratch.seen;
  std::swap(before, now);
  before.resize(units / 64 + 1);
  now.assign(units / 64 + 1, 0);
}

RasterStats run(std::span<const VoxelInstance> instances, const RasterView& view,
                const RasterSettings& settings, RasterScratch& scratch, const TileJob& out,
                RasterPart part = RasterPart::whole) {
  check_units(instances);
  Frame frame{
      .instances = instances, .view = view, .settings = settings, .scratch = scratch, .part = part};
  frame.tiles_x = (view.width + kTileSide - 1) / kTileSide;
  frame.tiles_y = (view.height + kTileSide - 1) / kTileSide;
  Clock::time_point start = Clock::now();
  if (part != RasterPart::more) turn_history(frame);
  find_blocks(frame);
  frame.stats.view_ms = ms_since(start);
  start = Clock::now();
  make_blocks(frame);
  frame.stats.pose_ms = ms_since(start);
  start = Clock::now();
  view_blocks(frame);
  list_cells(frame);
  frame.stats.view_ms += ms_since(start);
  start = Clock::now();
  scratch.touched.assign(is_paged(instances) ? scratch.blocks.size() : 0, 0);
  TileJob job = out;
  job.touched = scratch.touched.empty() ? nullptr : scratch.touched.data();
  draw_tiles(frame, job);
  request_blocks(scratch);
  frame.stats.draw_ms = ms_since(start);
  return frame.stats;
}

}  // namespace

RasterStats rasterize(std::span<const VoxelInstance> instances, const RasterView& view,
                      const RasterSettings& settings, RasterScratch& scratch, Visibility& out,
                      RasterPart part) {
  const size_t pixels = size_t{view.width} * view.height;
  out.width = view.width;
  out.height = view.height;
  if (part == RasterPart::first) {
    out.keys.assign(pixels, kNothing);
    scratch.front.assign(pixels, std::numeric_limits<float>::infinity());
  } else {
    SINEW_CHECK(part == RasterPart::whole || scratch.front.size() == pixels);
    out.keys.resize(pixels);
  }
  TileJob job;
  job.keys = out.keys.data();
  job.adds = part != RasterPart::whole;
  job.front = job.adds ? scratch.front.data() : nullptr;
  return run(instances, view, settings, scratch, job, part);
}

RasterStats rasterize_depth(std::span<const VoxelInstance> instances, const RasterView& view,
                            const RasterSettings& settings, RasterScratch& scratch, DepthMap& out,
                            RasterPart part) {
  const size_t pixels = size_t{view.width} * view.height;
  out.width = view.width;
  out.height = view.height;
  if (part == RasterPart::first) {
    out.depth.assign(pixels, std::numeric_limits<float>::infinity());
  } else {
    out.depth.resize(pixels);
  }
  TileJob job;
  job.depth = out.depth.data();
  job.adds = part != RasterPart::whole;
  return run(instances, view, settings, scratch, job, part);
}

RasterStats rasterize_skinned(const VoxelInstance& instance, const RasterView& view,
                              const RasterSettings& settings, SkinnedTable& table,
                              RasterScratch& scratch, Visibility& out) {
  const Clock::time_point start = Clock::now();
  set_view(instance, view, table);
  const double view_ms = ms_since(start);
  out.width = view.width;
  out.height = view.height;
  out.keys.resize(size_t{view.width} * view.height);
  TileJob job;
  job.keys = out.keys.data();
  job.skinned = &table;
  RasterStats stats = run({&instance, 1}, view, settings, scratch, job);
  stats.view_ms += view_ms;
  return stats;
}

}  // namespace sinew
