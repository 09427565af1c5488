// Octrees larger than memory, from triangles: runs of blocks in Morton order, as long as the memory
// allows, become octrees of their own, which together are the octree that make_svo() makes of the
// whole, bit for bit.
//
//   count fragments of each block -> runs -> for each run: voxels of its blocks, and of those that
//   touch them -> sheets -> corners of its own blocks -> an octree, taken by the caller
//
// Blocks around a run are voxelised again: corners look no further than one block.
#pragma once

#include <cstdint>
#include <functional>

#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/make/voxelize.h"

namespace sinew {

struct SvoPartsOptions {
  uint64_t memory = uint64_t{8} << 30;  // bytes, of which ...
  uint64_t standing = 0;                // ... so many are taken already
  // Called before each run, with the blocks that are done; false ends the work with an error.
  std::function<bool(size_t blocks_done, size_t blocks)> on_part;
  // Gets the octrees, one after the other. Each holds blocks, rising, and the nodes above them.
  std::function<Result<void>(const Svo& part)> take;
};

struct SvoPartsMade {
  Svo outline;  // the whole octree, but for what its blocks hold: those arrays are empty
  uint64_t parts = 0;
  uint64_t fragments = 0;
  uint64_t bytes = 0;  // of memory that the whole octree takes
};

// Solids are made as a whole. Errors: those of make_svo() and of `take`; runtime if the memory does
// not suffice, saying how much would.
Result<SvoPartsMade> make_svo_by_parts(SurfaceVoxelizer& surface, const SvoSource& source,
                                       const SvoPartsOptions& options);

}  // namespace sinew
