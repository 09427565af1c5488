#include "sinew/svo/holes/hole_sheets.h"

#include <algorithm>
#include <bitset>
#include <map>
#include <tuple>

#include "sinew/svo/make/sheets.h"

namespace sinew {
namespace {

using CellVoxels = std::bitset<512>;  // x + 8 y + 64 z

uint32_t in_cell(uvec3 voxel) {
  const uvec3 at = voxel % kCellSide;
  return at.x + 8 * at.y + 64 * at.z;
}

CellVoxels voxels_of(const SvoCell& cell, const uint64_t* bricks) {
  CellVoxels out;
  for (uint32_t brick = 0; brick < 8; ++brick) {
    if (!(cell.bricks >> brick & 1)) continue;
    const uint64_t mask = *bricks++;
    for (uint32_t bit = 0; bit < 64; ++bit) {
      if (mask >> bit & 1) out.set(in_cell(place_of(64 * brick + bit).min));
    }
  }
  return out;
}

std::vector<uint32_t> equal_positions(std::span<const vec3> rest) {
  std::map<std::tuple<float, float, float>, uint32_t> found;
  std::vector<uint32_t> out;
  for (const vec3 p : rest) {
    const auto number = static_cast<uint32_t>(found.size());
    out.push_back(found.emplace(std::tuple(p.x, p.y, p.z), number).first->second);
  }
  return out;
}

}  // namespace

struct HoleSheets::CellSheet {
  std::vector<uint32_t> places;  // of vertices, rising
  std::vector<uint16_t> materials;
  CellVoxels voxels;
  std::vector<uint16_t> taken;  // materials that have a copy already
};

HoleSheets::HoleSheets(const VoxelSurface& surface, const SvoSource& source,
                       std::span<const vec3> rest, const Svo& svo)
    : source_(&source), svo_(&svo), place_of_(equal_positions(rest)), places_(svo.cells.size()) {
  std::map<VoxelMorton, std::vector<uint32_t>> copies;  // by cell
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    for (uint32_t c = block.first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      const uint32_t place = svo.cells[c].place;
      const uvec3 cell =
          8u * uvec3(block.x, block.y, block.z) + uvec3(place & 7, place >> 3 & 7, place >> 6);
      copies[morton_of(cell)].push_back(c);
      block_of_.push_back(b);
    }
  }
  const std::span<const VoxelFragment> all = surface.fragments;
  for (size_t begin = 0; begin < all.size();) {
    size_t end = begin;
    while (end < all.size() && all[end].voxel >> 9 == all[begin].voxel >> 9) ++end;
    add_cell(all.subspan(begin, end - begin), copies[all[begin].voxel >> 9]);
    begin = end;
  }
}

// Triangles of the cell that are connected by vertices; in the order of their first fragments.
std::vector<HoleSheets::CellSheet> HoleSheets::find_sheets(
    std::span<const VoxelFragment> fragments) const {
  std::map<uint32_t, uint32_t> parent;  // of places
  const auto root = [&](uint32_t p) {
    while (parent.at(p) != p) p = parent.at(p);
    return p;
  };
  const auto place = [&](uint32_t triangle, int k) {
    return place_of_[source_->triangles[triangle][k]];
  };
  for (const VoxelFragment& f : fragments) {
    if (f.triangle == kInside) continue;
    for (int k = 0; k < 3; ++k) parent.emplace(place(f.triangle, k), place(f.triangle, k));
    for (int k = 1; k < 3; ++k) parent[root(place(f.triangle, k))] = root(place(f.triangle, 0));
  }
  std::map<uint32_t, size_t> sheet_of;  // by root
  std::vector<CellSheet> sheets;
  for (const VoxelFragment& f : fragments) {
    if (f.triangle == kInside) continue;
    const auto added = sheet_of.emplace(root(place(f.triangle, 0)), sheets.size());
    if (added.second) sheets.emplace_back();
    CellSheet& sheet = sheets[added.first->second];
    sheet.voxels.set(in_cell(voxel_of(f.voxel)));
    sheet.materials.push_back(source_->materials.empty() ? 0 : source_->materials[f.triangle]);
  }
  for (const auto& [p, unused] : parent) sheets[sheet_of.at(root(p))].places.push_back(p);
  if (sheets.size() <= kMostSheets) return sheets;
  CellSheet one;  // so many are taken as one
  for (const auto& [p, unused] : parent) one.places.push_back(p);
  for (const CellSheet& sheet : sheets) {
    one.voxels |= sheet.voxels;
    one.materials.insert(one.materials.end(), sheet.materials.begin(), sheet.materials.end());
  }
  return {one};
}

// A copy is that of the sheet which has its material and whose voxels are most like its own.
void HoleSheets::add_cell(std::span<const VoxelFragment> fragments,
                          std::span<const uint32_t> copies) {
  std::vector<CellSheet> sheets = find_sheets(fragments);
  for (const uint32_t c : copies) {
    const SvoCell& copy = svo_->cells[c];
    const size_t first = svo_->blocks[block_of_[c]].first_brick + copy.first_brick;
    const CellVoxels voxels = voxels_of(copy, &svo_->bricks[first]);
    CellSheet* best = nullptr;
    size_t least = 0;
    for (CellSheet& sheet : sheets) {
      if (std::ranges::find(sheet.materials, copy.material) == sheet.materials.end()) continue;
      if (std::ranges::find(sheet.taken, copy.material) != sheet.taken.end()) continue;
      const size_t surplus = (voxels & ~sheet.voxels).count();  // none but in solid filling
      const size_t unlike = 512 * surplus + (sheet.voxels & ~voxels).count();
      if (best != nullptr && unlike >= least) continue;
      best = &sheet;
      least = unlike;
    }
    if (best == nullptr) continue;
    best->taken.push_back(copy.material);
    places_[c] = best->places;
  }
}

bool HoleSheets::owns(uint32_t cell, uint32_t triangle) const {
  for (int k = 0; k < 3; ++k) {
    const uint32_t place = place_of_[source_->triangles[triangle][k]];
    if (std::ranges::binary_search(places_[cell], place)) return true;
  }
  return false;
}

}  // namespace sinew
