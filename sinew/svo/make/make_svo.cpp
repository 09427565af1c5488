// A voxelised surface -> an octree, block by block: sheets and cells first, then corners, which
// look at the sheets of the blocks around.
#include "sinew/svo/make/make_svo.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/svo/make/block_ranges.h"
#include "sinew/svo/make/lattice.h"

namespace sinew {
namespace {

Result<void> check_fragments(const VoxelSurface& surface, const SvoSource& source) {
  uint32_t highest = 0;
  for (const VoxelFragment& fragment : surface.fragments) {
    highest = std::max(highest, fragment.triangle == kInside ? 0 : fragment.triangle);
  }
  if (source.triangles.size() <= highest) return bad_voxels("a fragment of no such triangle");
  return {};
}

}  // namespace

Result<void> check_source(const SvoSource& source) {
  if (const std::string problem = validate(source.motion); !problem.empty()) {
    return bad_voxels(problem);
  }
  if (source.materials.size() != source.triangles.size()) {
    return bad_voxels("one material a triangle is needed");
  }
  const uint32_t vertices = vertex_count(source.motion);
  for (const uvec3 t : source.triangles) {
    if (std::max({t.x, t.y, t.z}) >= vertices) return bad_voxels("a triangle of no such vertex");
  }
  return {};
}

// So that the largest delta of a target takes all of 16 bits. One for all blocks, for corners that
// blocks have in common must come out the same.
std::vector<float> delta_units(const LatticeSource& source) {
  std::vector<float> units(source.targets);
  const size_t stride = source.rest.size();
  parallel_for(source.targets, 1, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      float most = 0.0f;
      for (const vec3 d : source.deltas.subspan(t * stride, stride)) {
        const float size = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
        if (std::isfinite(size)) most = std::max(most, size);
      }
      units[t] = most / 32767.0f;
    }
  });
  return units;
}

SvoFrame frame_of(const LatticeSource& lattice, std::span<const float> units) {
  SvoFrame frame;
  frame.grid = lattice.grid;
  frame.joints = lattice.skin.influences > 0 ? lattice.skin.joint_count : 0;
  frame.morph_targets = lattice.targets;
  frame.units = units;
  return frame;
}

Result<Svo> make_svo(const VoxelSurface& surface, const SvoSource& source) {
  const std::span<const VoxelFragment> fragments = surface.fragments;
  SINEW_CHECKED(check_grid(surface.grid));
  SINEW_CHECKED(check_voxels(surface.grid, fragments, false));
  SINEW_CHECKED(check_source(source));
  SINEW_CHECKED(check_fragments(surface, source));
  const LatticeSource lattice = lattice_source(surface.grid, source);
  const bool solid = std::ranges::any_of(
      fragments, [](const VoxelFragment& fragment) { return fragment.triangle == kInside; });
  const std::vector<size_t> first = first_of_blocks(fragments);
  std::vector<BlockPart> parts(first.size() - 1);
  std::vector<BlockSheets> sheets(parts.size());
  parallel_for(parts.size(), 1, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) {
      const auto block = fragments.subspan(first[b], first[b + 1] - first[b]);
      make_sheets(lattice, block, solid, sheets[b], parts[b]);
    }
  });
  if (solid) seed_inside(lattice, sheets, parts);
  const std::vector<float> units = delta_units(lattice);
  parallel_for(parts.size(), 1, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) make_corners(lattice, sheets, b, units, parts[b]);
  });
  return join_parts(frame_of(lattice, units), parts);
}

}  // namespace sinew
