// Sorted voxels or fragments -> where their blocks and cells begin; and whether they are fit to be
// made an octree of. For anything with a member `voxel`.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/base/parallel.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {

// How many at the front have the first one's Morton code without its last `bits` bits; 0 if there
// is none. Steps double, so that it takes the logarithm of the answer.
template <class T>
size_t count_of_first(std::span<const T> sorted, uint32_t bits) {
  if (sorted.empty()) return 0;
  const VoxelMorton key = sorted.front().voxel >> bits;
  size_t step = 1;
  while (step < sorted.size() && sorted[step].voxel >> bits == key) step *= 2;
  const auto begin = sorted.begin() + static_cast<ptrdiff_t>(step / 2);
  const auto end = sorted.begin() + static_cast<ptrdiff_t>(std::min(step, sorted.size()));
  const auto found =
      std::partition_point(begin, end, [&](const T& v) { return v.voxel >> bits == key; });
  return static_cast<size_t>(found - sorted.begin());
}

// Where each block begins; the end of the last one stands behind.
template <class T>
std::vector<size_t> first_of_blocks(std::span<const T> sorted) {
  std::vector<size_t> first{0};
  while (first.back() < sorted.size()) {
    first.push_back(first.back() + count_of_first(sorted.subspan(first.back()), 18));
  }
  return first;
}

inline tl::unexpected<Error> bad_voxels(std::string problem) {
  return fail({ErrorKind::bad_input, {}, {}, std::move(problem), {}});
}

inline Result<void> check_grid(const VoxelGrid& grid) {
  const uint32_t longest = std::max({grid.resolution.x, grid.resolution.y, grid.resolution.z});
  const uint32_t shortest = std::min({grid.resolution.x, grid.resolution.y, grid.resolution.z});
  if (shortest == 0 || longest > kHighestResolution) {
    return bad_voxels("the resolution is not 1 to " + std::to_string(kHighestResolution));
  }
  const vec3 end = grid.origin + grid.voxel * vec3(grid.resolution);
  if (!(grid.voxel > 0.0f) || !std::isfinite(grid.origin.x + grid.origin.y + grid.origin.z) ||
      !std::isfinite(end.x + end.y + end.z)) {
    return bad_voxels("the grid's place or voxel size is not finite, or not positive");
  }
  return {};
}

// Within the grid and sorted; each place once if `unique`. In parallel.
template <class T>
Result<void> check_voxels(const VoxelGrid& grid, std::span<const T> voxels, bool unique) {
  if (voxels.empty()) return bad_voxels("there are no voxels");
  constexpr size_t kGrain = 1 << 16;
  std::vector<const char*> problems((voxels.size() + kGrain - 1) / kGrain, nullptr);
  parallel_for(voxels.size(), kGrain, [&](size_t begin, size_t end) {
    const char*& problem = problems[begin / kGrain];
    VoxelMorton good_cell = ~VoxelMorton{0};  // all of whose voxels lie within the grid
    for (size_t i = begin; i < end && !problem; ++i) {
      const VoxelMorton voxel = voxels[i].voxel;
      if (i > 0 && (voxel < voxels[i - 1].voxel || (unique && voxel == voxels[i - 1].voxel))) {
        problem = "voxels are out of order";
      }
      if (voxel >> 9 == good_cell) continue;
      if (voxel >> 36 || glm::any(glm::greaterThanEqual(voxel_of(voxel), grid.resolution))) {
        problem = "a voxel is outside of the grid";
      }
      const bool inside = glm::all(glm::lessThan(voxel_of(voxel | 511), grid.resolution));
      if (inside) good_cell = voxel >> 9;
    }
  });
  for (const char* const problem : problems) {
    if (problem) return bad_voxels(problem);
  }
  return {};
}

}  // namespace sinew
