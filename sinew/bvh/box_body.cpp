#include "sinew/bvh/box_body.h"

#include <thread>

namespace sinew {
namespace {

// Waits for something that takes a microsecond or two, unless its thread was put to sleep.
template <class Done>
void wait_until(const Done& done) {
  for (uint32_t i = 0; !done(); ++i) {
    if (i >= 256) std::this_thread::yield();
  }
}

}  // namespace

void raise_wish(std::atomic<uint32_t>& wish, uint32_t bits) {
  uint32_t before = wish.load(std::memory_order_relaxed);
  while (before < bits && !wish.compare_exchange_weak(before, bits, std::memory_order_relaxed)) {
  }
}

bool make_box_part(const BoxBody& body, uint32_t part) {
  const std::atomic_ref state(body.part_state[part]);
  const uint32_t being_made = 2 * body.epoch, made = being_made + 1;
  uint32_t seen = state.load(std::memory_order_acquire);
  while (seen != made) {
    if (seen == being_made) {
      wait_until([&] { return state.load(std::memory_order_acquire) == made; });
      return false;
    }
    if (!state.compare_exchange_weak(seen, being_made, std::memory_order_acquire)) continue;
    body.make_part(body.context, part);
    state.store(made, std::memory_order_release);
    return true;
  }
  return false;
}

bool make_box_detail(const BoxBody& body, uint32_t detail, uint32_t level) {
  BoxDetail& d = body.details[detail];
  const std::atomic_ref state(d.made);
  const uint32_t claim = 256u << level;
  if ((state.fetch_or(claim, std::memory_order_acquire) & claim) != 0) {
    wait_until([&] { return (state.load(std::memory_order_acquire) >> level & 1) != 0; });
    return false;
  }
  d.root[level] = body.make_detail(body.context, detail, level);
  state.fetch_or(1u << level, std::memory_order_release);
  return true;
}

}  // namespace sinew
