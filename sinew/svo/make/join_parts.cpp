// Parts of blocks -> one octree: offsets, copies in parallel, and the inner nodes from the cells
// up.
#include <algorithm>

#include "sinew/base/parallel.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/make/block_part.h"
#include "sinew/svo/make/node_rows.h"

namespace sinew {
namespace {

// Where the block's part of each buffer begins, in 64 bits.
struct Offsets {
  uint64_t cells = 0, corners = 0, bricks = 0, voxels = 0, joints = 0, targets = 0, deltas = 0;

  uint64_t largest() const {
    return std::max({cells, corners, bricks, voxels, joints, targets, deltas});
  }
};

// The joints that move corners of a part, rising. `seen` is scratch, all 0, one a joint.
std::vector<uint16_t> palette_of(const BlockPart& part, std::span<uint8_t> seen) {
  std::vector<uint16_t> palette;
  for (const PartCorner& corner : part.corners) {
    for (uint32_t k = 0; k < kSvoInfluences; ++k) {
      if (corner.weights[k] == 0 || seen[corner.joints[k]]) continue;
      seen[corner.joints[k]] = 1;
      palette.push_back(corner.joints[k]);
    }
  }
  for (const uint16_t joint : palette) seen[joint] = 0;
  std::ranges::sort(palette);
  return palette;
}

Offsets after(const Offsets& at, const BlockPart& part, size_t joints) {
  Offsets next = at;
  next.cells += part.cells.size();
  next.corners += part.corners.size();
  next.bricks += part.bricks.size();
  next.voxels += part.normals.size();
  next.joints += joints;
  next.targets += part.targets.size();
  next.deltas += part.deltas.size();
  return next;
}

SvoBlock block_at(const Offsets& at, uint64_t morton) {
  const uvec3 place = voxel_of(morton);
  SvoBlock block;
  block.x = static_cast<uint16_t>(place.x);
  block.y = static_cast<uint16_t>(place.y);
  block.z = static_cast<uint16_t>(place.z);
  block.first_cell = static_cast<uint32_t>(at.cells);
  block.first_corner = static_cast<uint32_t>(at.corners);
  block.first_brick = static_cast<uint32_t>(at.bricks);
  block.first_voxel = static_cast<uint32_t>(at.voxels);
  block.first_joint = static_cast<uint32_t>(at.joints);
  block.first_target = static_cast<uint32_t>(at.targets);
  return block;
}

void resize(SvoLevel& level, size_t size) {
  level.normals.resize(size);
  level.colors.resize(size);
  level.spreads.resize(size);
}

void resize(const SvoFrame& frame, const Offsets& end, bool exact_colors, Svo& svo) {
  svo.cells.resize(end.cells);
  svo.bricks.resize(end.bricks);
  svo.normals.resize(end.voxels);
  svo.colors.resize(exact_colors ? end.voxels : 0);
  svo.color_ends.resize(exact_colors ? 0 : end.bricks);
  svo.color_selectors.resize(exact_colors ? 0 : (end.voxels + 15) / 16);
  resize(svo.brick_level, end.bricks);
  resize(svo.cell_level, end.cells);
  svo.corner_places.resize(end.corners);
  svo.targets.resize(end.targets);
  svo.deltas.resize(end.deltas);
  if (frame.joints == 0) return;
  svo.corner_joints.resize(end.corners);
  svo.corner_weights.resize(end.corners);
  svo.joint_palette.resize(end.joints);
}

template <class T>
void copy_to(const std::vector<T>& from, std::vector<T>& to, uint64_t at) {
  if (!from.empty()) std::ranges::copy(from, to.begin() + static_cast<ptrdiff_t>(at));
}

void copy_level(const SvoLevel& from, size_t at, SvoLevel& to) {
  copy_to(from.normals, to.normals, at);
  copy_to(from.colors, to.colors, at);
  copy_to(from.spreads, to.spreads, at);
}

// Blocks do not begin at whole words, so one after the other.
void copy_selectors(std::span<const BlockPart> parts, Svo& svo) {
  size_t i = 0;
  for (const BlockPart& part : parts) {
    for (const uint8_t selector : part.selectors) {
      svo.color_selectors[i >> 4] |= uint32_t{selector} << (2 * (i & 15));
      ++i;
    }
  }
}

void copy_corners(const BlockPart& part, std::span<const uint16_t> palette, const Offsets& at,
                  Svo& svo) {
  for (size_t i = 0; i < part.corners.size(); ++i) {
    const PartCorner& corner = part.corners[i];
    svo.corner_places[at.corners + i] = corner.place;
    if (svo.joints == 0) continue;
    for (uint32_t k = 0; k < kSvoInfluences; ++k) {
      const auto found = std::ranges::lower_bound(palette, corner.joints[k]);
      svo.corner_joints[at.corners + i][k] =
          corner.weights[k] > 0 ? static_cast<uint8_t>(found - palette.begin()) : uint8_t{0};
    }
    svo.corner_weights[at.corners + i] = corner.weights;
  }
  if (svo.joints == 0) return;
  std::ranges::copy(palette, svo.joint_palette.begin() + static_cast<ptrdiff_t>(at.joints));
}

void copy_part(const BlockPart& part, std::span<const uint16_t> palette, const Offsets& at,
               std::span<const float> units, Svo& svo) {
  copy_to(part.cells, svo.cells, at.cells);
  copy_to(part.bricks, svo.bricks, at.bricks);
  copy_to(part.normals, svo.normals, at.voxels);
  copy_to(part.colors, svo.colors, at.voxels);
  copy_to(part.color_ends, svo.color_ends, at.bricks);
  copy_level(part.brick_level, at.bricks, svo.brick_level);
  copy_level(part.cell_level, at.cells, svo.cell_level);
  copy_corners(part, palette, at, svo);
  copy_to(part.deltas, svo.deltas, at.deltas);
  for (size_t t = 0; t < part.targets.size(); ++t) {
    svo.targets[at.targets + t] = {part.targets[t], units[part.targets[t]],
                                   static_cast<uint32_t>(at.deltas + t * part.corners.size())};
  }
}

uint32_t level_that_holds(uvec3 resolution) {
  const uint32_t longest = std::max({resolution.x, resolution.y, resolution.z, 1u});
  return std::max<uint32_t>(kBlockLevel, std::bit_width(longest - 1));
}

}  // namespace

tl::unexpected<Error> too_large(const char* what, const char* remedy) {
  return fail(
      {ErrorKind::bad_input, {}, {}, std::string("the octree has too many ") + what, remedy});
}

Result<Svo> join_parts(const SvoFrame& frame, std::span<const BlockPart> parts) {
  std::vector<std::vector<uint16_t>> palettes(parts.size());
  if (frame.joints > 0) {
    parallel_for(parts.size(), 64, [&](size_t begin, size_t end) {
      std::vector<uint8_t> seen(frame.joints, 0);
      for (size_t b = begin; b < end; ++b) palettes[b] = palette_of(parts[b], seen);
    });
  }
  std::vector<Offsets> at(parts.size() + 1);
  for (size_t b = 0; b < parts.size(); ++b) {
    if (palettes[b].size() > 256) {
      return too_large("joints in one block", "choose a higher resolution: blocks get smaller");
    }
    at[b + 1] = after(at[b], parts[b], palettes[b].size());
  }
  const Offsets& end = at.back();
  if (end.largest() > 0xffffffffu) return too_large("voxels", "choose a lower resolution");
  Svo svo;
  svo.grid = frame.grid;
  svo.joints = frame.joints;
  svo.morph_targets = frame.morph_targets;
  svo.morph_weights.assign(frame.morph_targets, 0.0f);
  svo.root_level = level_that_holds(frame.grid.resolution);
  if (parts.empty()) return svo;
  NodeRows rows;
  rows.add(parts);
  rows.finish(svo);
  if (svo.nodes.size() + end.cells > kMostUnits)
    return too_large("cells", "choose a lower resolution");
  for (size_t b = 0; b < parts.size(); ++b) svo.blocks.push_back(block_at(at[b], parts[b].morton));
  svo.blocks.push_back(block_at(end, 0));
  resize(frame, end, parts.front().exact_colors, svo);
  copy_selectors(parts, svo);
  parallel_for(parts.size(), 4, [&](size_t begin, size_t stop) {
    for (size_t b = begin; b < stop; ++b) copy_part(parts[b], palettes[b], at[b], frame.units, svo);
  });
  return svo;
}

}  // namespace sinew
