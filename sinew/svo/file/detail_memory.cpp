#include "sinew/svo/file/detail_memory.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "sinew/base/check.h"

namespace sinew {
namespace {

size_t page_size() {
  static const size_t size = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
  return size;
}
uintptr_t page_below(uintptr_t address) {
  return address & ~(uintptr_t{page_size()} - 1);
}
uintptr_t page_above(uintptr_t address) {
  return page_below(address + page_size() - 1);
}

// Whole pages within [begin, end) read as zero from here on and take no memory.
void forget(uintptr_t begin, uintptr_t end) {
  begin = page_above(begin), end = page_below(end);
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

// Gives `values` its size; at most kStep bytes of its memory are touched at a time, because a
// vector writes zeros, and given back.
template <class T>
void resize_untouched(std::vector<T>& values, size_t count) {
  constexpr size_t kStep = size_t{4} << 20;
  values.reserve(count);
  const auto base = reinterpret_cast<uintptr_t>(values.data());
  const uintptr_t first = page_above(base), last = page_below(base + count * sizeof(T));
  // A huge page would be taken and given back as a whole only.
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_NOHUGEPAGE);
  while (values.size() < count) {
    const size_t begin = values.size();
    values.resize(std::min(count, begin + kStep / sizeof(T)));
    forget(base + begin * sizeof(T), base + values.size() * sizeof(T));
  }
  forget(base, base + count * sizeof(T));
}

// The buffers in the order of regions; null where the octree has none.
std::array<const void*, 8> data_of(const Svo& svo) {
  return {svo.bricks.data(),
          svo.normals.data(),
          svo.colors.data(),
          svo.color_ends.data(),
          svo.color_selectors.data(),
          svo.brick_level.normals.data(),
          svo.brick_level.colors.data(),
          svo.brick_level.spreads.data()};
}

}  // namespace

template <class T>
void DetailMemory::add(std::vector<T>& values, size_t count, Unit unit) {
  resize_untouched(values, count);
  Region& region = regions_.emplace_back();
  region.base = reinterpret_cast<uint8_t*>(values.data());
  region.bytes = count * sizeof(T);
  region.item = sizeof(T);
  region.unit = unit;
  const auto base = reinterpret_cast<uintptr_t>(region.base);
  const size_t pages = (page_above(base + region.bytes) - page_below(base)) / page_size();
  region.users.assign(pages, 0);
}

DetailMemory::DetailMemory(const SvoIndex& index, Svo& svo) : blocks_(svo.blocks) {
  if (blocks_.empty()) return;
  const size_t bricks = blocks_.back().first_brick, voxels = blocks_.back().first_voxel;
  add(svo.bricks, bricks, Unit::brick);
  add(svo.normals, voxels, Unit::voxel);
  add(svo.colors, index.colors ? voxels : 0, Unit::voxel);
  add(svo.color_ends, index.colors ? 0 : bricks, Unit::brick);
  add(svo.color_selectors, index.colors ? 0 : (voxels + 15) / 16, Unit::selectors);
  add(svo.brick_level.normals, bricks, Unit::brick);
  add(svo.brick_level.colors, bricks, Unit::brick);
  add(svo.brick_level.spreads, bricks, Unit::brick);
}

DetailMemory::Range DetailMemory::items_of(const Region& region, uint32_t block) const {
  const SvoBlock &here = blocks_[block], &next = blocks_[block + 1];
  if (region.bytes == 0) return {};
  if (region.unit == Unit::brick) return {here.first_brick, next.first_brick};
  if (region.unit == Unit::voxel) return {here.first_voxel, next.first_voxel};
  return {here.first_voxel / 16, (size_t{next.first_voxel} + 15) / 16};
}

// Indices of `users`.
DetailMemory::Range DetailMemory::pages_of(const Region& region, uint32_t block) const {
  const Range items = items_of(region, block);
  if (items.begin == items.end) return {};
  const auto base = reinterpret_cast<uintptr_t>(region.base);
  const uintptr_t origin = page_below(base);
  return {(page_below(base + items.begin * region.item) - origin) / page_size(),
          (page_above(base + items.end * region.item) - origin) / page_size()};
}

uint64_t DetailMemory::missing_bytes(uint32_t block) const {
  uint64_t pages = 0;
  for (const Region& region : regions_) {
    const Range range = pages_of(region, block);
    for (size_t i = range.begin; i < range.end; ++i) pages += region.users[i] == 0 ? 1 : 0;
  }
  return pages * page_size();
}

uint64_t DetailMemory::bytes_of(uint32_t block) const {
  uint64_t pages = 0;
  for (const Region& region : regions_) {
    const Range range = pages_of(region, block);
    pages += range.end - range.begin;
  }
  return pages * page_size();
}

uint64_t DetailMemory::overhead() const {
  return 2 * regions_.size() * page_size();
}

void DetailMemory::take(uint32_t block) {
  in_use_ += missing_bytes(block);
  for (Region& region : regions_) {
    const Range range = pages_of(region, block);
    for (size_t i = range.begin; i < range.end; ++i) ++region.users[i];
  }
}

void DetailMemory::give_back(uint32_t block) {
  for (Region& region : regions_) {
    const Range range = pages_of(region, block);
    const auto base = reinterpret_cast<uintptr_t>(region.base);
    const uintptr_t origin = page_below(base);
    Range unused{range.end, range.begin};
    for (size_t i = range.begin; i < range.end; ++i) {
      SINEW_DCHECK(region.users[i] > 0);
      if (--region.users[i] != 0) continue;
      // Only pages at the ends are shared, so what is unused hangs together.
      unused = {std::min(unused.begin, i), i + 1};
      in_use_ -= page_size();
    }
    if (unused.begin >= unused.end) continue;
    // What lies beside the buffer in its first and last page is not ours.
    forget(std::max(base, origin + unused.begin * page_size()),
           std::min(base + region.bytes, origin + unused.end * page_size()));
  }
}

void DetailMemory::copy(uint32_t block, const Svo& alone) const {
  const std::array<const void*, 8> data = data_of(alone);
  const uint32_t first = blocks_[block].first_voxel, end = blocks_[block + 1].first_voxel;
  for (size_t r = 0; r < regions_.size(); ++r) {
    const Region& region = regions_[r];
    Range to = items_of(region, block);
    if (to.begin == to.end) continue;
    size_t from = region.unit == Unit::voxel ? first % 16 : 0;
    if (region.unit == Unit::selectors) {
      from = 1;
      ++to.begin;
      if (to.begin >= to.end) continue;
      if (end % 16 != 0) --to.end;
    }
    std::memcpy(region.base + to.begin * region.item,
                static_cast<const uint8_t*>(data[r]) + from * region.item,
                (to.end - to.begin) * region.item);
  }
}

const DetailMemory::Region* DetailMemory::find_selectors() const {
  const auto found = std::ranges::find_if(regions_, [](const Region& region) {
    return region.unit == Unit::selectors && region.bytes > 0;
  });
  return found == regions_.end() ? nullptr : &*found;
}

DetailMemory::Seam DetailMemory::seam_of(const Svo& alone) {
  if (alone.color_selectors.empty()) return {};
  return {alone.color_selectors.front(), alone.color_selectors.back()};
}

void DetailMemory::set_seam(uint32_t block, Seam seam) const {
  const Region* const region = find_selectors();
  if (region == nullptr) return;
  const uint32_t first = blocks_[block].first_voxel, end = blocks_[block + 1].first_voxel;
  auto* const words = reinterpret_cast<uint32_t*>(region->base);
  const auto put = [&](uint32_t word, uint32_t value) {
    const uint32_t from = std::max(first, 16 * word) % 16;
    const uint32_t count = std::min(end, 16 * word + 16) - 16 * word - from;
    const uint32_t mask = (count == 16 ? 0xffffffffu : (1u << (2 * count)) - 1) << (2 * from);
    words[word] = (words[word] & ~mask) | (value & mask);
  };
  put(first / 16, seam.first);
  if ((end - 1) / 16 != first / 16) put((end - 1) / 16, seam.last);
}

}  // namespace sinew
