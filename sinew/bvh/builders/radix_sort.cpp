// Least significant digit first, as N. Satish, M. Harris, M. Garland, "Designing Efficient Sorting
// Algorithms for Manycore GPUs", 2009, do on chunks: count digits a chunk, add up over chunks,
// scatter.
#include "sinew/bvh/builders/radix_sort.h"

#include <array>
#include <utility>

#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr int kDigitBits = 10, kPasses = 3;
constexpr uint32_t kDigits = 1u << kDigitBits;
constexpr size_t kChunk = size_t{1} << 17;  // items: their counts fit into the cache beside them

using Counts = std::array<uint32_t, kDigits>;

// Counts become the places where a chunk's first item of each digit goes.
void add_up(std::vector<Counts>& chunks) {
  uint32_t sum = 0;
  for (uint32_t digit = 0; digit < kDigits; ++digit) {
    for (Counts& counts : chunks) sum += std::exchange(counts[digit], sum);
  }
}

}  // namespace

void radix_sort(std::vector<CodedPrimitive>& items, std::vector<CodedPrimitive>& scratch) {
  scratch.resize(items.size());
  std::vector<Counts> chunks((items.size() + kChunk - 1) / kChunk);
  for (int pass = 0; pass < kPasses; ++pass) {
    const int shift = pass * kDigitBits;
    const auto digit = [shift](uint32_t code) { return (code >> shift) & (kDigits - 1); };
    parallel_for(items.size(), kChunk, [&](size_t begin, size_t end) {
      Counts& counts = chunks[begin / kChunk];
      counts.fill(0);
      for (size_t i = begin; i < end; ++i) ++counts[digit(items[i].code)];
    });
    add_up(chunks);
    parallel_for(items.size(), kChunk, [&](size_t begin, size_t end) {
      Counts& places = chunks[begin / kChunk];
      for (size_t i = begin; i < end; ++i) scratch[places[digit(items[i].code)]++] = items[i];
    });
    items.swap(scratch);
  }
}

}  // namespace sinew
