// The bytes of one block of an octree before they are packed: a page. Whatever can be told from
// something else is left out, and values are stored as what they differ by from a guess:
//
//   topology  cell: place (by Morton code, from the cell before it), bricks, material;
//             brick: which of its 2^3 groups of 2^3 voxels are not empty; group: its voxels
//   voxels    normals against the mean of those neighbours in the cell that come earlier; colours
//             likewise, or the ends of a brick's colours against those before, and the selectors
//   levels    2 and 3, unless they follow from the voxels (see svo/file.h)
//   lattice   corner: place; which of the corners at its place a cell has; joints and weights
//   against
//             a neighbour's; the palette; targets and their deltas
#pragma once

#include <cstdint>
#include <span>

#include "sinew/svo/format.h"
#include "sinew/svo/streams.h"

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
  bool levels = true;    // levels 2 and 3 are stored
};

// Bytes of a page but for the groups of its bricks, which are one to eight a brick.
uint64_t page_size(const Counts& counts, const PageFormat& format);

// The block's arrays must be laid out as svo/format.h says.
void write_page(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);

// Fills the block's part of the arrays, which have their sizes; the block and the one after it are
// set, selectors of colours are 0. False if the bytes do not make a block of these sizes. Levels
// that are not stored are left.
bool read_page(std::span<const uint8_t> bytes, uint32_t block, const PageFormat& format, Svo& svo);

// The block's normals and colours of voxels, and its levels (page_voxels.cpp). Reading needs the
// topology.
void write_voxels(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);
bool read_voxels(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo);
void write_levels(const Svo& svo, uint32_t block, StreamWriter& out);
bool read_levels(StreamReader& in, uint32_t block, Svo& svo);

// Entries begin to end of a level, against the entry before each.
void write_level(const SvoLevel& level, size_t begin, size_t end, Part part, StreamWriter& out);
bool read_level(StreamReader& in, size_t begin, size_t end, SvoLevel& level);

// The block's corners and what moves them (page_lattice.cpp).
void write_lattice(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out);
bool read_lattice(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo);

}  // namespace sinew::svo_file
