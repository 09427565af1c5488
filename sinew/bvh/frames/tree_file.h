// Trees as bytes, to be kept from one run to the next: a cache that is checked throughout, so that
// it is either as it was written or refused.
//
//   offset  bytes  little endian
//        0      8  "sinewtre"
//        8      4  version (1)
//       12      4  bodies
//       16      8  key: a hash of what the trees were made for (the caller's)
//       24      4  clip: an index, -1: the rest pose, -2: all clips
//       28      4  0
//       32      8  size of the whole
//       40      8  XXH3-64 of everything else
//       48         a body: primitives (4), trees (4); of each tree: begin (8, seconds), nodes (4),
//                  0 (4), TreeNodes (8 each), primitives (4 each), areas (4 each)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/tree.h"

namespace sinew {

struct TreeFile {
  static constexpr int32_t kAllClips = -2;
  uint64_t key = 0;
  int32_t clip = kAllClips;                    // an index, or -1: the rest pose
  std::vector<std::vector<TimedTree>> bodies;  // at least one tree a body; their times rise
};

std::vector<uint8_t> encode_trees(const TreeFile& trees);

// An error if a single bit differs from what encode_trees() wrote, or if what it wrote were no
// trees. Error::file is the caller's to fill in.
Result<TreeFile> decode_trees(std::span<const uint8_t> bytes);

}  // namespace sinew
