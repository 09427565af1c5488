// Boxes of hulls on the screen, and other small arithmetic of the rasteriser.
#include "sinew/svo/draw/rasterize_view.h"

#include <limits>

#include "sinew/svo/draw/rasterize_kernels.h"

namespace sinew {
namespace {

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

SeenPoints seen_points(const ClipPoint corners[8], float near, bool perspective) {
  SeenPoints out;
  for (int i = 0; i < 8; ++i) {
    const ClipPoint& a = corners[i];
    if (!(a.depth > near)) continue;
    out.add(a.x, a.y, a.depth, perspective);
    for (int k = 0; k < 8; ++k) {
      const ClipPoint& b = corners[k];
      if (!(b.depth <= near)) continue;
      const double t = (double{near} - a.depth) / (double{b.depth} - a.depth);
      out.add(a.x + t * (double{b.x} - a.x), a.y + t * (double{b.y} - a.y), near, perspective);
    }
  }
  return out;
}

ClipMap map_of(const RasterView& view, const Affine& placement) {
  return {compose(view.x, placement), compose(view.y, placement), compose(view.depth, placement),
          view.near, is_perspective(view)};
}

double point_pad(double farthest, double depth, bool perspective, float reach, float depth_reach) {
  const double terms = reach + (perspective ? farthest * depth_reach : 0.0);
  return double{kRasterGamma} * (terms * (perspective ? 1.0 / depth : 1.0) + farthest);
}

ScreenBox project_hull(const ClipPoint corners[8], float near, bool perspective,
                       const float reach[3]) {
  const SeenPoints points = seen_points(corners, near, perspective);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};
  for (uint32_t k = 0; k < points.count; ++k) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], points.at[k][i]);
      high[i] = std::max(high[i], points.at[k][i]);
    }
  }
  if (!(low[2] <= high[2])) return {};
  for (int i = 0; i < 2; ++i) {
    const double most = std::max(std::abs(low[i]), std::abs(high[i]));
    const double pad = point_pad(most, low[2], perspective, reach[i], reach[2]);
    if (!(pad > kWidePad)) {
      low[i] -= pad;
      high[i] += pad;
      continue;
    }
    for (uint32_t k = 0; k < points.count; ++k) {
      const double at = points.at[k][i];
      const double own = point_pad(std::abs(at), points.at[k][2], perspective, reach[i], reach[2]);
      low[i] = std::min(low[i], at - own);
      high[i] = std::max(high[i], at + own);
    }
  }
  // Depths above near, even if the hull begins there.
  const float beyond = std::nextafter(near, std::numeric_limits<float>::infinity());
  return {static_cast<float>(low[0]),
          static_cast<float>(low[1]),
          static_cast<float>(high[0]),
          static_cast<float>(high[1]),
          std::max(static_cast<float>(low[2]), beyond),
          std::max(static_cast<float>(high[2]), beyond)};
}

bool misses(const ClipPoint corners[8], bool perspective, const float reach[3],
            const SideLines& lines) {
  // Along each axis, signed: the picture's lower side, then the upper one.
  for (int side = 0; side < 4; ++side) {
    const int axis = side >> 1;
    const double line = axis == 0 ? ((side & 1) != 0 ? lines.x1 : lines.x0)
                                  : ((side & 1) != 0 ? lines.y1 : lines.y0);
    const double sign = (side & 1) != 0 ? -1.0 : 1.0;
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < 8; ++i) {
      const double at = axis == 0 ? corners[i].x : corners[i].y;
      const double w = perspective ? corners[i].depth : 1.0;
      most = std::max(most, sign * (at - line * w));
    }
    const double w_reach = perspective ? reach[2] : 1.0;
    if (most < -2.0 * double{kRasterGamma} * (reach[axis] + std::abs(line) * w_reach)) return true;
  }
  return false;
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
