// The bytes of one block of an octree before they are packed: two pages, its skeleton, which is
// enough to draw and to trace it by cells, and its detail, which needs the skeleton. Whatever can
// be told from something else is left out, and values are stored as what they differ by from a
// guess:
//
//   skeleton
//     cells    place (by Morton code, from the cell before it), material, bricks, count of voxels
//     level 3  normals, colours, spreads against the cell before
//     lattice  corner: place; which of the corners at its place a cell has; joints and weights
//              against a neighbour's; the palette; targets and their deltas
//   detail
//     bricks   which of its 2^3 groups of 2^3 voxels are not empty; group: its voxels
//     voxels   normals against the mean of those neighbours in the cell that come earlier; colours
//              likewise, or the ends of a brick's colours against those before, and the selectors
//     level 2  unless it follows from the voxels (see svo/file/file.h)
#pragma once

#include <cstdint>
#include <span>

#include "sinew/svo/file/streams.h"
#include "sinew/svo/format.h"

namespace sinew::svo_file {

// How much of everything lies in a block.
struct Counts {
  uint32_t cells = 0, corners = 0, bricks = 0, voxels = 0;
  uint32_t joints = 0, targets = 0;
};
inline constexpr size_t kCounts = sizeof(Counts) / sizeof(uint32_t);
Counts counts_of(const Svo& svo, uint32_t block);

// What holds for all blocks.
struct PageFormat {
  bool skinned = false;  // corners have joints and weights
  bool colors = true;    // each voxel has a colour of its own
  bool levels = true;    // level 2 is stored
};

// Bytes of a skeleton; of a detail but for the groups of its bricks, which are one to eight a
// brick.
uint64_t skeleton_size(const Counts& counts, const PageFormat& format);
uint64_t detail_size(const Counts& counts, const PageFormat& format);

// The block's arrays must be laid out as svo/format.h says.
void write_skeleton(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);
void write_detail(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);

// Fill the block's part of the arrays, which have their sizes; the block and the one after it are
// set, selectors of colours are 0, and for the detail the skeleton is read. False if the bytes do
// not make a block of these sizes. A level 2 that is not stored is left.
bool read_skeleton(std::span<const uint8_t> bytes, uint32_t block, const PageFormat& format,
                   Svo& svo);
bool read_detail(std::span<const uint8_t> bytes, uint32_t block, const PageFormat& format,
                 Svo& svo);

// The block's normals and colours of voxels (page_voxels.cpp). Reading needs bricks.
void write_voxels(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);
bool read_voxels(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo);

// Entries begin to end of a level, against the entry before each.
void write_level(const SvoLevel& level, size_t begin, size_t end, Part part, StreamWriter& out);
bool read_level(StreamReader& in, size_t begin, size_t end, SvoLevel& level);

// The block's corners and what moves them (page_lattice.cpp).
void write_lattice(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);
bool read_lattice(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo);

}  // namespace sinew::svo_file
