// The slow obvious twin of the rasteriser: voxel by voxel, in double. And bodies to draw.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/svo/draw/rasterize.h"
#include "sinew/svo/voxel_at.h"
#include "svo/svo_oracle.h"

namespace sinew::test {

using glm::dvec3;

// Moves the lattice's corners by a morph target of its own: delta(corner), of at most `most` along
// each axis; the corner counted over the whole grid.
template <class F>
void bend(Svo& svo, float most, const F& delta) {
  svo.morph_targets = 1;
  svo.morph_weights = {1.0f};
  const float unit = most / 32767.0f;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    SvoBlock& block = svo.blocks[b];
    block.first_target = b;
    svo.targets.push_back({0, unit, static_cast<uint32_t>(svo.deltas.size())});
    for (uint32_t c = block.first_corner; c < svo.blocks[b + 1].first_corner; ++c) {
      const uint32_t place = svo.corner_places[c];
      const vec3 d = delta(8u * uvec3(block.x, block.y, block.z) +
                           uvec3(place % 9, place / 9 % 9, place / 81));
      const vec3 steps = glm::clamp(d / unit, vec3(-32767.0f), vec3(32767.0f));
      svo.deltas.push_back({static_cast<int16_t>(steps.x), static_cast<int16_t>(steps.y),
                            static_cast<int16_t>(steps.z)});
    }
  }
  svo.blocks.back().first_target = svo.block_count();
}

// An octree, bent by random numbers if `fold` is not 0: corners move by up to that many cells.
struct RasterBody {
  Svo svo;
  SvoMotion motion;
  PosedSvo posed;
  float weight = 1.0f;

  RasterBody(const VoxelGrid& grid, const std::vector<PlainVoxel>& voxels, float fold = 0.0f,
             uint32_t seed = 1)
      : svo(*make_svo(grid, voxels)) {
    const float most = fold * grid.voxel * static_cast<float>(kCellSide);
    if (fold > 0.0f) {
      bend(svo, most, [&](uvec3 c) {
        return Random(seed + c.x + 1000 * c.y + 1000000 * c.z).uniform3(-most, most);
      });
    }
    motion = make_svo_motion(svo);
    pose();
  }
  RasterBody(const RasterBody&) = delete;
  void pose() {
    Pose now;
    if (svo.morph_targets > 0) now.weights = std::span(&weight, 1);
    posed.set_pose(motion, now);
  }
};

// Looks from `eye` at `at`; `scale`: pixels of something of size 1 at distance 1, or everywhere.
inline RasterView look_at(vec3 eye, vec3 at, float scale, uint32_t width, uint32_t height,
                          float near, bool perspective = true) {
  const vec3 forward = normalize(at - eye), right = normalize(cross(forward, vec3(0.1f, 1, 0.2f)));
  const vec3 down = cross(forward, right);
  const auto row = [&](vec3 axis) { return vec4(axis, -dot(axis, eye)); };
  const vec2 middle = 0.5f * vec2(width, height);
  RasterView view;
  view.near = near;
  view.width = width;
  view.height = height;
  view.depth = row(forward);
  view.w = perspective ? view.depth : vec4(0, 0, 0, 1);
  view.x = scale * row(right) + middle.x * view.w;
  view.y = scale * row(down) + middle.y * view.w;
  return view;
}

// Where something is on the screen.
struct ScreenPoint {
  double x = 0.0, y = 0.0, depth = 0.0;
};
inline ScreenPoint to_screen(const RasterView& view, const Affine& placement, dvec3 p) {
  const dvec3 w = dvec3(placement[0]) * p.x + dvec3(placement[1]) * p.y +
                  dvec3(placement[2]) * p.z + dvec3(placement[3]);
  const auto at = [&](const vec4& f) { return dot(dvec3(f), w) + double{f.w}; };
  return {at(view.x) / at(view.w), at(view.y) / at(view.w), at(view.depth)};
}

// The lattice's map in double, `at` in voxels of the cell.
inline dvec3 lattice_point(const SvoCell& cell, const PosedBlock& block, dvec3 at) {
  dvec3 sum(0.0);
  for (int i = 0; i < 8; ++i) {
    dvec3 w = at / double{kCellSide};
    for (int axis = 0; axis < 3; ++axis) w[axis] = i >> axis & 1 ? w[axis] : 1.0 - w[axis];
    sum += w.x * w.y * w.z * dvec3(block.positions[cell.corner[i]]);
  }
  return sum;
}

// A voxel on the screen: the box of its eight corners, and its middle.
struct ScreenVoxel {
  double x0 = std::numeric_limits<double>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;
  double nearest = x0;  // of the corners
  ScreenPoint middle;
};
inline ScreenVoxel voxel_on_screen(const RasterView& view, const VoxelInstance& body,
                                   const ReadVoxel& voxel) {
  const SvoCell& cell = body.posed->svo().cells[voxel.cell];
  const PosedBlock block = body.posed->block(voxel.block);
  const dvec3 min(place_of(voxel.code).min);
  ScreenVoxel out;
  for (int i = 0; i < 8; ++i) {
    const dvec3 corner = min + dvec3(i & 1, i >> 1 & 1, i >> 2);
    const ScreenPoint p = to_screen(view, body.placement, lattice_point(cell, block, corner));
    out.x0 = std::min(out.x0, p.x);
    out.x1 = std::max(out.x1, p.x);
    out.y0 = std::min(out.y0, p.y);
    out.y1 = std::max(out.y1, p.y);
    out.nearest = std::min(out.nearest, p.depth);
  }
  out.middle = to_screen(view, body.placement, lattice_point(cell, block, min + 0.5));
  return out;
}

// Whether (x, y) is in the convex hull of the points: no half-plane at it is free of them.
inline bool in_hull(const std::vector<ScreenPoint>& points, double x, double y) {
  std::vector<double> angles;
  for (const ScreenPoint& p : points) angles.push_back(std::atan2(p.y - y, p.x - x));
  if (angles.empty()) return false;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * M_PI - angles.back();
  for (size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap < M_PI;
}

// Whether (x, y) is within about `reach` pixels of the hull.
inline bool near_hull(const std::vector<ScreenPoint>& points, double x, double y, double reach) {
  for (int i = 0; i < 9; ++i) {
    if (in_hull(points, x + (i % 3 - 1) * reach, y + (i / 3 - 1) * reach)) return true;
  }
  return false;
}

// Points of a voxel beyond the near plane, `steps` + 1 along each axis.
inline std::vector<ScreenPoint> points_of(const RasterView& view, const VoxelInstance& body,
                                          const ReadVoxel& voxel, int steps) {
  const SvoCell& cell = body.posed->svo().cells[voxel.cell];
  const PosedBlock block = body.posed->block(voxel.block);
  std::vector<ScreenPoint> out;
  for (int x = 0; x <= steps; ++x) {
    for (int y = 0; y <= steps; ++y) {
      for (int z = 0; z <= steps; ++z) {
        const dvec3 at = dvec3(place_of(voxel.code).min) + dvec3(x, y, z) / double(steps);
        const ScreenPoint p = to_screen(view, body.placement, lattice_point(cell, block, at));
        if (p.depth > view.near) out.push_back(p);
      }
    }
  }
  return out;
}

// The corners of the voxel's hull as it is drawn, and where lines between them meet the near plane.
inline std::vector<ScreenPoint> hull_of(const RasterView& view, const VoxelInstance& body,
                                        uint32_t c, VoxelCode code) {
  const SvoCell& cell = body.posed->svo().cells[c];
  const PosedBlock block = body.posed->block(block_of(body.posed->svo(), c));
  const VoxelPlace place = place_of(code);
  const dvec3 min(place.min);
  dvec3 rows[8];  // x, y, depth: linear in space
  for (int i = 0; i < 8; ++i) {
    const dvec3 local = min + double(place.side) * dvec3(i & 1, i >> 1 & 1, i >> 2);
    const dvec3 p = lattice_point(cell, block, local);
    const dvec3 w = dvec3(body.placement[0]) * p.x + dvec3(body.placement[1]) * p.y +
                    dvec3(body.placement[2]) * p.z + dvec3(body.placement[3]);
    const auto at = [&](const vec4& f) { return dot(dvec3(f), w) + double{f.w}; };
    rows[i] = dvec3(at(view.x), at(view.y), at(view.depth));
  }
  const bool perspective = view.w == view.depth;
  std::vector<ScreenPoint> out;
  const auto add = [&](const dvec3& r) {
    const double scale = perspective ? 1.0 / r.z : 1.0;
    out.push_back({r.x * scale, r.y * scale, r.z});
  };
  for (const dvec3& a : rows) {
    if (!(a.z > view.near)) continue;
    add(a);
    for (const dvec3& b : rows) {
      if (!(b.z > view.near)) add(a + (view.near - a.z) / (b.z - a.z) * (b - a));
    }
  }
  return out;
}

// Calls with every `step`th pixel whose centre is in the hull of the points.
template <class F>
void for_each_pixel(const RasterView& view, const std::vector<ScreenPoint>& points, int step,
                    const F& call) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (const ScreenPoint& p : points) {
    x0 = std::min(x0, p.x);
    x1 = std::max(x1, p.x);
    y0 = std::min(y0, p.y);
    y1 = std::max(y1, p.y);
  }
  const int columns = static_cast<int>(view.width), rows = static_cast<int>(view.height);
  for (int y = std::max(static_cast<int>(y0), 0); y < rows && y + 0.5 <= y1; y += step) {
    for (int x = std::max(static_cast<int>(x0), 0); x < columns && x + 0.5 <= x1; x += step) {
      if (in_hull(points, x + 0.5, y + 0.5)) call(y * view.width + x);
    }
  }
}

// Half the size of the boxes of a cell's voxels as the rasteriser's rule has it, in double; see
// rasterize_cells_kernels.cpp.
struct HalfSize {
  double x = 0.0, y = 0.0;
};
inline HalfSize half_of_cell(const RasterView& view, const VoxelInstance& body, uint32_t c,
                             uint32_t block) {
  const SvoCell& cell = body.posed->svo().cells[c];
  ScreenPoint p[8];
  for (int i = 0; i < 8; ++i) {
    p[i] =
        to_screen(view, body.placement, dvec3(body.posed->block(block).positions[cell.corner[i]]));
  }
  double sum[3] = {}, low[3], high[3];
  for (int value = 0; value < 3; ++value) {
    const auto get = [&](int i) { return value == 0 ? p[i].x : value == 1 ? p[i].y : p[i].depth; };
    low[value] = high[value] = get(0);
    for (int i = 0; i < 8; ++i) {
      low[value] = std::min(low[value], get(i));
      high[value] = std::max(high[value], get(i));
    }
    for (int axis = 0; axis < 3; ++axis) {
      double most = 0.0;
      for (int i = 0; i < 8; ++i) most = std::max(most, std::abs(get(i) - get(i ^ 1 << axis)));
      sum[value] += most / 16.0;
    }
  }
  if (view.w != view.depth) return {sum[0], sum[1]};
  const auto half = [&](int value) {
    return (sum[value] * high[2] + (high[value] - low[value]) * sum[2]) / low[2];
  };
  return {half(0), half(1)};
}

}  // namespace sinew::test
