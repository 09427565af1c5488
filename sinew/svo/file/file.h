// An octree as bytes, to be kept and to be read by blocks: coarse levels and the table of blocks
// come first, then two pages a block, each packed and checked on its own.
//
//   offset  bytes  little endian
//        0      4  "svo2"
//        4      4  flags: 1 corners have joints, 2 voxels have colours of their own, 4 level 2 is
//                  stored
//        8      8  size of the whole
//       16      8  size of the head unpacked
//       24      8  ... packed
//       32      8  XXH3-64 of the packed head
//       40      8  XXH3-64 of the bytes before this
//       48         head, packed: name, grid, morph weights, nodes with their attributes; of each
//                  block its place, its sizes, and its pages': unpacked, packed, XXH3-64
//        .         skeletons, one a block, in the blocks' order: what is always in memory
//        .         details, likewise: what comes and goes (svo/file/stream.h); see svo/file/page.h
//
// Packed means zstd, after values were made small (see svo/file/page.h). Level 2 is left out where
// filter_brick_level() makes it from the voxels bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
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

// Where a page stands.
struct SvoPage {
  uint64_t offset = 0;  // in the encoded octree
  uint32_t unpacked = 0;
  uint32_t packed = 0;
  uint64_t checksum = 0;
};

// An encoded octree before its pages are read.
struct SvoIndex {
  Svo svo;                         // complete but for what pages hold: those arrays are empty
  std::vector<SvoPage> skeletons;  // one a block
  std::vector<SvoPage> details;    // one a block
  bool skinned = false;            // corners have joints
  bool colors = false;             // voxels have colours of their own
  bool levels = false;             // level 2 is stored
  uint64_t bytes = 0;              // of memory that the octree will take
  uint64_t detail_bytes = 0;       // of these, what details hold
  SvoFileParts parts;
};

// The same bytes as of encode_svo(), of an octree that comes in parts: octrees that hold blocks of
// it each, rising, on its grid. The pages go to the sinks at once; what stands before them in the
// encoded octree is known in the end.
class SvoEncoder {
 public:
  using Sink = std::function<Result<void>(std::span<const uint8_t>)>;
  SvoEncoder(int effort, Sink skeletons, Sink details)
      : effort_(effort), skeleton_sink_(std::move(skeletons)), detail_sink_(std::move(details)) {}

  // Errors are those of encode_svo() and of the sinks.
  Result<void> add(const Svo& part);
  // `outline`: what the whole octree is but for pages (see SvoIndex::svo), all of whose blocks have
  // been added. The bytes before the skeletons, with the parts of the whole.
  EncodedSvo finish(const Svo& outline);

 private:
  int effort_;
  Sink skeleton_sink_, detail_sink_;
  std::vector<SvoPage> skeletons_, details_;
  SvoFileParts parts_;
  bool skinned_ = false, colors_ = false;
};

// Errors of these are bad_input; Error::file is the caller's to fill in. `limit`: bytes of memory.
Result<SvoIndex> decode_svo_index(std::span<const uint8_t> bytes, uint64_t limit);

// The same by parts, for who reads them one by one: how many bytes of an octree's front make its
// index, from the first kSvoHeader; and the index from these, whose head may
// take `limit` bytes. `size` is the whole octree's.
inline constexpr size_t kSvoHeader = 48;
Result<uint64_t> svo_front(std::span<const uint8_t> header, uint64_t size);
Result<SvoIndex> decode_svo_front(std::span<const uint8_t> front, uint64_t size, uint64_t limit);

// Gives the arrays of `index.svo` their sizes, so that pages can be decoded into it: those of
// skeletons, or all.
void allocate_skeletons(SvoIndex& index);
void allocate_pages(SvoIndex& index);

// Decode one page of a block, from its own bytes, into `svo`, whose arrays are as allocate_pages()
// leaves them; a detail needs the skeleton. Different blocks may be decoded by different threads at
// the same time.
Result<void> decode_skeleton(const SvoIndex& index, std::span<const uint8_t> page, uint32_t block,
                             Svo& svo);
Result<void> decode_detail(const SvoIndex& index, std::span<const uint8_t> page, uint32_t block,
                           Svo& svo);
// The same into an octree that has it as its block 0.
Result<void> decode_detail_alone(const SvoIndex& index, std::span<const uint8_t> page,
                                 uint32_t block, Svo& svo);

// Fills level 2 of a block that is decoded, where the file leaves it out. To be called when no page
// is being decoded, for different blocks by different threads.
void fill_level(const SvoIndex& index, uint32_t block, Svo& svo);

// The whole octree, valid. An error if a single bit differs from what encode_svo() gave.
Result<Svo> decode_svo(std::span<const uint8_t> bytes, uint64_t limit);

// Whether every bit is the same.
bool is_same(const Svo& a, const Svo& b);

// What the parts of an encoded octree take, from its index.
Result<SvoFileParts> parts_of_svo(std::span<const uint8_t> bytes, uint64_t limit);

}  // namespace sinew
