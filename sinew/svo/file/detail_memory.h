// DetailMemory: the buffers of an octree that hold what comes and goes (bricks, normals, colours,
// level 2), as address space whose memory is taken and given back block by block. Blocks share
// pages of memory at their ends: such a page stays while one of them is in use.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/svo/file/file.h"

namespace sinew {

class DetailMemory {
 public:
  DetailMemory() = default;
  // Gives the buffers of `svo`, which are empty, their sizes without taking memory for them. Moving
  // the octree is allowed from here on.
  DetailMemory(const SvoIndex& index, Svo& svo);

  // Bytes of memory that the block would take beside what is in use now.
  uint64_t missing_bytes(uint32_t block) const;
  // Bytes that it takes alone.
  uint64_t bytes_of(uint32_t block) const;
  uint64_t bytes_in_use() const { return in_use_; }
  // What may stay in memory though nothing is in use: the ends of the buffers.
  uint64_t overhead() const;

  // Counts the block's memory as in use.
  void take(uint32_t block);
  // And no longer; memory that nobody else uses is given back, and reads as zero from then on.
  void give_back(uint32_t block);

  // Copies a block that is alone in `alone`, whose voxels begin at its first one modulo 16: but for
  // the words of selectors that it shares with other blocks, so that these may be read meanwhile.
  // Different blocks may be copied by different threads.
  void copy(uint32_t block, const Svo& alone) const;
  // Those words: to be called when nobody reads.
  struct Seam {
    uint32_t first = 0, last = 0;
  };
  static Seam seam_of(const Svo& alone);
  void set_seam(uint32_t block, Seam seam) const;

 private:
  enum class Unit : uint8_t { brick, voxel, selectors };
  struct Region {
    uint8_t* base = nullptr;
    size_t bytes = 0;
    size_t item = 0;  // bytes; one a brick, a voxel, 16 voxels
    Unit unit = Unit::brick;
    std::vector<uint16_t> users;  // blocks in use, one a page of memory
  };
  struct Range {
    size_t begin = 0, end = 0;
  };
  template <class T>
  void add(std::vector<T>& values, size_t count, Unit unit);
  Range items_of(const Region& region, uint32_t block) const;
  Range pages_of(const Region& region, uint32_t block) const;
  const Region* find_selectors() const;

  std::vector<SvoBlock> blocks_;
  std::vector<Region> regions_;  // in the order of data_of()
  uint64_t in_use_ = 0;
};

}  // namespace sinew
