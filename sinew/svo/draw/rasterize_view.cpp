// Boxes of hulls on the screen, and other small arithmetic of the rasteriser.
#include "sinew/svo/draw/rasterize_view.h"

#include <limits>

#include "sinew/svo/draw/rasterize_kernels.h"

namespace sinew {
namespace {

struct Extent {
  double low[3], high[3];

  Extent() {
    std::fill_n(low, 3, std::numeric_limits<double>::infinity());
    std::fill_n(high, 3, -std::numeric_limits<double>::infinity());
  }
  void extend(double x, double y, double depth, bool perspective) {
    const double scale = perspective ? 1.0 / depth : 1.0;
    const double at[3] = {x * scale, y * scale, depth};
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], at[i]);
      high[i] = std::max(high[i], at[i]);
    }
  }
};

ClipPoint lerp(const ClipPoint& a, const ClipPoint& b, float t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.depth + t * (b.depth - a.depth), 0.0f};
}

vec4 compose(vec4 row, const Affine& placement) {
  const glm::dvec3 direction(row);
  const auto along = [&](int axis) {
    return static_cast<float>(dot(direction, glm::dvec3(placement[axis])));
  };
  const double constant = dot(direction, glm::dvec3(placement[3])) + double{row.w};
  return vec4(along(0), along(1), along(2), static_cast<float>(constant));
}

}  // namespace

ClipMap map_of(const RasterView& view, const Affine& placement) {
  return {compose(view.x, placement), compose(view.y, placement), compose(view.depth, placement),
          view.near, is_perspective(view)};
}

ScreenBox project_hull(const ClipPoint corners[8], float near, bool perspective,
                       const float reach[3]) {
  Extent box;
  for (int i = 0; i < 8; ++i) {
    const ClipPoint& a = corners[i];
    if (a.depth > near) box.extend(a.x, a.y, a.depth, perspective);
    // Where the hull's edges, and lines within it, meet the near plane.
    for (int k = 0; k < 8; ++k) {
      const ClipPoint& b = corners[k];
      if (!(a.depth > near) || !(b.depth <= near)) continue;
      const double t = (double{near} - a.depth) / (double{b.depth} - a.depth);
      box.extend(a.x + t * (double{b.x} - a.x), a.y + t * (double{b.y} - a.y), near, perspective);
    }
  }
  if (!(box.low[2] <= box.high[2])) return {};
  const double scale = perspective ? 1.0 / box.low[2] : 1.0;
  double pad[2];
  for (int i = 0; i < 2; ++i) {
    const double most = std::max(std::abs(box.low[i]), std::abs(box.high[i]));
    const double terms = reach[i] + (perspective ? most * reach[2] : 0.0);
    pad[i] = double{kRasterGamma} * (terms * scale + most);
  }
  // Depths above near, even if the hull begins there.
  const float beyond = std::nextafter(near, std::numeric_limits<float>::infinity());
  return {static_cast<float>(box.low[0] - pad[0]),
          static_cast<float>(box.low[1] - pad[1]),
          static_cast<float>(box.high[0] + pad[0]),
          static_cast<float>(box.high[1] + pad[1]),
          std::max(static_cast<float>(box.low[2]), beyond),
          std::max(static_cast<float>(box.high[2]), beyond)};
}

void voxel_corners(const ClipPoint* points, const SvoCell& cell, VoxelCode code, ClipPoint out[8]) {
  const VoxelPlace place = place_of(code);
  const vec3 first = vec3(place.min) / static_cast<float>(kCellSide);
  const float side = static_cast<float>(place.side) / static_cast<float>(kCellSide);
  for (int i = 0; i < 8; ++i) {
    const vec3 t = first + side * vec3(i & 1, i >> 1 & 1, i >> 2);
    ClipPoint x[4];
    for (int k = 0; k < 4; ++k) {
      x[k] = lerp(points[cell.corner[2 * k]], points[cell.corner[2 * k + 1]], t.x);
    }
    out[i] = lerp(lerp(x[0], x[1], t.y), lerp(x[2], x[3], t.y), t.z);
  }
}

void sort_front_to_back(const TileJob& job, uint32_t first, uint32_t second) {
  const auto nearer = [&](uint32_t a, uint32_t b) {
    const float da = job.cells[job.list[a]].near_depth, db = job.cells[job.list[b]].near_depth;
    return da != db ? da < db : a < b;
  };
  std::sort(job.order, job.order + first, nearer);
  std::sort(job.order + second, job.order + job.count, nearer);
}

void add(const RasterStats& stats, RasterStats& sum) {
  sum.blocks += stats.blocks;
  sum.blocks_drawn += stats.blocks_drawn;
  sum.cells += stats.cells;
  sum.cells_hidden += stats.cells_hidden;
  sum.voxels_drawn += stats.voxels_drawn;
  sum.leaves_drawn += stats.leaves_drawn;
  sum.nodes_drawn += stats.nodes_drawn;
  sum.pose_ms += stats.pose_ms;
  sum.view_ms += stats.view_ms;
  sum.draw_ms += stats.draw_ms;
}

}  // namespace sinew
