// The corners of a block: which a cell has, and what moves them.
#include <algorithm>
#include <array>
#include <numeric>

#include "sinew/svo/file/page.h"

namespace sinew::svo_file {
namespace {

constexpr uint32_t kPlaces = 9 * 9 * 9;
constexpr uint32_t kWeightSum = 65535;

// The corners of a block by their places: several where sheets part.
class CornersByPlace {
 public:
  // Places must be below kPlaces.
  explicit CornersByPlace(std::span<const uint16_t> places) : order_(places.size()) {
    for (const uint16_t place : places) ++first_[place + size_t{1}];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::array<uint32_t, kPlaces> next;
    std::copy_n(first_.begin(), kPlaces, next.begin());
    for (size_t i = 0; i < places.size(); ++i) {
      order_[next[places[i]]++] = static_cast<uint16_t>(i);
    }
  }
  std::span<const uint16_t> at(uint32_t place) const {
    return std::span(order_).subspan(first_[place], first_[place + 1] - first_[place]);
  }

 private:
  std::array<uint32_t, kPlaces + 1> first_{};
  std::vector<uint16_t> order_;
};

uint32_t place_of_corner(const SvoCell& cell, uint32_t k) {
  const uint32_t x = (cell.place & 7u) + (k & 1), y = (cell.place >> 3 & 7u) + (k >> 1 & 1),
                 z = (cell.place >> 6 & 7u) + (k >> 2);
  return x + 9 * y + 81 * z;
}

// The corner before, at a place next to a corner's, that guesses its joints and weights.
class References {
 public:
  References() { last_.fill(-1); }
  // Of corner i of the block, -1 if none comes before it. To be called in order.
  int32_t next(uint16_t place) {
    const int32_t own = count_++;
    int32_t found = own - 1;
    for (const uint32_t step : {0u, 81u, 9u, 1u}) {
      if (place >= step && last_[place - step] >= 0) found = last_[place - step];
    }
    last_[place] = own;
    return found;
  }

 private:
  std::array<int32_t, kPlaces> last_;
  int32_t count_ = 0;
};

using Joints = std::array<uint8_t, kSvoInfluences>;
using Weights = std::array<uint16_t, kSvoInfluences>;

void write_skin(const Svo& svo, uint32_t block, StreamWriter& out) {
  const size_t count = counts_of(svo, block).corners, first = svo.blocks[block].first_corner;
  References references;
  std::vector<Joints> joints(count);
  std::vector<Weights> weights(count);
  for (size_t i = 0; i < count; ++i) {
    const int32_t reference = references.next(svo.corner_places[first + i]);
    joints[i] = svo.corner_joints[first + i];
    weights[i] = svo.corner_weights[first + i];
    if (reference < 0) continue;
    const size_t other = first + static_cast<size_t>(reference);
    const bool alike = joints[i] == svo.corner_joints[other];
    for (size_t k = 0; k < kSvoInfluences; ++k) {
      joints[i][k] ^= svo.corner_joints[other][k];
      if (!alike) continue;
      weights[i][k] = fold(static_cast<uint16_t>(weights[i][k] - svo.corner_weights[other][k]));
    }
  }
  for (size_t k = 0; k < kSvoInfluences; ++k) {
    out.add<uint8_t>(Part::lattice, count, [&](size_t i) { return joints[i][k]; });
  }
  for (size_t k = 1; k < kSvoInfluences; ++k) {  // the first is what the others leave
    out.add<uint16_t>(Part::lattice, count, [&](size_t i) { return weights[i][k]; });
  }
}

bool read_skin(StreamReader& in, uint32_t block, Svo& svo) {
  const size_t count = counts_of(svo, block).corners, first = svo.blocks[block].first_corner;
  std::array<std::vector<uint8_t>, kSvoInfluences> joints;
  std::array<std::vector<uint16_t>, kSvoInfluences> weights;
  for (size_t k = 0; k < kSvoInfluences; ++k) joints[k] = in.take<uint8_t>(count);
  for (size_t k = 1; k < kSvoInfluences; ++k) weights[k] = in.take<uint16_t>(count);
  if (!in.ok()) return false;
  References references;
  for (size_t i = 0; i < count; ++i) {
    const int32_t reference = references.next(svo.corner_places[first + i]);
    Joints& own_joints = svo.corner_joints[first + i];
    Weights& own_weights = svo.corner_weights[first + i];
    for (size_t k = 0; k < kSvoInfluences; ++k) own_joints[k] = joints[k][i];
    for (size_t k = 1; k < kSvoInfluences; ++k) own_weights[k] = weights[k][i];
    if (reference >= 0) {
      const size_t other = first + static_cast<size_t>(reference);
      for (size_t k = 0; k < kSvoInfluences; ++k) own_joints[k] ^= svo.corner_joints[other][k];
      const bool alike = own_joints == svo.corner_joints[other];
      for (size_t k = 1; alike && k < kSvoInfluences; ++k) {
        own_weights[k] =
            static_cast<uint16_t>(unfold(own_weights[k]) + svo.corner_weights[other][k]);
      }
    }
    const uint32_t others = uint32_t{own_weights[1]} + own_weights[2] + own_weights[3];
    if (others > kWeightSum) return false;
    own_weights[0] = static_cast<uint16_t>(kWeightSum - others);
  }
  return true;
}

void write_targets(const Svo& svo, uint32_t block, StreamWriter& out) {
  const Counts counts = counts_of(svo, block);
  const SvoTarget* const targets = svo.targets.data() + svo.blocks[block].first_target;
  out.add<uint32_t>(Part::lattice, counts.targets, [&](size_t i) { return targets[i].target; });
  out.add<uint32_t>(Part::lattice, counts.targets,
                    [&](size_t i) { return std::bit_cast<uint32_t>(targets[i].unit); });
  for (size_t t = 0; t < counts.targets; ++t) {
    const auto* const deltas = svo.deltas.data() + targets[t].first_delta;
    for (size_t axis = 0; axis < 3; ++axis) {
      out.add<uint16_t>(Part::lattice, counts.corners, [&](size_t i) {
        return fold(static_cast<uint16_t>(deltas[i][axis] - (i == 0 ? 0 : deltas[i - 1][axis])));
      });
    }
  }
}

bool read_targets(StreamReader& in, uint32_t block, Svo& svo) {
  const Counts counts = counts_of(svo, block);
  SvoTarget* const targets = svo.targets.data() + svo.blocks[block].first_target;
  const std::vector<uint32_t> numbers = in.take<uint32_t>(counts.targets);
  const std::vector<uint32_t> units = in.take<uint32_t>(counts.targets);
  if (!in.ok()) return false;
  for (size_t t = 0; t < counts.targets; ++t) {
    targets[t].target = numbers[t];  // first_delta is set with the sizes of the arrays
    targets[t].unit = std::bit_cast<float>(units[t]);
    auto* const deltas = svo.deltas.data() + targets[t].first_delta;
    for (size_t axis = 0; axis < 3; ++axis) {
      const std::vector<uint16_t> differences = in.take<uint16_t>(counts.corners);
      if (!in.ok()) return false;
      uint16_t value = 0;
      for (size_t i = 0; i < counts.corners; ++i) {
        value = static_cast<uint16_t>(value + unfold(differences[i]));
        deltas[i][axis] = static_cast<int16_t>(value);
      }
    }
  }
  return true;
}

bool read_corners(StreamReader& in, uint32_t block, Svo& svo) {
  const Counts counts = counts_of(svo, block);
  const std::span places(svo.corner_places.data() + svo.blocks[block].first_corner, counts.corners);
  const std::vector<uint16_t> differences = in.take<uint16_t>(counts.corners);
  const std::vector<uint16_t> ranks = in.take<uint16_t>(size_t{8} * counts.cells);
  if (!in.ok()) return false;
  uint16_t place = 0;
  for (size_t i = 0; i < counts.corners; ++i) {
    places[i] = place = static_cast<uint16_t>(place + unfold(differences[i]));
    if (place >= kPlaces) return false;
  }
  const CornersByPlace corners(places);
  for (size_t i = 0; i < ranks.size(); ++i) {
    SvoCell& cell = svo.cells[svo.blocks[block].first_cell + i / 8];
    const std::span<const uint16_t> choice =
        corners.at(place_of_corner(cell, static_cast<uint32_t>(i % 8)));
    if (ranks[i] >= choice.size()) return false;
    cell.corner[i % 8] = choice[ranks[i]];
  }
  return true;
}

}  // namespace

void write_lattice(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out) {
  const Counts counts = counts_of(svo, block);
  const std::span places(svo.corner_places.data() + svo.blocks[block].first_corner, counts.corners);
  out.add<uint16_t>(Part::lattice, counts.corners, [&](size_t i) {
    return fold(static_cast<uint16_t>(places[i] - (i == 0 ? 0 : places[i - 1])));
  });
  const CornersByPlace corners(places);
  out.add<uint16_t>(Part::lattice, size_t{8} * counts.cells, [&](size_t i) {
    const SvoCell& cell = svo.cells[svo.blocks[block].first_cell + i / 8];
    const std::span<const uint16_t> choice =
        corners.at(place_of_corner(cell, static_cast<uint32_t>(i % 8)));
    return static_cast<uint16_t>(std::ranges::find(choice, cell.corner[i % 8]) - choice.begin());
  });
  if (format.skinned) write_skin(svo, block, out);
  const uint16_t* const palette = svo.joint_palette.data() + svo.blocks[block].first_joint;
  out.add<uint16_t>(Part::lattice, counts.joints, [&](size_t i) {
    return fold(static_cast<uint16_t>(palette[i] - (i == 0 ? 0 : palette[i - 1])));
  });
  write_targets(svo, block, out);
}

bool read_lattice(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo) {
  if (!read_corners(in, block, svo)) return false;
  if (format.skinned && !read_skin(in, block, svo)) return false;
  const std::vector<uint16_t> palette = in.take<uint16_t>(counts_of(svo, block).joints);
  if (!in.ok()) return false;
  uint16_t joint = 0;
  for (size_t i = 0; i < palette.size(); ++i) {
    joint = static_cast<uint16_t>(joint + unfold(palette[i]));
    svo.joint_palette[svo.blocks[block].first_joint + i] = joint;
  }
  return read_targets(in, block, svo);
}

}  // namespace sinew::svo_file
