// A block's cells, one after the other: sheets, copies with their voxels, and where each sheet is
// nearest to the cell's corners.
#include "sinew/svo/make/sheets.h"

#include <algorithm>

#include "sinew/svo/brick.h"
#include "sinew/svo/corners.h"
#include "sinew/svo/make/block_ranges.h"
#include "sinew/svo/make/cell_sheets.h"

namespace sinew {
namespace {

// Mean of the attributes of a voxel's fragments that lie in one copy. Every fragment counts the
// same: fragments are small where triangles are, and their mean is what a pixel of that size shows.
// Of colours, the square roots that are stored: they differ little within a voxel.
struct FragmentMean {
  uint32_t count = 0;
  uint16_t normal = 0, color = 0;  // of the first
  bool same = true;                // as all others; then the sums are not kept
  vec3 normals{0.0f};
  uint32_t red = 0, green = 0, blue = 0;

  void add(const VoxelFragment& fragment) {
    if (count++ == 0) {
      normal = fragment.normal;
      color = fragment.color;
      same = true;
      return;
    }
    if (same && fragment.normal == normal && fragment.color == color) return;
    if (same) {
      same = false;
      normals = vec3(0.0f);
      red = green = blue = 0;
      add_to_sums(normal, color, count - 1);
    }
    add_to_sums(fragment.normal, fragment.color, 1);
  }
  uint16_t mean_normal() const {
    // Opposite sides of something thin cancel out.
    if (same || dot(normals, normals) < 1e-4f * static_cast<float>(count)) return normal;
    return pack_normal(normals);
  }
  uint16_t mean_color() const {
    if (same) return color;
    const float scale = 1.0f / static_cast<float>(count);
    const auto mean = [&](uint32_t sum) {
      return static_cast<uint32_t>(static_cast<float>(sum) * scale + 0.5f);
    };
    return static_cast<uint16_t>(mean(red) << 11 | mean(green) << 5 | mean(blue));
  }

 private:
  void add_to_sums(uint16_t packed_normal, uint16_t packed_color, uint32_t times) {
    normals += static_cast<float>(times) * unit_normal(packed_normal);
    red += times * (packed_color >> 11);
    green += times * (packed_color >> 5 & 63);
    blue += times * (packed_color & 31);
  }
};

// A copy of a cell in the making.
struct Copy {
  uint32_t sheet = 0;
  uint16_t material = 0;
  FragmentMean mean;  // of the voxel at hand
  CopyVoxels voxels;
};

// Squared distance from the middles of voxels to the cell's corners in units of half a voxel, one
// axis: [coordinate][corner].
struct CornerDistances {
  uint32_t x[8][8], y[8][8], z[8][8];
};
constexpr CornerDistances make_corner_distances() {
  CornerDistances out{};
  for (uint32_t i = 0; i < 8; ++i) {
    const uint32_t near = (2 * i + 1) * (2 * i + 1), far = (15 - 2 * i) * (15 - 2 * i);
    for (uint32_t corner = 0; corner < 8; ++corner) {
      out.x[i][corner] = (corner & 1 ? far : near) << 9;
      out.y[i][corner] = (corner & 2 ? far : near) << 9;
      out.z[i][corner] = (corner & 4 ? far : near) << 9;
    }
  }
  return out;
}
constexpr CornerDistances kDistances = make_corner_distances();

// The voxels of a sheet that are nearest to the cell's corners: distance << 9 | Morton code.
struct NearVoxels {
  uint32_t at[8] = {~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u};

  void add(uint32_t morton, uint32_t place) {
    const uint32_t* const x = kDistances.x[place & 7];
    const uint32_t* const y = kDistances.y[place >> 3 & 7];
    const uint32_t* const z = kDistances.z[place >> 6];
    for (int k = 0; k < 8; ++k) at[k] = std::min(at[k], x[k] + y[k] + z[k] + morton);
  }
};

class CellWriter {
 public:
  CellWriter(const LatticeSource& source, size_t fragments, bool solid, BlockSheets& sheets,
             BlockPart& part)
      : source_(source), finder_(source, fragments), solid_(solid), sheets_(sheets), part_(part) {}

  void write(std::span<const VoxelFragment> fragments);

 private:
  void find_copies();
  uint32_t copy_of(uint32_t sheet, uint16_t material);
  void add_voxel(std::span<const VoxelFragment> voxel, size_t first);
  void fill_inside();
  void find_near(std::span<const VoxelFragment> fragments);
  void append_sheets(uint16_t cell);
  void append_copies(uint16_t cell);

  const LatticeSource& source_;
  const CellOrder& order_ = cell_order();
  SheetFinder finder_;
  const bool solid_;
  BlockSheets& sheets_;
  BlockPart& part_;

  // Of the cell at hand.
  uint32_t sheet_count_ = 0;
  std::vector<uint32_t> first_vertex_;
  std::vector<uint32_t> copy_of_triangle_;
  std::vector<Copy> copies_;  // the first `copy_count_`; kept for their memory
  uint32_t copy_count_ = 0;
  std::vector<uint32_t> met_;       // copies that the voxel at hand is in
  uint32_t best_[kMostSheets + 1];  // of those, the one of each sheet
  NearVoxels near_voxels_[kMostSheets];
  SheetPoint near_[kMostSheets][8];
  uint32_t first_fragment_[512];  // of each voxel, by Morton code
  std::vector<VoxelFragment> inside_;
};

uint32_t CellWriter::copy_of(uint32_t sheet, uint16_t material) {
  for (uint32_t c = 0; c < copy_count_; ++c) {
    if (copies_[c].sheet == sheet && copies_[c].material == material) return c;
  }
  if (copy_count_ == copies_.size()) copies_.emplace_back();
  Copy& copy = copies_[copy_count_];
  copy.sheet = sheet;
  copy.material = material;
  copy.mean.count = 0;
  std::ranges::fill(copy.voxels.masks, uint64_t{0});
  return copy_count_++;
}

void CellWriter::find_copies() {
  copy_count_ = 0;
  copy_of_triangle_.clear();
  uint32_t last = 0;
  for (const SheetFinder::CellTriangle& t : finder_.triangles()) {
    const uint16_t material = source_.materials[t.triangle];
    const bool again =
        copy_count_ > 0 && copies_[last].sheet == t.sheet && copies_[last].material == material;
    if (!again) last = copy_of(t.sheet, material);
    copy_of_triangle_.push_back(last);
  }
}

// `voxel` are the fragments of one voxel, from the `first`th of the cell's.
void CellWriter::add_voxel(std::span<const VoxelFragment> voxel, size_t first) {
  const uint32_t morton = voxel.front().voxel & 511;
  const uint32_t code = order_.code[morton], place = order_.place[morton];
  first_fragment_[morton] = static_cast<uint32_t>(first);
  if (voxel.size() == 1 && voxel.front().triangle != kInside) {
    Copy& copy = copies_[copy_of_triangle_[finder_.of_fragments()[first]]];
    copy.voxels.set(code, voxel.front().normal, voxel.front().color);
    near_voxels_[copy.sheet].add(morton, place);
    return;
  }
  met_.clear();
  for (size_t i = 0; i < voxel.size(); ++i) {
    const uint32_t triangle = finder_.of_fragments()[first + i];
    if (triangle == kInside) continue;
    const uint32_t copy = copy_of_triangle_[triangle];
    if (copies_[copy].mean.count == 0) met_.push_back(copy);
    copies_[copy].mean.add(voxel[i]);
  }
  if (met_.empty()) return inside_.push_back(voxel.front());
  // One material a sheet: of most fragments, then the lowest.
  for (const uint32_t c : met_) best_[copies_[c].sheet] = c;
  for (const uint32_t c : met_) {
    uint32_t& best = best_[copies_[c].sheet];
    const uint32_t more = copies_[c].mean.count, most = copies_[best].mean.count;
    if (more > most || (more == most && copies_[c].material < copies_[best].material)) best = c;
  }
  for (const uint32_t c : met_) {
    Copy& copy = copies_[c];
    if (best_[copy.sheet] == c) {
      copy.voxels.set(code, copy.mean.mean_normal(), copy.mean.mean_color());
      near_voxels_[copy.sheet].add(morton, place);
    }
  }
  for (const uint32_t c : met_) copies_[c].mean.count = 0;
}

// The nearest points lie in the nearest voxel or beside it: near enough for a corner, whose weights
// vary little within a voxel.
void CellWriter::find_near(std::span<const VoxelFragment> fragments) {
  if (source_.rest.empty()) return;
  const uvec3 cell = voxel_of(fragments.front().voxel >> 9);
  for (uint32_t sheet = 0; sheet < sheet_count_; ++sheet) {
    for (uint32_t k = 0; k < 8; ++k) {
      const vec3 corner = corner_rest(source_.grid, cell + uvec3(k & 1, k >> 1 & 1, k >> 2));
      SheetPoint best;
      const VoxelMorton voxel =
          fragments.front().voxel >> 9 << 9 | (near_voxels_[sheet].at[k] & 511);
      for (size_t i = first_fragment_[voxel & 511];
           i < fragments.size() && fragments[i].voxel == voxel; ++i) {
        const uint32_t t = finder_.of_fragments()[i];
        if (t == kInside || finder_.triangles()[t].sheet != sheet) continue;
        const SheetPoint point = nearest_point(source_, fragments[i].triangle, corner);
        if (nearer(point, best)) best = point;
      }
      near_[sheet][k] = best;
    }
  }
}

// Voxels of solid filling join the copy that reaches them first through their neighbours within the
// cell; where none does, they have one of their own.
void CellWriter::fill_inside() {
  constexpr uint32_t kNobody = 0xffffffffu, kWaiting = 0xfffffffeu;
  const CellOrder& order = cell_order();
  uint32_t owner[512];
  uint16_t queue[512];
  const VoxelFragment* filling[512];
  std::ranges::fill(owner, kNobody);
  uint32_t end = 0;
  for (const VoxelFragment& v : inside_) {
    owner[order.place[v.voxel & 511]] = kWaiting;
    filling[order.place[v.voxel & 511]] = &v;
  }
  for (uint32_t morton = 0; morton < 512; ++morton) {
    for (uint32_t c = 0; c < copy_count_; ++c) {
      if (!copies_[c].voxels.has(order.code[morton])) continue;
      owner[order.place[morton]] = c;
      queue[end++] = order.place[morton];
      break;
    }
  }
  const auto take = [&](uint32_t place, uint32_t copy) {
    const VoxelFragment& v = *filling[place];
    owner[place] = copy;
    copies_[copy].voxels.set(order.code[v.voxel & 511], v.normal, v.color);
    queue[end++] = static_cast<uint16_t>(place);
  };
  for (uint32_t next = 0; next < end; ++next) {
    const uint32_t place = queue[next];
    for (const uint32_t step : {1u, 8u, 64u}) {
      const uint32_t along = place / step & 7;
      if (along > 0 && owner[place - step] == kWaiting) take(place - step, owner[place]);
      if (along < 7 && owner[place + step] == kWaiting) take(place + step, owner[place]);
    }
  }
  uint32_t rest = kNobody;
  for (const VoxelFragment& v : inside_) {
    const uint32_t place = order.place[v.voxel & 511];
    if (owner[place] != kWaiting) continue;
    if (rest == kNobody) rest = copy_of(sheet_count_, 0);
    take(place, rest);
  }
}

void CellWriter::append_sheets(uint16_t cell) {
  const bool own_inside = copy_count_ > 0 && copies_[copy_count_ - 1].sheet == sheet_count_;
  const uint32_t end = static_cast<uint32_t>(sheets_.vertices.size());
  for (uint32_t s = 0; s < sheet_count_ + (own_inside ? 1 : 0); ++s) {
    Sheet sheet;
    sheet.cell = cell;
    sheet.only_inside = s == sheet_count_;
    sheet.first_vertex = sheet.only_inside ? end : first_vertex_[s];
    if (!sheet.only_inside) std::ranges::copy(near_[s], sheet.near);
    sheets_.sheets.push_back(sheet);
    if (!solid_) continue;
    SheetMasks masks;
    for (uint32_t c = 0; c < copy_count_; ++c) {
      if (copies_[c].sheet != s) continue;
      for (int i = 0; i < 8; ++i) masks.all[i] |= copies_[c].voxels.masks[i];
    }
    for (const VoxelFragment& v : inside_) {
      const uint32_t code = cell_order().code[v.voxel & 511];
      masks.inside[code >> 6] |= masks.all[code >> 6] & uint64_t{1} << (code & 63);
    }
    sheets_.masks.push_back(masks);
  }
}

void CellWriter::append_copies(uint16_t cell) {
  const uint32_t first_sheet = sheets_.first_sheet[cell];
  for (uint32_t c = 0; c < copy_count_; ++c) {
    const Copy& copy = copies_[c];
    const bool any = std::ranges::any_of(copy.voxels.masks, [](uint64_t m) { return m != 0; });
    if (!any) continue;  // another material got all of its voxels
    append_cell(copy.voxels, cell_order().place[cell], copy.material, part_);
    sheets_.sheet_of_copy.push_back(first_sheet + copy.sheet);
  }
}

void CellWriter::write(std::span<const VoxelFragment> fragments) {
  sheet_count_ = finder_.find(fragments, sheets_, first_vertex_);
  find_copies();
  for (uint32_t s = 0; s < sheet_count_; ++s) near_voxels_[s] = {};
  inside_.clear();
  for (size_t begin = 0; begin < fragments.size();) {
    size_t end = begin + 1;
    while (end < fragments.size() && fragments[end].voxel == fragments[begin].voxel) ++end;
    add_voxel(fragments.subspan(begin, end - begin), begin);
    begin = end;
  }
  find_near(fragments);
  if (!inside_.empty()) fill_inside();
  const auto cell = static_cast<uint16_t>(fragments.front().voxel >> 9 & 511);
  append_sheets(cell);
  append_copies(cell);
}

}  // namespace

void make_sheets(const LatticeSource& source, std::span<const VoxelFragment> fragments, bool solid,
                 BlockSheets& sheets, BlockPart& part) {
  sheets.morton = part.morton = fragments.front().voxel >> 18;
  CellWriter writer(source, fragments.size(), solid, sheets, part);
  uint32_t next_cell = 0;
  while (!fragments.empty()) {
    const uint32_t cell = fragments.front().voxel >> 9 & 511;
    while (next_cell <= cell) {
      sheets.first_sheet[next_cell++] = static_cast<uint32_t>(sheets.sheets.size());
    }
    const size_t count = count_of_first(fragments, 9);
    writer.write(fragments.first(count));
    fragments = fragments.subspan(count);
  }
  while (next_cell <= 512) {
    sheets.first_sheet[next_cell++] = static_cast<uint32_t>(sheets.sheets.size());
  }
}

}  // namespace sinew
