#include "sinew/scene/procedural/cloth_meetings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kPointsPerTask = 2048;

// Of what is missing between two points, what one of them makes good in a step: less than half,
// since a point has about three such partners in the layer beside it.
constexpr float kShare = 0.33f;

// Slots from one cell to the next along y and z. Cells that are neighbours in both never share a
// slot; cells that do are far apart, so only time is lost.
constexpr uint32_t kAlongY = 163, kAlongZ = 163 * 89, kLeastSlots = 1u << 16;

}  // namespace

ClothMeetings::ClothMeetings(const Config& config, const GridPoints& points)
    : distance_(0.9f * config.spacing),
      reach_(1.45f * config.spacing),
      friction_(config.friction),
      slot_begin_(std::max<size_t>(kLeastSlots, std::bit_ceil(2 * points.size())) + 3),
      entries_(points.size()),
      slot_(points.size()),
      partners_(kMost * points.size()),
      partner_count_(points.size()),
      places_(points.size()),
      corrections_(points.size()) {}

uint32_t ClothMeetings::slot_of(vec3 p) const {
  const glm::ivec3 cell(glm::floor(p * (1.0f / reach_)));
  const uint32_t slot = static_cast<uint32_t>(cell.x) + kAlongY * static_cast<uint32_t>(cell.y) +
                        kAlongZ * static_cast<uint32_t>(cell.z);
  return slot & static_cast<uint32_t>(slot_begin_.size() - 4);
}

void ClothMeetings::sort_into_slots(const GridPoints& points) {
  parallel_for(points.size(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) slot_[i] = slot_of(points.at(i));
  });
  std::ranges::fill(slot_begin_, 0);
  for (const uint32_t slot : slot_) ++slot_begin_[slot];
  for (size_t s = 1; s < slot_begin_.size(); ++s) slot_begin_[s] += slot_begin_[s - 1];
  // Now the ends of the slots; filling them from behind turns them into their beginnings.
  size_t i = points.size();
  for (uint32_t row = points.columns(); row-- > 0;) {
    for (uint32_t column = points.columns(); column-- > 0;) {
      --i;
      entries_[--slot_begin_[slot_[i]]] = {points.at(i), static_cast<uint16_t>(row),
                                           static_cast<uint16_t>(column)};
    }
  }
}

// Nobody new can have come within distance_ if no point moved by half of what reach_ is more.
bool ClothMeetings::still_valid(const GridPoints& points) const {
  if (searched_at_.size() != points.size()) return false;
  const float most = 0.5f * (reach_ - distance_);
  for (size_t i = 0; i < points.size(); ++i) {
    const vec3 way = points.at(i) - searched_at_[i];
    if (dot(way, way) > most * most) return false;
  }
  return true;
}

void ClothMeetings::search(const GridPoints& points) {
  if (still_valid(points)) return;
  searched_at_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i) searched_at_[i] = points.at(i);
  sort_into_slots(points);
  const auto mask = static_cast<uint32_t>(slot_begin_.size() - 4);
  parallel_for(entries_.size(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t e = begin; e < end; ++e) {
      const Entry& self = entries_[e];
      const size_t i = size_t{self.row} * points.columns() + self.column;
      const uint32_t left = slot_[i] - kAlongY - kAlongZ - 1;
      uint32_t count = 0;
      const auto consider = [&](const Entry& other) {
        const vec3 d = self.point - other.point;
        if (dot(d, d) >= reach_ * reach_ || count == kMost) return;
        const bool beside =
            std::abs(self.row - other.row) <= 2 && std::abs(self.column - other.column) <= 2;
        if (beside) return;
        partners_[kMost * i + count++] = other.row * points.columns() + other.column;
      };
      for (uint32_t run = 0; run < 9; ++run) {  // three cells along x each
        const uint32_t first = (left + run % 3 * kAlongY + run / 3 * kAlongZ) & mask;
        const uint32_t stop = slot_begin_[first + 3];
        for (uint32_t k = slot_begin_[first]; k < stop; ++k) consider(entries_[k]);
        if (first + 2 <= mask) continue;  // else the run goes on at the first slots
        const uint32_t rest = slot_begin_[first + 2 - mask];
        for (uint32_t k = 0; k < rest; ++k) consider(entries_[k]);
      }
      partner_count_[i] = static_cast<uint8_t>(count);
    }
  });
}

void ClothMeetings::push(GridPoints& points, GridPoints& before) {
  parallel_for(points.size(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) places_[i] = {points.at(i), before.at(i)};
  });
  parallel_for(points.size(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Correction sum;
      for (uint32_t k = 0; k < partner_count_[i]; ++k) {
        const Place& other = places_[partners_[kMost * i + k]];
        const vec3 d = places_[i].now - other.now;
        const float squared = dot(d, d);
        if (squared >= distance_ * distance_ || squared == 0.0f) continue;
        const float length = std::sqrt(squared);
        const vec3 d_before = places_[i].before - other.before;
        const float missing = distance_ - length;
        const float missing_before = distance_ - std::sqrt(dot(d_before, d_before));
        sum.push += (kShare * missing / length) * d - kShare * friction_ * (d - d_before);
        sum.shift += (kShare * std::clamp(missing_before, 0.0f, missing) / length) * d;
      }
      corrections_[i] = sum;
    }
  });
  parallel_for(points.size(), kPointsPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (partner_count_[i] == 0) continue;
      points.set(i, points.at(i) + corrections_[i].push);
      before.set(i, before.at(i) + corrections_[i].shift);
    }
  });
}

}  // namespace sinew
