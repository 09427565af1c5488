#include "sinew/svo/make/cell_sheets.h"

#include <algorithm>

namespace sinew {

uint32_t SheetFinder::local_triangle(uint32_t triangle, BlockSheets& sheets) {
  const uint32_t local = triangles_.number(triangle);
  if (local < local_.size()) return local;
  Triangle t;
  for (int k = 0; k < 3; ++k) {
    const uint64_t key = vertex_key(source_, source_.triangles[triangle][k]);
    t.vertices[k] = vertices_.number(key);
    if (t.vertices[k] < vertex_.size()) continue;
    vertex_.emplace_back();
    sheets.keys.push_back(key);
  }
  local_.push_back(t);
  return local;
}

void SheetFinder::touch(uint32_t vertex) {
  if (vertex_[vertex].cell == cell_) return;
  vertex_[vertex] = {cell_, vertex, kInside};
  cell_vertices_.push_back(vertex);
}

uint32_t SheetFinder::root(uint32_t vertex) {
  while (vertex_[vertex].parent != vertex) {
    vertex = vertex_[vertex].parent = vertex_[vertex_[vertex].parent].parent;
  }
  return vertex;
}

void SheetFinder::unite(uint32_t a, uint32_t b) {
  a = root(a);
  b = root(b);
  if (a != b) vertex_[std::max(a, b)].parent = std::min(a, b);
}

// In the order of the triangles.
uint32_t SheetFinder::number_sheets() {
  uint32_t count = 0;
  for (CellTriangle& t : cell_triangles_) {
    uint32_t& sheet = vertex_[root(local_[t.local].vertices[0])].sheet;
    if (sheet == kInside) sheet = count++;
    t.sheet = sheet;
  }
  if (count <= kMostSheets) return count;
  for (CellTriangle& t : cell_triangles_) t.sheet = 0;
  for (const uint32_t v : cell_vertices_) vertex_[root(v)].sheet = 0;
  return 1;
}

void SheetFinder::list_vertices(uint32_t count, BlockSheets& sheets,
                                std::vector<uint32_t>& first_vertex) {
  for (uint32_t sheet = 0; sheet < count; ++sheet) {
    first_vertex.push_back(static_cast<uint32_t>(sheets.vertices.size()));
    for (const uint32_t v : cell_vertices_) {
      if (count == 1 || vertex_[root(v)].sheet == sheet) sheets.vertices.push_back(v);
    }
  }
}

uint32_t SheetFinder::find(std::span<const VoxelFragment> fragments, BlockSheets& sheets,
                           std::vector<uint32_t>& first_vertex) {
  ++cell_;
  cell_triangles_.clear();
  cell_vertices_.clear();
  of_fragments_.clear();
  first_vertex.clear();
  for (const VoxelFragment& fragment : fragments) {
    if (fragment.triangle == kInside) {
      of_fragments_.push_back(kInside);
      continue;
    }
    const uint32_t local = local_triangle(fragment.triangle, sheets);
    Triangle& t = local_[local];
    if (t.cell != cell_) {
      t.cell = cell_;
      t.place = static_cast<uint32_t>(cell_triangles_.size());
      cell_triangles_.push_back({fragment.triangle, local, 0});
      for (const uint32_t v : t.vertices) touch(v);
      unite(t.vertices[0], t.vertices[1]);
      unite(t.vertices[0], t.vertices[2]);
    }
    of_fragments_.push_back(t.place);
  }
  const uint32_t count = number_sheets();
  list_vertices(count, sheets, first_vertex);
  return count;
}

}  // namespace sinew
