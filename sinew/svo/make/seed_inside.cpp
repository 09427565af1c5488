// Cells deep in a solid have no triangle that could move them: they follow the surface nearest to
// them, as their neighbours tell them, layer by layer from the surface inwards.
#include <algorithm>

#include "sinew/base/parallel.h"
#include "sinew/svo/corners.h"
#include "sinew/svo/make/lattice.h"

namespace sinew {
namespace {

struct Seed {
  uint32_t block = 0, sheet = 0;
  SheetPoint near[8];
  bool found = false;
};

// Calls take(sheet) for each sheet of the six cells around one.
template <class Take>
void for_each_around(std::span<const BlockSheets> blocks, uint64_t cell, const Take& take) {
  const glm::ivec3 place(voxel_of(cell));
  for (int i = 0; i < 6; ++i) {
    glm::ivec3 at = place;
    at[i / 2] += i % 2 ? 1 : -1;
    if (at[i / 2] < 0) continue;
    const uint64_t morton = morton_of(uvec3(at));
    const auto found = std::ranges::lower_bound(blocks, morton >> 9, {}, &BlockSheets::morton);
    if (found == blocks.end() || found->morton != morton >> 9) continue;
    const uint32_t first = found->first_sheet[morton & 511];
    for (uint32_t s = first; s < found->first_sheet[(morton & 511) + 1]; ++s) {
      take(found->sheets[s]);
    }
  }
}

// Of all points that the neighbours know, for each corner the nearest.
void look_around(const LatticeSource& source, std::span<const BlockSheets> blocks, Seed& seed) {
  const BlockSheets& block = blocks[seed.block];
  const uint64_t cell = block.morton << 9 | block.sheets[seed.sheet].cell;
  const uvec3 place = voxel_of(cell);
  for_each_around(blocks, cell, [&](const Sheet& sheet) {
    for (const SheetPoint& point : sheet.near) {
      if (point.triangle == kInside) continue;
      seed.found = true;
      for (uint32_t k = 0; k < 8; ++k) {
        const vec3 corner = corner_rest(source.grid, place + uvec3(k & 1, k >> 1 & 1, k >> 2));
        const SheetPoint seen = seen_from(source, point, corner);
        if (nearer(seen, seed.near[k])) seed.near[k] = seen;
      }
    }
  });
}

void set_materials(const LatticeSource& source, const BlockSheets& block, BlockPart& part) {
  for (size_t c = 0; c < part.cells.size(); ++c) {
    const Sheet& sheet = block.sheets[block.sheet_of_copy[c]];
    if (!sheet.only_inside || sheet.near[0].triangle == kInside) continue;
    part.cells[c].material = source.materials[sheet.near[0].triangle];
  }
}

}  // namespace

void seed_inside(const LatticeSource& source, std::span<BlockSheets> blocks,
                 std::span<BlockPart> parts) {
  std::vector<Seed> waiting;
  for (uint32_t b = 0; b < blocks.size(); ++b) {
    for (uint32_t s = 0; s < blocks[b].sheets.size(); ++s) {
      if (blocks[b].sheets[s].only_inside) waiting.push_back({b, s, {}, false});
    }
  }
  while (!waiting.empty()) {
    parallel_for(waiting.size(), 64, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) look_around(source, blocks, waiting[i]);
    });
    for (const Seed& seed : waiting) {
      if (seed.found) std::ranges::copy(seed.near, blocks[seed.block].sheets[seed.sheet].near);
    }
    if (std::erase_if(waiting, [](const Seed& seed) { return seed.found; }) == 0) break;
  }
  for (size_t b = 0; b < blocks.size(); ++b) set_materials(source, blocks[b], parts[b]);
}

}  // namespace sinew
