#include "bench/contest.h"

#include "bench/measure.h"

namespace sinew::bench {

double Rival::median_ms() const {
  return median(ms);
}

uint32_t compete(std::span<Rival> rivals, const Rounds& rounds, uint32_t first_frame,
                 const std::function<void(uint32_t)>& prepare) {
  uint32_t frame = first_frame;
  for (uint32_t round = 0; round < rounds.warmups + rounds.repeats; ++round, ++frame) {
    if (prepare) prepare(frame);
    for (size_t k = 0; k < rivals.size(); ++k) {
      Rival& rival = rivals[(k + round) % rivals.size()];
      const double ms = milliseconds([&] { rival.run(frame); });
      if (round >= rounds.warmups) rival.ms.push_back(ms);
    }
  }
  return frame;
}

const Rival* best_of(std::span<const Rival> rivals, std::string_view prefix) {
  const Rival* best = nullptr;
  for (const Rival& rival : rivals) {
    if (!rival.name.starts_with(prefix)) continue;
    if (best == nullptr || rival.median_ms() < best->median_ms()) best = &rival;
  }
  return best;
}

const Rival* find(std::span<const Rival> rivals, std::string_view name) {
  for (const Rival& rival : rivals) {
    if (rival.name == name) return &rival;
  }
  return nullptr;
}

}  // namespace sinew::bench
