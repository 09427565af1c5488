// Points of a square grid as structure of arrays, and coarse grids over it. Internal to the cloth.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

// (cells + 1)^2 points, row by row.
struct GridPoints {
  uint32_t cells = 0;
  std::vector<float> x, y, z;

  GridPoints() = default;
  explicit GridPoints(uint32_t cells_a_side)
      : cells(cells_a_side), x(size()), y(size()), z(size()) {}

  uint32_t columns() const { return cells + 1; }
  size_t size() const { return size_t{columns()} * columns(); }
  vec3 at(size_t i) const { return {x[i], y[i], z[i]}; }
  void set(size_t i, vec3 p) {
    x[i] = p.x;
    y[i] = p.y;
    z[i] = p.z;
  }
};

// Every fourth point or so of a finer grid. Its links only hold: two points of a sheet never get
// farther from each other than the sheet allows, but they may get nearer.
class CoarseGrid {
 public:
  // `places` are the distances of the finer grid's columns from its first, in metres.
  explicit CoarseGrid(const std::vector<float>& places);

  const std::vector<float>& places() const { return places_; }

  // Takes this grid's points from the finer grid; `tighten` them with links() and the grids beyond;
  // then the finer points follow, bilinearly.
  template <class Tighten>
  void correct(GridPoints& finer, const Tighten& tighten) {
    gather(finer);
    tighten(points_);
    for (int sweep = 0; sweep < 2; ++sweep) links();
    spread(finer);
  }

 private:
  void gather(const GridPoints& finer);
  void links();
  void link(glm::uvec2 a, glm::uvec2 b, float rest_squared);  // (column, row)
  void spread(GridPoints& finer) const;

  std::vector<uint32_t> picked_;  // the finer column of each of our columns
  std::vector<float> places_;     // metres
  std::vector<float> widths_;     // metres of cloth that each of our columns stands for
  std::vector<uint32_t> cell_;    // of each finer column: our column before it
  std::vector<float> share_;      // and how far it is to the next, 0 to 1
  GridPoints points_, before_;
};

}  // namespace sinew
