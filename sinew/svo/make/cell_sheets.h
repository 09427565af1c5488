// The sheets of one cell after the other; scratch that a block's cells share.
#pragma once

#include <span>
#include <vector>

#include "sinew/svo/make/key_table.h"
#include "sinew/svo/make/sheets.h"

namespace sinew {

// Which sheet each triangle of a cell is in.
class SheetFinder {
 public:
  SheetFinder(const LatticeSource& source, size_t fragments)
      : source_(source), triangles_(fragments / 4), vertices_(fragments / 4) {}

  // Finds the sheets of a cell; `fragments` are the cell's. Appends its vertices, sheet by sheet,
  // to sheets.vertices and where each begins to `first_vertex`. Returns how many sheets there are.
  uint32_t find(std::span<const VoxelFragment> fragments, BlockSheets& sheets,
                std::vector<uint32_t>& first_vertex);

  // Triangles that the cell has, numbered as they come.
  struct CellTriangle {
    uint32_t triangle = 0;
    uint32_t local = 0;  // within the block
    uint32_t sheet = 0;
  };
  std::span<const CellTriangle> triangles() const { return cell_triangles_; }
  // Of the cell's fragments: indices into triangles(), or kInside.
  std::span<const uint32_t> of_fragments() const { return of_fragments_; }

 private:
  struct Triangle {
    uint32_t vertices[3] = {};
    uint32_t cell = 0;   // the last one that met it
    uint32_t place = 0;  // in cell_triangles_
  };
  struct Vertex {
    uint32_t cell = 0;
    uint32_t parent = 0;
    uint32_t sheet = 0;
  };

  uint32_t local_triangle(uint32_t triangle, BlockSheets& sheets);
  void touch(uint32_t vertex);
  uint32_t root(uint32_t vertex);
  void unite(uint32_t a, uint32_t b);
  uint32_t number_sheets();
  void list_vertices(uint32_t count, BlockSheets& sheets, std::vector<uint32_t>& first_vertex);

  const LatticeSource& source_;
  uint32_t cell_ = 0;  // counts cells
  KeyTable triangles_, vertices_;
  std::vector<Triangle> local_;
  std::vector<Vertex> vertex_;
  std::vector<CellTriangle> cell_triangles_;
  std::vector<uint32_t> cell_vertices_;
  std::vector<uint32_t> of_fragments_;
};

}  // namespace sinew
