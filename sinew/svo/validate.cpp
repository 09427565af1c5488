// Every invariant of format.h, in linear time and without trust: octrees from hostile files come
// here before anybody follows an index.
#include <algorithm>
#include <cmath>

#include "sinew/svo/corners.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/make/fragments.h"

namespace sinew {
namespace {

std::string at(const char* what, size_t index, const char* problem) {
  return std::string(what) + " " + std::to_string(index) + ": " + problem;
}

// Morton code within a block of the cell at x + 8 y + 64 z.
uint32_t cell_morton(uint16_t place) {
  return static_cast<uint32_t>(morton_of(uvec3(place & 7, place >> 3 & 7, place >> 6)));
}
uint64_t block_morton(const SvoBlock& block) {
  return morton_of(uvec3(block.x, block.y, block.z));
}

std::string problem_of_grid(const Svo& svo) {
  const uvec3 r = svo.grid.resolution;
  const uint32_t longest = std::max({r.x, r.y, r.z});
  if (std::min({r.x, r.y, r.z}) == 0 || longest > kHighestResolution) {
    return "the resolution is not 1 to 4096";
  }
  const vec3 end = svo.grid.origin + svo.grid.voxel * vec3(r + kBlockSide);
  if (!(svo.grid.voxel > 0.0f) || !std::isfinite(svo.grid.origin.x + end.x) ||
      !std::isfinite(svo.grid.origin.y + end.y) || !std::isfinite(svo.grid.origin.z + end.z)) {
    return "the grid's place or voxel size is not finite, or not positive";
  }
  if (svo.root_level < kBlockLevel || svo.root_level > 12 || longest > 1u << svo.root_level) {
    return "the root's level does not hold the resolution";
  }
  return {};
}

std::string problem_of_level(const SvoLevel& level, size_t size, const char* name) {
  if (level.normals.size() != size || level.colors.size() != size || level.spreads.size() != size) {
    return std::string(name) + ": the count of attributes is not that of what they belong to";
  }
  return {};
}

std::string problem_of_voxels(const Svo& svo, size_t voxels) {
  if (svo.normals.size() != voxels) return "voxels: one normal each";
  if (!svo.colors.empty()) {
    const bool alone = svo.color_ends.empty() && svo.color_selectors.empty();
    return svo.colors.size() == voxels && alone ? "" : "voxels: one colour each";
  }
  if (svo.color_ends.size() != svo.bricks.size()) return "bricks: two ends of colours each";
  if (svo.color_selectors.size() != (voxels + 15) / 16) return "voxels: two bits of colour each";
  if (!svo.paging && voxels % 16 != 0 && svo.color_selectors.back() >> (2 * (voxels % 16)) != 0) {
    return "voxels: bits of colour behind the last";
  }
  return {};
}

// Sizes that do not depend on what the buffers hold, but for the last block.
std::string problem_of_sizes(const Svo& svo) {
  if (svo.blocks.size() == 1) return "blocks: an end without a block";
  const bool none = svo.blocks.empty();
  const SvoBlock end = none ? SvoBlock{} : svo.blocks.back();
  if (none && !svo.nodes.empty()) return "nodes: no blocks";
  const SvoBlock first = none ? SvoBlock{} : svo.blocks.front();
  if ((first.first_cell | first.first_corner | first.first_brick | first.first_joint |
       first.first_target | first.first_voxel) != 0) {
    return "blocks: the first does not begin at 0";
  }
  if (svo.cells.size() != end.first_cell) return "cells: their count is not the blocks'";
  if (svo.bricks.size() != end.first_brick) return "bricks: their count is not the blocks'";
  std::string problem = problem_of_voxels(svo, end.first_voxel);
  if (!problem.empty()) return problem;
  problem = problem_of_level(svo.brick_level, svo.bricks.size(), "brick level");
  if (!problem.empty()) return problem;
  problem = problem_of_level(svo.cell_level, svo.cells.size(), "cell level");
  if (!problem.empty()) return problem;
  problem = problem_of_level(svo.node_level, svo.nodes.size(), "node level");
  if (!problem.empty()) return problem;
  const size_t corners = end.first_corner, skinned = svo.joints > 0 ? corners : 0;
  if (svo.corner_places.size() != corners || svo.corner_joints.size() != skinned ||
      svo.corner_weights.size() != skinned) {
    return "corners: their count is not the blocks'";
  }
  if (svo.joint_palette.size() != end.first_joint) return "joints: their count is not the blocks'";
  if (svo.targets.size() != end.first_target) return "targets: their count is not the blocks'";
  if (svo.joints > 65536) return "more than 65536 joints";
  if (svo.morph_weights.size() != svo.morph_targets) return "one default weight a morph target";
  if (svo.cells.size() + svo.nodes.size() > kMostUnits) return "too many cells and nodes";
  return {};
}

std::string problem_of_block(const Svo& svo, size_t b) {
  const SvoBlock &block = svo.blocks[b], &next = svo.blocks[b + 1];
  if (block.reserved != 0) return at("block", b, "reserved bits");
  if (next.first_cell <= block.first_cell || next.first_corner <= block.first_corner ||
      next.first_brick <= block.first_brick || next.first_voxel <= block.first_voxel ||
      next.first_joint < block.first_joint || next.first_target < block.first_target) {
    return at("block", b, "empty, or begins after its end");
  }
  const uint32_t blocks = (1u << svo.root_level) / kBlockSide;
  if (block.x >= blocks || block.y >= blocks || block.z >= blocks) {
    return at("block", b, "outside of the root");
  }
  if (b > 0 && block_morton(svo.blocks[b - 1]) >= block_morton(block)) {
    return at("block", b, "out of order");
  }
  if (next.first_corner - block.first_corner > 65536) return at("block", b, "too many corners");
  const uint32_t joints = next.first_joint - block.first_joint;
  if (joints > 256 || (joints > 0) != (svo.joints > 0)) {
    return at("block", b, "the count of joints");
  }
  return {};
}

// Where the next cell of a block must begin.
struct CellCursor {
  uint32_t brick = 0;
  uint32_t voxel = 0;
};

bool in_grid(const Svo& svo, const SvoBlock& block, const SvoCell& cell, uint32_t brick,
             uint64_t mask);

// All but its bricks.
std::string problem_of_cell(const Svo& svo, const SvoBlock& block, const SvoBlock& next, size_t c,
                            CellCursor& cursor) {
  const SvoCell& cell = svo.cells[c];
  if (cell.reserved != 0 || cell.place >= 512) return at("cell", c, "place or reserved bits");
  if (c > block.first_cell && cell_morton(svo.cells[c - 1].place) > cell_morton(cell.place)) {
    return at("cell", c, "out of order");
  }
  for (const uint16_t corner : cell.corner) {
    if (corner >= next.first_corner - block.first_corner) return at("cell", c, "no such corner");
  }
  for (uint32_t k = 0; k < 8; ++k) {
    const uint16_t place = svo.corner_places[block.first_corner + cell.corner[k]];
    const uint32_t x = (cell.place & 7) + (k & 1), y = (cell.place >> 3 & 7) + (k >> 1 & 1);
    if (place != x + 9 * y + 81 * ((cell.place >> 6) + (k >> 2))) {
      return at("cell", c, "a corner of another place");
    }
  }
  if (cell.first_brick != cursor.brick || cell.first_voxel != cursor.voxel) {
    return at("cell", c, "does not begin where the one before ends");
  }
  const uint32_t bricks = static_cast<uint32_t>(std::popcount(cell.bricks));
  if (bricks == 0 || bricks > next.first_brick - block.first_brick - cursor.brick) {
    return at("cell", c, "no bricks, or too many");
  }
  if (cell.voxels < bricks || cell.voxels > 64 * bricks ||
      cell.voxels > next.first_voxel - block.first_voxel - cursor.voxel) {
    return at("cell", c, "the count of voxels");
  }
  cursor.brick += bricks;
  cursor.voxel += cell.voxels;
  return {};
}

std::string problem_of_bricks(const Svo& svo, const SvoBlock& block, size_t c) {
  const SvoCell& cell = svo.cells[c];
  const uint64_t* mask = &svo.bricks[block.first_brick + cell.first_brick];
  uint32_t voxels = 0;
  for (uint32_t brick = 0; brick < 8; ++brick) {
    if (!(cell.bricks >> brick & 1)) continue;
    if (*mask == 0) return at("cell", c, "an empty brick");
    if (!in_grid(svo, block, cell, brick, *mask)) return at("cell", c, "outside of the grid");
    voxels += static_cast<uint32_t>(std::popcount(*mask++));
  }
  return voxels == cell.voxels ? std::string() : at("cell", c, "the count of voxels");
}

// Whether the brick's voxels lie within the resolution.
bool in_grid(const Svo& svo, const SvoBlock& block, const SvoCell& cell, uint32_t brick,
             uint64_t mask) {
  const uvec3 first(64u * block.x + 8u * (cell.place & 7) + 4u * (brick & 1),
                    64u * block.y + 8u * (cell.place >> 3 & 7) + 4u * (brick >> 1 & 1),
                    64u * block.z + 8u * (cell.place >> 6) + 4u * (brick >> 2));
  if (glm::all(glm::lessThanEqual(first + 4u, svo.grid.resolution))) return true;
  for (; mask != 0; mask &= mask - 1) {
    const uint32_t bit = static_cast<uint32_t>(std::countr_zero(mask));
    const uvec3 voxel = first + uvec3(bit & 3, bit >> 2 & 3, bit >> 4);
    if (glm::any(glm::greaterThanEqual(voxel, svo.grid.resolution))) return false;
  }
  return true;
}

std::string problem_of_cells(const Svo& svo, size_t b) {
  const SvoBlock &block = svo.blocks[b], &next = svo.blocks[b + 1];
  CellCursor cursor;
  for (size_t c = block.first_cell; c < next.first_cell; ++c) {
    std::string problem = problem_of_cell(svo, block, next, c, cursor);
    if (problem.empty() && !svo.paging) problem = problem_of_bricks(svo, block, c);
    if (!problem.empty()) return problem;
  }
  const bool ends = cursor.brick == next.first_brick - block.first_brick &&
                    cursor.voxel == next.first_voxel - block.first_voxel;
  return ends ? std::string() : at("block", b, "its cells do not fill it");
}

std::string problem_of_corners(const Svo& svo, size_t b) {
  const SvoBlock &block = svo.blocks[b], &next = svo.blocks[b + 1];
  const uint32_t joints = next.first_joint - block.first_joint;
  for (size_t c = block.first_corner; c < next.first_corner; ++c) {
    if (svo.corner_places[c] >= kCornerPlaces) return at("corner", c, "no such place");
    if (svo.joints == 0) continue;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < kSvoInfluences; ++k) {
      if (svo.corner_joints[c][k] >= joints) return at("corner", c, "no such joint");
      sum += svo.corner_weights[c][k];
    }
    if (sum != 65535) return at("corner", c, "weights do not sum to 65535");
  }
  for (size_t j = block.first_joint; j < next.first_joint; ++j) {
    if (svo.joint_palette[j] >= svo.joints) return at("block", b, "no such joint");
    if (j > block.first_joint && svo.joint_palette[j - 1] >= svo.joint_palette[j]) {
      return at("block", b, "joints out of order");
    }
  }
  return {};
}

std::string problem_of_targets(const Svo& svo) {
  size_t deltas = 0;
  for (size_t b = 0; b + 1 < svo.blocks.size(); ++b) {
    const SvoBlock &block = svo.blocks[b], &next = svo.blocks[b + 1];
    for (size_t t = block.first_target; t < next.first_target; ++t) {
      const SvoTarget& target = svo.targets[t];
      if (target.target >= svo.morph_targets) return at("target", t, "no such morph target");
      if (t > block.first_target && svo.targets[t - 1].target >= target.target) {
        return at("target", t, "out of order");
      }
      if (!std::isfinite(target.unit) || target.unit < 0.0f) return at("target", t, "its unit");
      if (target.first_delta != deltas) return at("target", t, "where its deltas begin");
      deltas += next.first_corner - block.first_corner;
      if (deltas > svo.deltas.size()) return at("target", t, "where its deltas end");
    }
  }
  return deltas == svo.deltas.size() ? std::string() : "deltas: more than the targets'";
}

// Nodes of one level: [first, end).
struct NodeRange {
  size_t first = 0, end = 0;
};

// Children follow each other without a gap from `child` to `child_end`.
std::string problem_of_row(const Svo& svo, NodeRange row, uint32_t level, size_t child,
                           size_t child_end) {
  for (size_t n = row.first; n < row.end; ++n) {
    const SvoNode& node = svo.nodes[n];
    if (node.level != level || node.reserved != 0) return at("node", n, "level or reserved bits");
    if (node.first != child || node.count == 0 || node.count > child_end - child) {
      return at("node", n, "its children");
    }
    child += node.count;
  }
  return child == child_end ? std::string() : at("node", row.end, "children that no node has");
}

// Children have the same place above, nodes of a row rising ones. Fills the row's Morton codes.
std::string fill_mortons(const Svo& svo, NodeRange row, size_t first_child,
                         const std::vector<uint64_t>& children, std::vector<uint64_t>& out) {
  out.clear();
  for (size_t n = row.first; n < row.end; ++n) {
    const SvoNode& node = svo.nodes[n];
    const size_t begin = node.first - first_child;
    const uint64_t morton = children[begin] >> 3;
    if (children[begin + node.count - 1] >> 3 != morton) {
      return at("node", n, "children of different nodes");
    }
    if (!out.empty() && out.back() >= morton) return at("node", n, "out of order");
    out.push_back(morton);
  }
  return {};
}

// Upwards from the cells; `children` rise, because cells and blocks are in order.
std::string problem_of_nodes(const Svo& svo) {
  if (svo.nodes.empty() || svo.nodes[0].level != svo.root_level) return "nodes: no root";
  std::vector<uint64_t> children, mortons;
  for (size_t b = 0; b + 1 < svo.blocks.size(); ++b) {
    const uint64_t block = block_morton(svo.blocks[b]) << 9;
    for (size_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      children.push_back(block | cell_morton(svo.cells[c].place));
    }
  }
  NodeRange row{svo.nodes.size(), svo.nodes.size()};
  size_t child = 0, child_end = svo.cells.size();
  for (uint32_t level = kCellLevel + 1; level <= svo.root_level; ++level) {
    row.end = row.first;
    while (row.first > 0 && svo.nodes[row.first - 1].level == level) --row.first;
    std::string problem = problem_of_row(svo, row, level, child, child_end);
    if (problem.empty()) problem = fill_mortons(svo, row, child, children, mortons);
    if (!problem.empty()) return problem;
    if (level == kBlockLevel && mortons.size() + 1 != svo.blocks.size()) {
      return "nodes: one of level 6 a block";
    }
    child = row.first;
    child_end = row.end;
    children.swap(mortons);
  }
  if (row.first != 0 || row.end != 1) return "nodes: one root";
  return {};
}

}  // namespace

std::string validate_bricks(const Svo& svo, uint32_t block) {
  std::string problem;
  for (size_t c = svo.blocks[block].first_cell;
       c < svo.blocks[block + 1].first_cell && problem.empty(); ++c) {
    problem = problem_of_bricks(svo, svo.blocks[block], c);
  }
  return problem;
}

std::string validate(const Svo& svo) {
  std::string problem = problem_of_grid(svo);
  if (problem.empty()) problem = problem_of_sizes(svo);
  for (size_t b = 0; b + 1 < svo.blocks.size() && problem.empty(); ++b) {
    problem = problem_of_block(svo, b);
  }
  for (size_t b = 0; b + 1 < svo.blocks.size() && problem.empty(); ++b) {
    problem = problem_of_corners(svo, b);
    if (problem.empty()) problem = problem_of_cells(svo, b);
  }
  if (problem.empty()) problem = problem_of_targets(svo);
  if (problem.empty() && !svo.blocks.empty()) problem = problem_of_nodes(svo);
  for (const float weight : svo.morph_weights) {
    if (problem.empty() && !std::isfinite(weight)) problem = "a default weight is not finite";
  }
  return problem;
}

}  // namespace sinew
