// What the head of an encoded octree is made of; see file.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "sinew/base/packing.h"
#include "sinew/svo/file/file.h"
#include "sinew/svo/file/page.h"

namespace sinew::svo_file {

static_assert(std::endian::native == std::endian::little);

inline constexpr uint32_t kMagic = 0x326f7673;       // "svo2"
inline constexpr uint32_t kFirstMagic = 0x316f7673;  // "svo1": one page a block
inline constexpr uint32_t kSkinned = 1, kColors = 2, kLevels = 4;
inline constexpr uint32_t kMostCorners = 1u << 16;  // of a block: cells name them by 16 bits

struct Header {
  uint32_t magic = kMagic;
  uint32_t flags = 0;
  uint64_t size = 0;
  uint64_t head_unpacked = 0;
  uint64_t head_packed = 0;
  uint64_t head_checksum = 0;
  uint64_t checksum = 0;
};
static_assert(sizeof(Header) == 48);

inline uint64_t checksum_of(const Header& header) {
  return checksum({reinterpret_cast<const uint8_t*>(&header), offsetof(Header, checksum)});
}

// What the head begins with.
struct HeadNumbers {
  uint32_t name = 0;                   // bytes
  uint32_t origin[3] = {}, voxel = 0;  // bits of floats
  uint32_t resolution[3] = {};
  uint32_t joints = 0, morph_targets = 0, morph_weights = 0;
  uint32_t root_level = 0;
  uint32_t nodes = 0, blocks = 0;  // entries of Svo::nodes and ::blocks
};
inline constexpr size_t kHeadNumbers = sizeof(HeadNumbers) / sizeof(uint32_t);

inline tl::unexpected<Error> damaged(std::string problem) {
  return fail({ErrorKind::bad_input, "", "", std::move(problem), "make the file again"});
}

inline constexpr size_t kStoredParts = kParts - 1;  // all but Part::tables
inline uint64_t* part_of(SvoFileParts& parts, Part part) {
  uint64_t* const all[] = {&parts.tables, &parts.topology, &parts.normals,
                           &parts.colors, &parts.levels,   &parts.lattice};
  return all[static_cast<size_t>(part)];
}

// The node or cell that the children of node i begin with, if nothing stands between those of the
// nodes before it and its own.
class FirstChild {
 public:
  uint32_t guess(const SvoNode& node) const {
    return node.level == kCellLevel + 1 ? next_cell_ : next_node_;
  }
  void add(const SvoNode& node) {
    (node.level == kCellLevel + 1 ? next_cell_ : next_node_) += node.count;
  }

 private:
  uint32_t next_node_ = 1, next_cell_ = 0;
};

}  // namespace sinew::svo_file
