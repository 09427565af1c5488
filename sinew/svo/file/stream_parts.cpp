// Pictures in parts: each block that they show is there in one of them.
#include "sinew/base/check.h"
#include "sinew/svo/file/stream.h"

namespace sinew {

void PagedSvo::begin_parts() {
  recall();
  wait_until_read();
  publish();
  collect();
  in_parts_ = true;
  drawn_.assign(state_.size(), 0);
  ++stats_.parts;
}

BlockShown PagedSvo::shown(uint32_t block) const {
  if (in_parts_ && drawn_[block] != 0) return BlockShown::drawn;
  if (resident_[block] != 0) return BlockShown::detail;
  return in_parts_ && state_[block] != State::damaged ? BlockShown::later : BlockShown::cells;
}

bool PagedSvo::end_part() {
  SINEW_CHECK(in_parts_);
  for (size_t b = 0; b < state_.size(); ++b) {
    if (state_[b] == State::resident || state_[b] == State::damaged) drawn_[b] = 1;
  }
  if (!collect()) ++frame_;  // what earlier parts asked for is not wanted any more
  stats_.missing = static_cast<uint32_t>(wanted().size());
  return stats_.missing > 0;
}

// Pages that blocks share are counted twice.
bool PagedSvo::part_fits() const {
  uint64_t bytes = memory_.bytes_in_use();
  for (const uint32_t block : wanted()) bytes += memory_.missing_bytes(block);
  return bytes <= room();
}

void PagedSvo::read_part() {
  const uint64_t before = stats_.loaded + stats_.damaged;
  read_all();
  // All that was there is drawn and makes room, and the least budget has room for any block.
  SINEW_CHECK(stats_.loaded + stats_.damaged > before);
  ++stats_.parts;
}

namespace {

template <class F>
void for_each_settling(std::span<const Svo> octrees, const F& call) {
  for (const Svo& svo : octrees) {
    if (svo.paging && svo.paging->settles()) call(*svo.paging.operator->());
  }
}

}  // namespace

bool begin_parts(std::span<const Svo> octrees) {
  bool any = false;
  for_each_settling(octrees, [&](PagedSvo& paging) {
    paging.begin_parts();
    any = true;
  });
  return any;
}

bool end_part(std::span<const Svo> octrees) {
  bool more = false;
  for_each_settling(octrees, [&](PagedSvo& paging) { more |= paging.end_part(); });
  return more;
}

bool part_fits(std::span<const Svo> octrees) {
  bool fits = true;
  for_each_settling(octrees, [&](PagedSvo& paging) { fits &= paging.part_fits(); });
  return fits;
}

void read_part(std::span<const Svo> octrees) {
  for_each_settling(octrees, [](PagedSvo& paging) {
    if (paging.stats().missing > 0) paging.read_part();
  });
}

void end_parts(std::span<const Svo> octrees) {
  for_each_settling(octrees, [](PagedSvo& paging) { paging.end_parts(); });
}

}  // namespace sinew
