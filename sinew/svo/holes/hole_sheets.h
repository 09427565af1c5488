// Whose a copy of a cell is: which triangles its sheet has. Found again from the voxeliser's
// fragments, by the definition and in the obvious way; nothing of make_svo's is shared.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/make/fragments.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {

class HoleSheets {
 public:
  // Of the octree that make_svo() made of `surface` and `source`. `rest`: the source's vertices.
  HoleSheets(const VoxelSurface& surface, const SvoSource& source, std::span<const vec3> rest,
             const Svo& svo);

  // Whether the triangle has a vertex in common with the copy's sheet: one that lies in the cell is
  // part of it then, and one beside it goes on there.
  bool owns(uint32_t cell, uint32_t triangle) const;

 private:
  struct CellSheet;
  void add_cell(std::span<const VoxelFragment> fragments, std::span<const uint32_t> copies);
  std::vector<CellSheet> find_sheets(std::span<const VoxelFragment> fragments) const;

  const SvoSource* source_;
  const Svo* svo_;
  std::vector<uint32_t> place_of_;             // of each vertex; equal for equal positions
  std::vector<std::vector<uint32_t>> places_;  // of each copy: of its sheet's vertices, rising
  std::vector<uint32_t> block_of_;             // of each copy
};

}  // namespace sinew
