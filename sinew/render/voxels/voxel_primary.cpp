#include "sinew/render/voxels/voxel_primary.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// Microseconds of one core, fitted to bodies of 4,000 to 400,000 voxels in pictures of 100 x 100 to
// 800 x 800 pixels, from afar and close by: within a factor of two or three.
constexpr double kRasterObject = 3.0;
constexpr double kRasterBlock = 2.0;  // posed and listed
constexpr double kRasterCell = 0.02;
constexpr double kRasterVoxel = 0.008;
constexpr double kLargeVoxel = 0.1;    // more, if it has faces or is a rectangle of its own
constexpr double kLargePixel = 0.015;  // ... of its square in pixels
constexpr double kLarge = 2.5;         // pixels
constexpr double kTracedRay = 0.01;    // that comes near the object
constexpr double kTracedHit = 0.12;    // more, if it meets it
constexpr double kTracedCell = 1.0;    // made for the rays that reach it
constexpr double kFilled = 0.25;       // share of its box on the screen that a body covers
constexpr double kFront = 0.4;         // share of its cells that rays reach
// Of a body around the eye: its voxels close by fill the picture, some over others.
constexpr double kCrossing = 0.02;  // a pixel

double plane(vec4 row, vec3 p) {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

// The object's box on the screen.
struct Projected {
  double pixels = 0.0;   // in the picture
  double share = 0.0;    // of the box that is in the picture, by area
  double voxel = 0.0;    // pixels: side of a voxel of level 0, at the box's middle
  bool crosses = false;  // the plane of the eye
};

Projected project(const VoxelInstance& object, const RasterView& view) {
  const Svo& svo = object.posed->svo();
  const Box box = transform_box(object.placement, object.posed->bounds(0));
  const double all = double(view.width) * double(view.height);
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  bool behind = false, before = false;
  for (int i = 0; i < 8; ++i) {
    const vec3 p((i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y,
                 (i & 4) ? box.max.z : box.min.z);
    if (plane(view.depth, p) <= view.near) {
      behind = true;
      continue;
    }
    before = true;
    const double w = plane(view.w, p), at[2] = {plane(view.x, p) / w, plane(view.y, p) / w};
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  if (!before) return {};
  const double w = std::max(plane(view.w, box.center()), 1e-6);
  const vec3 across = vec3(view.x) - 0.5f * static_cast<float>(view.width) * vec3(view.w);
  const double scale = std::cbrt(std::abs(glm::determinant(linear_part(object.placement))));
  const double voxel = svo.grid.voxel * scale * length(across) / w;
  if (behind) return {all, 1.0, voxel, true};
  const auto inside = [](double from, double to, double size) {
    return std::max(std::min(to, size) - std::max(from, 0.0), 0.0);
  };
  const double shown = inside(low[0], high[0], view.width) * inside(low[1], high[1], view.height);
  const double whole = std::max((high[0] - low[0]) * (high[1] - low[1]), 1e-9);
  return {shown, std::min(shown / whole, 1.0), voxel};
}

}  // namespace

PrimaryCosts estimate_primary(const VoxelInstance& object, const RasterView& view,
                              const VoxelSettings& settings) {
  const Svo& svo = object.posed->svo();
  const Projected on = project(object, view);
  const double level =
      settings.lod > 0.0f ? std::max(std::ceil(std::log2(settings.lod / on.voxel)), 0.0) : 0.0;
  // A surface has a quarter as many voxels on the next level.
  const double voxels = static_cast<double>(svo.voxel_count()) * on.share * std::pow(0.25, level);
  const double cells = static_cast<double>(svo.cells.size()) * on.share *
                       std::pow(0.25, std::max(level - kCellLevel - 1.0, 0.0));
  const double blocks = static_cast<double>(svo.block_count()) * on.share *
                        std::pow(0.25, std::max(level - kBlockLevel, 0.0));
  const double hits = kFilled * on.pixels, side = on.voxel * std::exp2(level);
  PrimaryCosts out;
  out.raster_us =
      kRasterObject + kRasterBlock * blocks + kRasterCell * cells + kRasterVoxel * voxels;
  if (on.crosses) {
    out.raster_us += kCrossing * on.pixels;  // its middle may be at the eye: `side` says nothing
  } else if (side > kLarge) {
    out.raster_us += voxels * (kLargeVoxel + kLargePixel * side * side);
  }
  const double made = std::min(kFront * cells, hits);
  out.trace_us = kTracedRay * on.pixels + kTracedHit * hits + kTracedCell * made +
                 kRasterBlock * std::min(kFront * blocks, hits);
  return out;
}

bool is_traced(const VoxelInstance& object, const RasterView& view, const VoxelSettings& settings,
               bool rays) {
  if (settings.skinning != VoxelSkinning::lattice) return false;
  if (settings.primary != VoxelPrimary::automatic) return settings.primary == VoxelPrimary::trace;
  if (!rays) return false;
  const PrimaryCosts costs = estimate_primary(object, view, settings);
  return costs.trace_us < costs.raster_us;
}

}  // namespace sinew
