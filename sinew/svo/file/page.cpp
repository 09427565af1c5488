#include "sinew/svo/file/page.h"

#include <bit>

#include "sinew/svo/make/fragments.h"

namespace sinew::svo_file {
namespace {

constexpr uint32_t kGroups = 8;  // of 2^3 voxels, in a brick

// Bits of the voxels of group 0; group (x, y, z) is shifted by 2 x + 8 y + 32 z.
constexpr uint64_t kGroupMask = 0x0000000000330033ull;
uint32_t shift_of(uint32_t group) {
  return 2 * (group & 1) + 8 * (group >> 1 & 1) + 32 * (group >> 2);
}

// The 8 voxels of a group as a byte, x lowest, and back.
uint8_t pack_group(uint64_t brick, uint32_t group) {
  const uint64_t bits = brick >> shift_of(group) & kGroupMask;
  const uint64_t rows = (bits | bits >> 2) & 0xf000fu;  // 4 bits a layer
  return static_cast<uint8_t>((rows | rows >> 12) & 0xff);
}
uint64_t unpack_group(uint8_t voxels, uint32_t group) {
  const uint64_t rows = (voxels & 0xfu) | (voxels & 0xf0u) << 12;
  return ((rows & 0x30003u) | (rows & 0xc000cu) << 2) << shift_of(group);
}

uint8_t groups_of(uint64_t brick) {
  uint32_t groups = 0;
  for (uint32_t g = 0; g < kGroups; ++g) {
    groups |= uint32_t{(brick >> shift_of(g) & kGroupMask) != 0} << g;
  }
  return static_cast<uint8_t>(groups);
}

// Places of cells within a block, 3 bits an axis, as Morton codes and back.
uint16_t morton_of_place(uint16_t place) {
  return static_cast<uint16_t>(morton_of(uvec3(place & 7, place >> 3 & 7, place >> 6)));
}
uint16_t place_of_morton(uint16_t morton) {
  const uvec3 v = voxel_of(morton);
  return static_cast<uint16_t>(v.x + 8 * v.y + 64 * v.z);
}

void write_cells(const Svo& svo, uint32_t block, StreamWriter& out) {
  const Counts counts = counts_of(svo, block);
  const SvoCell* const cells = svo.cells.data() + svo.blocks[block].first_cell;
  out.add<uint16_t>(Part::topology, counts.cells, [&](size_t i) {
    const uint16_t before = i == 0 ? uint16_t{0} : morton_of_place(cells[i - 1].place);
    return fold(static_cast<uint16_t>(morton_of_place(cells[i].place) - before));
  });
  out.add<uint16_t>(Part::topology, counts.cells, [&](size_t i) {
    return fold(static_cast<uint16_t>(cells[i].material - (i == 0 ? 0 : cells[i - 1].material)));
  });
  out.add<uint8_t>(Part::topology, counts.cells, [&](size_t i) { return cells[i].bricks; });
  out.add<uint16_t>(Part::topology, counts.cells, [&](size_t i) { return cells[i].voxels; });
}

void write_bricks(const Svo& svo, uint32_t block, StreamWriter& out) {
  const Counts counts = counts_of(svo, block);
  const uint64_t* const bricks = svo.bricks.data() + svo.blocks[block].first_brick;
  std::vector<uint8_t> voxels;
  for (size_t i = 0; i < counts.bricks; ++i) {
    for (uint32_t g = 0; g < kGroups; ++g) {
      if (const uint8_t group = pack_group(bricks[i], g); group != 0) voxels.push_back(group);
    }
  }
  out.add<uint8_t>(Part::topology, counts.bricks, [&](size_t i) { return groups_of(bricks[i]); });
  out.add(Part::topology, voxels);
}

bool read_masks(StreamReader& in, std::span<uint64_t> bricks) {
  const std::vector<uint8_t> groups = in.take<uint8_t>(bricks.size());
  size_t count = 0;
  for (const uint8_t g : groups) count += static_cast<size_t>(std::popcount(g));
  const std::vector<uint8_t> voxels = in.take<uint8_t>(count);
  if (!in.ok()) return false;
  size_t next = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    bricks[i] = 0;
    if (groups[i] == 0) return false;
    for (uint32_t g = 0; g < kGroups; ++g) {
      if ((groups[i] >> g & 1) == 0) continue;
      if (voxels[next] == 0) return false;
      bricks[i] |= unpack_group(voxels[next++], g);
    }
  }
  return true;
}

bool read_cells(StreamReader& in, uint32_t block, Svo& svo) {
  const Counts counts = counts_of(svo, block);
  const std::span cells(svo.cells.data() + svo.blocks[block].first_cell, counts.cells);
  const std::vector<uint16_t> places = in.take<uint16_t>(counts.cells);
  const std::vector<uint16_t> materials = in.take<uint16_t>(counts.cells);
  const std::vector<uint8_t> occupied = in.take<uint8_t>(counts.cells);
  const std::vector<uint16_t> voxels = in.take<uint16_t>(counts.cells);
  if (!in.ok()) return false;
  uint16_t place = 0, material = 0;
  Counts so_far;
  for (size_t i = 0; i < cells.size(); ++i) {
    SvoCell& cell = cells[i] = {};
    place = static_cast<uint16_t>(place + unfold(places[i]));
    material = static_cast<uint16_t>(material + unfold(materials[i]));
    if (place > 511) return false;
    cell.place = place_of_morton(place);
    cell.material = material;
    cell.bricks = occupied[i];
    cell.voxels = voxels[i];
    cell.first_brick = so_far.bricks;
    cell.first_voxel = so_far.voxels;
    const auto own = static_cast<uint32_t>(std::popcount(cell.bricks));
    if (own > counts.bricks - so_far.bricks || cell.voxels > counts.voxels - so_far.voxels) {
      return false;
    }
    if (cell.voxels < own || cell.voxels > 64 * own) return false;
    so_far.bricks += own;
    so_far.voxels += cell.voxels;
  }
  return so_far.bricks == counts.bricks && so_far.voxels == counts.voxels;
}

// They must hold as many voxels as the cells say.
bool read_bricks(StreamReader& in, uint32_t block, Svo& svo) {
  const Counts counts = counts_of(svo, block);
  const uint64_t* brick = svo.bricks.data() + svo.blocks[block].first_brick;
  if (!read_masks(in, {svo.bricks.data() + svo.blocks[block].first_brick, counts.bricks})) {
    return false;
  }
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    int voxels = 0;
    for (int own = std::popcount(svo.cells[c].bricks); own > 0; --own) {
      voxels += std::popcount(*brick++);
    }
    if (voxels != svo.cells[c].voxels) return false;
  }
  return true;
}

}  // namespace

Counts counts_of(const Svo& svo, uint32_t block) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  Counts counts;
  counts.cells = next.first_cell - here.first_cell;
  counts.corners = next.first_corner - here.first_corner;
  counts.bricks = next.first_brick - here.first_brick;
  counts.voxels = next.first_voxel - here.first_voxel;
  counts.joints = next.first_joint - here.first_joint;
  counts.targets = next.first_target - here.first_target;
  return counts;
}

uint64_t skeleton_size(const Counts& counts, const PageFormat& format) {
  // Place, material, bricks, voxels, ranks of corners, attributes.
  uint64_t bytes = uint64_t{29} * counts.cells + uint64_t{2} * counts.joints;
  bytes += uint64_t{format.skinned ? 12u : 2u} * counts.corners;
  return bytes + counts.targets * (8 + uint64_t{6} * counts.corners);
}

uint64_t detail_size(const Counts& counts, const PageFormat& format) {
  // Which groups a brick has; a voxel's normal.
  uint64_t bytes = counts.bricks + uint64_t{2} * counts.voxels;
  if (format.colors) {
    bytes += uint64_t{3} * counts.voxels;
  } else {
    bytes += uint64_t{6} * counts.bricks + (uint64_t{counts.voxels} + 3) / 4;
  }
  return bytes + (format.levels ? uint64_t{6} * counts.bricks : 0);
}

void write_skeleton(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  write_cells(svo, block, out);
  write_level(svo.cell_level, here.first_cell, next.first_cell, Part::levels, out);
  write_lattice(svo, block, format, out);
}

bool read_skeleton(std::span<const uint8_t> bytes, uint32_t block, const PageFormat& format,
                   Svo& svo) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  StreamReader in(bytes);
  return read_cells(in, block, svo) &&
         read_level(in, here.first_cell, next.first_cell, svo.cell_level) &&
         read_lattice(in, block, format, svo) && in.at_end();
}

void write_detail(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  write_bricks(svo, block, out);
  write_voxels(svo, block, format, out);
  if (!format.levels) return;
  write_level(svo.brick_level, here.first_brick, next.first_brick, Part::levels, out);
}

bool read_detail(std::span<const uint8_t> bytes, uint32_t block, const PageFormat& format,
                 Svo& svo) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  StreamReader in(bytes);
  return read_bricks(in, block, svo) && read_voxels(in, block, format, svo) &&
         (!format.levels || read_level(in, here.first_brick, next.first_brick, svo.brick_level)) &&
         in.at_end();
}

}  // namespace sinew::svo_file
