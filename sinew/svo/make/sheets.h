// Sheets: within a cell, triangles that are connected there by common vertices. Cells get a copy
// for each sheet and material, so that what lies near but belongs elsewhere moves on its own.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/make/block_part.h"
#include "sinew/svo/make/lattice_source.h"

namespace sinew {

// Where a cell has more, all its triangles are one sheet: such are soups and hair, of which no cell
// of 8^3 voxels can tell the strands. So the corners of a block, 8 a sheet at most, can be counted
// in 16 bits.
inline constexpr uint32_t kMostSheets = 15;

// Voxels of a sheet by VoxelCode, for solid filling.
struct SheetMasks {
  std::array<uint64_t, 8> all = {};
  std::array<uint64_t, 8> inside = {};
};

struct Sheet {
  SheetPoint near[8];         // of the sheet, to the cell's corners
  uint32_t first_vertex = 0;  // in BlockSheets::vertices
  uint16_t cell = 0;          // Morton code within the block
  bool only_inside = false;   // no triangles: solid filling
};

struct BlockSheets {
  uint64_t morton = 0;                    // of the block
  std::vector<Sheet> sheets;              // by cells in Morton order
  std::vector<SheetMasks> masks;          // one a sheet; empty without solid filling
  std::vector<uint32_t> vertices;         // of each sheet, each once: numbers within the block
  std::vector<uint64_t> keys;             // by number, see vertex_key
  std::vector<uint32_t> sheet_of_copy;    // one a cell of the BlockPart
  std::array<uint32_t, 513> first_sheet;  // by the Morton code of a cell

  std::span<const uint32_t> vertices_of(size_t sheet) const {
    const size_t end = sheet + 1 < sheets.size() ? sheets[sheet + 1].first_vertex : vertices.size();
    return std::span(vertices).subspan(sheets[sheet].first_vertex,
                                       end - sheets[sheet].first_vertex);
  }
};

// Cuts the fragments of one block into sheets, and writes its cells without their corners. `solid`:
// whether any fragment of the surface is kInside.
void make_sheets(const LatticeSource& source, std::span<const VoxelFragment> fragments, bool solid,
                 BlockSheets& sheets, BlockPart& part);

}  // namespace sinew
