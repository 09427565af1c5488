#include "sinew/scene/procedural/cloth_grid.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"

namespace sinew {

CoarseGrid::CoarseGrid(const std::vector<float>& places) {
  const auto finer_cells = static_cast<uint32_t>(places.size() - 1);
  const uint32_t cells = std::max(1u, (finer_cells + 2) / 4);
  for (uint32_t k = 0; k <= cells; ++k) {
    picked_.push_back((k * finer_cells + cells / 2) / cells);
    places_.push_back(places[picked_[k]]);
  }
  uint32_t k = 0;
  for (uint32_t i = 0; i <= finer_cells; ++i) {
    if (k + 1 < cells && i >= picked_[k + 1]) ++k;
    cell_.push_back(k);
    share_.push_back((places[i] - places_[k]) / (places_[k + 1] - places_[k]));
  }
  for (uint32_t c = 0; c <= cells; ++c) {
    widths_.push_back(0.5f * (places_[std::min(c + 1, cells)] - places_[c == 0 ? 0 : c - 1]));
  }
  points_ = GridPoints(cells);
}

void CoarseGrid::gather(const GridPoints& finer) {
  size_t next = 0;
  for (const uint32_t row : picked_) {
    for (const uint32_t column : picked_) {
      points_.set(next++, finer.at(size_t{row} * finer.columns() + column));
    }
  }
  before_ = points_;
}

void CoarseGrid::link(glm::uvec2 a, glm::uvec2 b, float rest_squared) {
  const size_t i = size_t{a.y} * points_.columns() + a.x, j = size_t{b.y} * points_.columns() + b.x;
  const vec3 p = points_.at(i), q = points_.at(j), d = q - p;
  const float squared = dot(d, d);
  if (squared <= rest_squared) return;
  const vec3 pull = (1.0f - 2.0f * rest_squared / (squared + rest_squared)) * d;
  // A point stands for a part of the cloth; the lighter of two moves farther.
  const float mass_a = widths_[a.x] * widths_[a.y], mass_b = widths_[b.x] * widths_[b.y];
  const float share = mass_b / (mass_a + mass_b);
  points_.set(i, p + share * pull);
  points_.set(j, q - (1.0f - share) * pull);
}

void CoarseGrid::links() {
  const uint32_t cells = points_.cells;
  for (uint32_t r = 0; r <= cells; ++r) {
    for (uint32_t c = 0; c <= cells; ++c) {
      const float right = c < cells ? places_[c + 1] - places_[c] : 0.0f;
      const float down = r < cells ? places_[r + 1] - places_[r] : 0.0f;
      if (c < cells) link({c, r}, {c + 1, r}, right * right);
      if (r < cells) link({c, r}, {c, r + 1}, down * down);
      if (c < cells && r < cells) {
        link({c, r}, {c + 1, r + 1}, right * right + down * down);
        link({c + 1, r}, {c, r + 1}, right * right + down * down);
      }
    }
  }
}

void CoarseGrid::spread(GridPoints& finer) const {
  const uint32_t columns = points_.columns();
  parallel_for(finer.columns(), 16, [&](size_t begin, size_t end) {
    std::vector<vec3> moved(columns);  // of our columns, at the finer row
    for (size_t r = begin; r < end; ++r) {
      const size_t above = size_t{cell_[r]} * columns;
      for (uint32_t c = 0; c < columns; ++c) {
        const vec3 a = points_.at(above + c) - before_.at(above + c);
        const vec3 b = points_.at(above + columns + c) - before_.at(above + columns + c);
        moved[c] = a + share_[r] * (b - a);
      }
      for (uint32_t c = 0; c < finer.columns(); ++c) {
        const size_t i = r * finer.columns() + c;
        const vec3 a = moved[cell_[c]], b = moved[cell_[c] + 1];
        finer.set(i, finer.at(i) + a + share_[c] * (b - a));
      }
    }
  });
}

}  // namespace sinew
