// Numbers different keys in the order in which they come: a hash table without removal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew {

class KeyTable {
 public:
  static constexpr uint32_t kNone = 0xffffffffu;

  explicit KeyTable(size_t expected = 256) {
    size_t size = 64;
    while (size < 2 * expected) size *= 2;
    slots_.resize(size);
  }

  // The number of the key: that of the first time, or the next one.
  uint32_t number(uint64_t key) {
    Slot* slot = find(key);
    if (slot->number != kNone) return slot->number;
    *slot = {key, count_};
    if (2 * ++count_ > slots_.size()) grow();
    return count_ - 1;
  }
  uint32_t size() const { return count_; }

 private:
  struct Slot {
    uint64_t key = 0;
    uint32_t number = kNone;
  };

  Slot* find(uint64_t key) {
    const size_t mask = slots_.size() - 1;
    size_t at = (key * 0x9e3779b97f4a7c15ull) >> 32 & mask;
    while (slots_[at].number != kNone && slots_[at].key != key) at = (at + 1) & mask;
    return &slots_[at];
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.number != kNone) *find(slot.key) = slot;
    }
  }

  std::vector<Slot> slots_;
  uint32_t count_ = 0;
};

}  // namespace sinew
