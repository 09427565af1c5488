// Grids around boxes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/svo/make/voxelize.h"

namespace sinew {
namespace {

using glm::dvec3;

constexpr double kMargin = 1.0 / 64.0;    // voxels between a box and the grid's border, at least
constexpr double kSpare = 1.0 / 16.0;     // voxels of a resolution that are margins and rounding
constexpr float kSmallestVoxel = 1e-30f;  // and its inverse is finite
constexpr float kLargestVoxel = 1e30f;

double longest_side(const Box& box) {
  const dvec3 extent = dvec3(box.max) - dvec3(box.min);
  return std::max({extent.x, extent.y, extent.z});
}

// The next float below or above a coordinate, as far away as floats are there.
float step_at(const Box& box) {
  const vec3 reach = max(abs(box.min), abs(box.max));
  const float far = std::max({reach.x, reach.y, reach.z});
  return std::nextafter(far, std::numeric_limits<float>::infinity()) - far;
}

Result<void> check(const Box& box, float voxel) {
  if (box.empty() || !is_finite(box)) {
    return fail({ErrorKind::bad_input, "", "", "there is no triangle to voxelise", ""});
  }
  if (!(voxel >= kSmallestVoxel && voxel <= kLargestVoxel)) {
    return fail({ErrorKind::bad_input, "", "",
                 fmt::format("voxels of side {:g} are out of range", voxel),
                 fmt::format("scale the object so that they are between {:g} and {:g}",
                             kSmallestVoxel, kLargestVoxel)});
  }
  if (voxel < step_at(box)) {
    return fail({ErrorKind::bad_input, "", "",
                 fmt::format("so far from the origin coordinates are {:g} apart, more than the "
                             "side of a voxel, {:g}",
                             step_at(box), voxel),
                 "move the object to the origin, or make voxels larger"});
  }
  return {};
}

// The box in the middle of the fewest voxels that keep the margin; in one axis.
uint64_t place_axis(float low, float high, float voxel, float& origin) {
  const double extent = static_cast<double>(high) - low;
  double count = std::max(std::ceil(extent / voxel + 2.0 * kMargin), 1.0);
  // A float origin may be too far to one side; then a voxel more.
  for (;; count += 1.0) {
    origin = static_cast<float>(0.5 * (static_cast<double>(low) + high - count * voxel));
    const double first = (static_cast<double>(low) - origin) / voxel;
    const double last = (static_cast<double>(high) - origin) / voxel;
    if (first > 0.5 * kMargin && last < count - 0.5 * kMargin) break;
    if (count > 2.0 * kHighestResolution) break;  // an error anyway
  }
  return static_cast<uint64_t>(std::min(count, 1e18));
}

Result<VoxelGrid> place_grid(const Box& box, float voxel) {
  SINEW_CHECKED(check(box, voxel));
  VoxelGrid grid;
  grid.voxel = voxel;
  for (int k = 0; k < 3; ++k) {
    const uint64_t count = place_axis(box.min[k], box.max[k], voxel, grid.origin[k]);
    if (count > kHighestResolution) {
      return fail({ErrorKind::usage, "", "",
                   fmt::format("{} voxels along a side are too many: at most {}", count,
                               kHighestResolution),
                   "make voxels larger"});
    }
    grid.resolution[k] = static_cast<uint32_t>(count);
  }
  return grid;
}

}  // namespace

double voxel_side(double longest, uint32_t resolution) {
  return longest / (static_cast<double>(resolution) - kSpare);
}

Result<VoxelGrid> grid_of_resolution(const Box& box, uint32_t resolution) {
  if (resolution == 0 || resolution > kHighestResolution) {
    return fail({ErrorKind::usage, "", fmt::format("resolution {}", resolution),
                 "that is no resolution", fmt::format("write 1 to {}", kHighestResolution)});
  }
  if (box.empty() || !is_finite(box)) return place_grid(box, 1.0f);
  auto voxel = static_cast<float>(voxel_side(longest_side(box), resolution));
  // Far from the origin the box may lie so that it needs a voxel more.
  for (int tries = 0; tries < 64; ++tries) {
    SINEW_CHECKED(check(box, voxel));
    Result<VoxelGrid> grid = place_grid(box, voxel);
    if (grid) {
      const uvec3 n = grid->resolution;
      if (std::max({n.x, n.y, n.z}) <= resolution) return grid;
    }
    voxel *= 1.0f + 0.25f / static_cast<float>(resolution);
  }
  return place_grid(box, voxel);
}

Result<VoxelGrid> grid_of_voxels(const Box& box, float voxel) {
  if (!(voxel > 0.0f)) {
    return fail({ErrorKind::usage, "", fmt::format("voxel size {:g}", voxel),
                 "voxels have a positive side", ""});
  }
  return place_grid(box, voxel);
}

}  // namespace sinew
