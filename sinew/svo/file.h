// An octree as bytes, to be kept and to be read by blocks: coarse levels and the table of blocks
// come first, then one page a block, each packed and checked on its own.
//
//   offset  bytes  little endian
//        0      4  "svo1"
//        4      4  flags: 1 corners have joints, 2 voxels have colours of their own, 4 levels 2 and
//        3
//                  are stored
//        8      8  size of the whole
//       16      8  size of the head unpacked
//       24      8  ... packed
//       32      8  XXH3-64 of the packed head
//       40      8  XXH3-64 of the bytes before this
//       48         head, packed: name, grid, morph weights, nodes with their attributes; of each
//                  block its place, its sizes, and its page's: unpacked, packed, XXH3-64
//        .         pages, one a block, in the blocks' order; see svo/page.h
//
// Packed means zstd, after values were made small (see svo/page.h). Levels 2 and 3 are left out
// where filter_levels() makes them from the voxels bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/svo/format.h"

namespace sinew {

// How an encoded octree's bytes divide.
struct SvoFileParts {
  uint64_t tables = 0;    // header, nodes with their attributes, places of blocks and pages
  uint64_t topology = 0;  // cells and masks
  uint64_t normals = 0, colors = 0;
  uint64_t levels = 0;   // attributes of levels 2 and 3
  uint64_t lattice = 0;  // corners, weights, morph targets

  void add(const SvoFileParts& other);
};

struct EncodedSvo {
  std::vector<uint8_t> bytes;
  SvoFileParts parts;  // they sum to bytes.size()
};

// `effort` is zstd's level, 1 to 19. An error (bad_input) if the octree is not laid out as
// svo/format.h says: what is returned has been read back.
Result<EncodedSvo> encode_svo(const Svo& svo, int effort);

// Where a block's page stands.
struct SvoPage {
  uint64_t offset = 0;  // in the encoded octree
  uint32_t unpacked = 0;
  uint32_t packed = 0;
  uint64_t checksum = 0;
};

// An encoded octree before its pages are read.
struct SvoIndex {
  Svo svo;                     // complete but for what pages hold: those arrays are empty
  std::vector<SvoPage> pages;  // one a block
  bool skinned = false;        // corners have joints
  bool colors = false;         // voxels have colours of their own
  bool levels = false;         // levels 2 and 3 are stored
  uint64_t bytes = 0;          // of memory that the octree will take
  SvoFileParts parts;
};

// Errors of these are bad_input; Error::file is the caller's to fill in. `limit`: bytes of memory.
Result<SvoIndex> decode_svo_index(std::span<const uint8_t> bytes, uint64_t limit);

// Gives the arrays of `index.svo` their sizes, so that pages can be decoded into it.
void allocate_pages(SvoIndex& index);

// Decodes one block into `svo`, whose arrays are as allocate_pages() leaves them. Different blocks
// may be decoded by different threads at the same time.
Result<void> decode_svo_page(const SvoIndex& index, std::span<const uint8_t> bytes, uint32_t block,
                             Svo& svo);

// Fills levels 2 and 3 of a block that is decoded, where the file leaves them out. To be called
// when no page is being decoded, for different blocks by different threads.
void fill_levels(const SvoIndex& index, uint32_t block, Svo& svo);

// The whole octree, valid. An error if a single bit differs from what encode_svo() gave.
Result<Svo> decode_svo(std::span<const uint8_t> bytes, uint64_t limit);

// Whether every bit is the same.
bool is_same(const Svo& a, const Svo& b);

// What the parts of an encoded octree take, from its index.
Result<SvoFileParts> parts_of_svo(std::span<const uint8_t> bytes, uint64_t limit);

}  // namespace sinew
