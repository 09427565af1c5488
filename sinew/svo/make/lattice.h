// The skin lattice: which sheets share a corner, and what moves it.
#pragma once

#include <span>
#include <vector>

#include "sinew/svo/make/sheets.h"

namespace sinew {

// Gives cells of solid filling that no triangle meets a point of the surface near them, from
// neighbour to neighbour, and its material.
void seed_inside(const LatticeSource& source, std::span<BlockSheets> blocks,
                 std::span<BlockPart> parts);

// Makes the corners of block `block`: around each lattice corner, the sheets of the at most eight
// cells there are joined where they have a vertex (or solid filling) in common; those that are
// joined, directly or by way of others, have one corner. `units`: of morph deltas, one a target.
// Reads the sheets of all blocks, writes only `part`. Corners on the faces between blocks come out
// the same from each.
void make_corners(const LatticeSource& source, std::span<const BlockSheets> blocks, size_t block,
                  std::span<const float> units, BlockPart& part);

// What all blocks of an octree have in common (make_svo.cpp).
Result<void> check_source(const SvoSource& source);
std::vector<float> delta_units(const LatticeSource& source);
SvoFrame frame_of(const LatticeSource& lattice, std::span<const float> units);

}  // namespace sinew
