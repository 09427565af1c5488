#include "sinew/svo/make/lattice.h"

#include <algorithm>
#include <cmath>

#include "sinew/svo/corners.h"
#include "sinew/svo/make/key_table.h"

namespace sinew {
namespace {

constexpr uint32_t kNone = 0xffffffffu;
constexpr uint32_t kGridSide = 10;  // the cells of a block, and one more all around
constexpr uint32_t kGridCells = kGridSide * kGridSide * kGridSide;

// A sheet of the block, or of a cell beside it.
struct NearSheet {
  const Sheet* sheet = nullptr;
  const SheetMasks* masks = nullptr;  // null without solid filling
  uvec3 place{0};                     // of its cell in the grid: 1..8 within the block
  bool own = false;                   // of the block
  uint32_t first_vertex = 0;          // in the block's vertices, or in CornerJoiner::others_
  uint32_t vertices = 0;
};

uint32_t grid_index(uvec3 place) {
  return place.x + kGridSide * (place.y + kGridSide * place.z);
}

// The corners that two cells have in common, where the second is at `step` from the first, -1..1
// along each axis.
struct CommonCorners {
  uint8_t count = 0;
  uint8_t of_first[8], of_second[8];
};
CommonCorners common_corners(glm::ivec3 step) {
  CommonCorners out;
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 at(k & 1, k >> 1 & 1, k >> 2), from = at - step;
    if (glm::any(glm::lessThan(from, glm::ivec3(0))) ||
        glm::any(glm::greaterThan(from, glm::ivec3(1)))) {
      continue;
    }
    out.of_first[out.count] = static_cast<uint8_t>(k);
    out.of_second[out.count++] = static_cast<uint8_t>(from.x + 2 * from.y + 4 * from.z);
  }
  return out;
}
struct AllCommonCorners {
  CommonCorners of[27];
  AllCommonCorners() {
    for (int i = 0; i < 27; ++i) of[i] = common_corners({i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1});
  }
};
const AllCommonCorners kCommonCorners;

class CornerJoiner {
 public:
  CornerJoiner(std::span<const BlockSheets> blocks, size_t block)
      : blocks_(blocks), own_(block), keys_(blocks[block].keys.size() * 3 / 2) {}

  void collect();
  void join_by_vertices();
  void join_inside();
  // Classes of the block's own sheets as corners; one index a corner of a sheet.
  void number(BlockPart& part, std::vector<SheetPoint>& points);
  const uint16_t* corners_of(size_t sheet) const { return &index_[8 * sheet]; }

 private:
  void add_sheets(const BlockSheets& block, uint32_t cell, uvec3 place);
  void collect_neighbour(glm::ivec3 step);
  bool has_stamped(const NearSheet& sheet, uint32_t stamp) const;
  void join_around(uint32_t sheet);
  void join(uint32_t a, uint32_t b, uint32_t step);
  uint32_t root(uint32_t node);

  std::span<const BlockSheets> blocks_;
  const size_t own_;
  std::vector<NearSheet> sheets_;  // the block's own, in its order, then others
  uint32_t own_sheets_ = 0;
  std::vector<uint32_t> parent_;  // union-find over 8 * sheet + corner
  KeyTable keys_;                 // vertices: the block's own with their numbers, then others
  std::vector<uint32_t> others_;  // vertices of the sheets around
  std::vector<uint32_t> stamps_;  // of each vertex: the last sheet that was asked about
  uint32_t first_at_[kGridCells] = {}, end_at_[kGridCells] = {};  // sheets by grid_index
  std::vector<uint16_t> index_;
};

void CornerJoiner::add_sheets(const BlockSheets& block, uint32_t cell, uvec3 place) {
  const bool own = &block == &blocks_[own_];
  const uint32_t at = grid_index(place);
  first_at_[at] = static_cast<uint32_t>(sheets_.size());
  for (uint32_t s = block.first_sheet[cell]; s < block.first_sheet[cell + 1]; ++s) {
    const std::span<const uint32_t> vertices = block.vertices_of(s);
    NearSheet sheet;
    sheet.sheet = &block.sheets[s];
    sheet.masks = block.masks.empty() ? nullptr : &block.masks[s];
    sheet.place = place;
    sheet.own = own;
    sheet.first_vertex = own ? sheet.sheet->first_vertex : static_cast<uint32_t>(others_.size());
    sheet.vertices = static_cast<uint32_t>(vertices.size());
    if (!own) {
      for (const uint32_t v : vertices) others_.push_back(keys_.number(block.keys[v]));
    }
    sheets_.push_back(sheet);
  }
  end_at_[at] = static_cast<uint32_t>(sheets_.size());
}

// The cells of the block at `step` that touch this one.
void CornerJoiner::collect_neighbour(glm::ivec3 step) {
  const glm::ivec3 place = glm::ivec3(voxel_of(blocks_[own_].morton)) + step;
  if (glm::any(glm::lessThan(place, glm::ivec3(0)))) return;
  const uint64_t morton = morton_of(uvec3(place));
  const auto found = std::ranges::lower_bound(blocks_, morton, {}, &BlockSheets::morton);
  if (found == blocks_.end() || found->morton != morton) return;
  const auto first = [](int s) { return s < 0 ? 7u : 0u; };
  const auto last = [](int s) { return s > 0 ? 0u : 7u; };
  for (uint32_t z = first(step.z); z <= last(step.z); ++z) {
    for (uint32_t y = first(step.y); y <= last(step.y); ++y) {
      for (uint32_t x = first(step.x); x <= last(step.x); ++x) {
        const uvec3 cell(x, y, z);
        const uvec3 in_grid = uvec3(glm::ivec3(cell) + 8 * step + 1);
        add_sheets(*found, static_cast<uint32_t>(morton_of(cell)), in_grid);
      }
    }
  }
}

void CornerJoiner::collect() {
  const BlockSheets& own = blocks_[own_];
  for (const uint64_t key : own.keys) keys_.number(key);  // each once, in their order
  for (uint32_t cell = 0; cell < 512; ++cell) add_sheets(own, cell, voxel_of(cell) + 1u);
  own_sheets_ = static_cast<uint32_t>(sheets_.size());
  for (int i = 0; i < 27; ++i) {
    if (i != 13) collect_neighbour({i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1});
  }
  parent_.resize(8 * sheets_.size());
  for (uint32_t n = 0; n < parent_.size(); ++n) parent_[n] = n;
}

uint32_t CornerJoiner::root(uint32_t node) {
  while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
  return node;
}

// `step`: from the cell of `a` to that of `b`, an index of AllCommonCorners.
void CornerJoiner::join(uint32_t a, uint32_t b, uint32_t step) {
  const CommonCorners& common = kCommonCorners.of[step];
  for (uint32_t i = 0; i < common.count; ++i) {
    const uint32_t p = root(8 * a + common.of_first[i]), q = root(8 * b + common.of_second[i]);
    if (p != q) parent_[std::max(p, q)] = std::min(p, q);
  }
}

bool CornerJoiner::has_stamped(const NearSheet& sheet, uint32_t stamp) const {
  const uint32_t* const list = (sheet.own ? blocks_[own_].vertices : others_).data();
  const uint32_t* const first = list + sheet.first_vertex;
  return std::any_of(first, first + sheet.vertices,
                     [&](uint32_t v) { return stamps_[v] == stamp; });
}

// With the sheets of half the cells around, those that come later; the other half has asked before.
void CornerJoiner::join_around(uint32_t index) {
  const NearSheet& sheet = sheets_[index];
  const uint32_t* const list = (sheet.own ? blocks_[own_].vertices : others_).data();
  for (uint32_t i = 0; i < sheet.vertices; ++i) stamps_[list[sheet.first_vertex + i]] = index;
  for (uint32_t step = 14; step < 27; ++step) {
    const uvec3 place = sheet.place + uvec3(step % 3, step / 3 % 3, step / 9) - 1u;
    if (place.x >= kGridSide || place.y >= kGridSide || place.z >= kGridSide) continue;
    const uint32_t at = grid_index(place);
    for (uint32_t other = first_at_[at]; other < end_at_[at]; ++other) {
      if (has_stamped(sheets_[other], index)) join(index, other, step);
    }
  }
}

void CornerJoiner::join_by_vertices() {
  stamps_.assign(keys_.size(), kNone);
  for (uint32_t s = 0; s < sheets_.size(); ++s) join_around(s);
}

// The voxels of `masks` on the cell's face across `axis`, as 64 bits of the other two coordinates.
uint64_t face_of(const std::array<uint64_t, 8>& masks, int axis, bool far) {
  uint64_t face = 0;
  for (uint32_t i = 0; i < 64; ++i) {
    uvec3 voxel(0);
    voxel[axis] = far ? 7 : 0;
    voxel[(axis + 1) % 3] = i & 7;
    voxel[(axis + 2) % 3] = i >> 3;
    const uvec3 brick = voxel / 4u, bit = voxel % 4u;
    const uint64_t mask = masks[brick.x + 2 * brick.y + 4 * brick.z];
    face |= (mask >> (bit.x + 4 * bit.y + 16 * bit.z) & 1) << i;
  }
  return face;
}

// Sheets of cells with a common face, where filling on one side meets anything on the other.
void CornerJoiner::join_inside() {
  if (sheets_.empty() || !sheets_[0].masks) return;
  for (uint32_t a = 0; a < sheets_.size(); ++a) {
    for (int axis = 0; axis < 3; ++axis) {
      uvec3 next = sheets_[a].place;
      if (++next[axis] >= kGridSide) continue;
      const uint32_t at = grid_index(next);
      for (uint32_t b = first_at_[at]; b < end_at_[at]; ++b) {
        const SheetMasks &m = *sheets_[a].masks, &n = *sheets_[b].masks;
        const uint64_t meets = (face_of(m.inside, axis, true) & face_of(n.all, axis, false)) |
                               (face_of(m.all, axis, true) & face_of(n.inside, axis, false));
        if (meets != 0) join(a, b, axis == 0 ? 14 : axis == 1 ? 16 : 22);
      }
    }
  }
}

void CornerJoiner::number(BlockPart& part, std::vector<SheetPoint>& points) {
  // Parents come first, so one pass makes them roots.
  for (uint32_t& parent : parent_) parent = parent_[parent];
  std::vector<uint32_t> corner_of(parent_.size(), kNone);  // by root
  index_.resize(8 * size_t{own_sheets_});
  for (uint32_t node = 0; node < index_.size(); ++node) {
    uint32_t& corner = corner_of[parent_[node]];
    if (corner == kNone) {
      corner = static_cast<uint32_t>(part.corners.size());
      const uint32_t k = node & 7;
      const uvec3 at = sheets_[node >> 3].place - 1u + uvec3(k & 1, k >> 1 & 1, k >> 2);
      PartCorner added;
      added.place = static_cast<uint16_t>(at.x + 9 * at.y + 81 * at.z);
      part.corners.push_back(added);
    }
    index_[node] = static_cast<uint16_t>(corner);
  }
  points.assign(part.corners.size(), SheetPoint{});
  for (uint32_t node = 0; node < parent_.size(); ++node) {
    const uint32_t corner = corner_of[parent_[node]];
    if (corner == kNone) continue;
    const SheetPoint& point = sheets_[node >> 3].sheet->near[node & 7];
    if (nearer(point, points[corner])) points[corner] = point;
  }
}

// Targets that move no corner of the block are left out.
void make_deltas(const LatticeSource& source, std::span<const SheetPoint> points,
                 std::span<const float> units, BlockPart& part) {
  for (uint32_t target = 0; target < source.targets; ++target) {
    if (units[target] == 0.0f) continue;
    const size_t first = part.deltas.size();
    bool moves = false;
    for (const SheetPoint& point : points) {
      const vec3 delta = target_delta(source, point, target) / units[target];
      std::array<int16_t, 3> stored{};
      for (int i = 0; i < 3; ++i) {
        if (!std::isfinite(delta[i])) continue;
        stored[i] = static_cast<int16_t>(std::lrint(std::clamp(delta[i], -32767.0f, 32767.0f)));
        moves = moves || stored[i] != 0;
      }
      part.deltas.push_back(stored);
    }
    if (moves) part.targets.push_back(target);
    if (!moves) part.deltas.resize(first);
  }
}

}  // namespace

void make_corners(const LatticeSource& source, std::span<const BlockSheets> blocks, size_t block,
                  std::span<const float> units, BlockPart& part) {
  CornerJoiner joiner(blocks, block);
  joiner.collect();
  joiner.join_by_vertices();
  joiner.join_inside();
  std::vector<SheetPoint> points;
  joiner.number(part, points);
  if (source.skin.influences > 0) {
    for (size_t c = 0; c < points.size(); ++c) skin_corner(source, points[c], part.corners[c]);
  }
  make_deltas(source, points, units, part);
  for (size_t c = 0; c < part.cells.size(); ++c) {
    const uint16_t* const corners = joiner.corners_of(blocks[block].sheet_of_copy[c]);
    std::copy(corners, corners + 8, part.cells[c].corner);
  }
}

}  // namespace sinew
