// Normals and colours of voxels as differences from a guess: the mean of those of the 26 neighbours
// that come earlier in the cell, faces counting most. Voxels of a surface have three such
// neighbours or more; where there is none, the voxel before guesses.
#include <array>
#include <atomic>
#include <bit>
#include <cstring>

#include "sinew/svo/file/page.h"

namespace sinew::svo_file {
namespace {

constexpr size_t kComponents = 5;  // normal: two; colour: red, green, blue
constexpr uint8_t kMask[kComponents] = {0xff, 0xff, 0x1f, 0x3f, 0x1f};

using Values = std::array<uint8_t, kComponents>;

constexpr Values kFirstGuess{127, 127, 16, 32, 16};

Values values_of(uint16_t normal, uint16_t color) {
  return {static_cast<uint8_t>(normal), static_cast<uint8_t>(normal >> 8),
          static_cast<uint8_t>(color >> 11), static_cast<uint8_t>(color >> 5 & 0x3f),
          static_cast<uint8_t>(color & 0x1f)};
}
uint16_t normal_of(const Values& v) {
  return static_cast<uint16_t>(v[0] | v[1] << 8);
}
uint16_t color_of(const Values& v) {
  return static_cast<uint16_t>(v[2] << 11 | v[3] << 5 | v[4]);
}

// Differences wrap around. Those of red and blue are taken from half of green's: they change
// together where only the brightness does.
int signed_green(uint8_t difference) {
  return difference < 32 ? difference : difference - 64;
}
Values difference(const Values& value, const Values& guess) {
  Values d;
  for (size_t k = 0; k < kComponents; ++k) {
    d[k] = static_cast<uint8_t>((value[k] - guess[k]) & kMask[k]);
  }
  const int half = signed_green(d[3]) / 2;
  for (const size_t k : {2, 4}) d[k] = static_cast<uint8_t>((d[k] - half) & kMask[k]);
  return d;
}
Values sum(const Values& d, const Values& guess) {
  Values value;
  const int half = signed_green(d[3]) / 2;
  for (size_t k = 0; k < kComponents; ++k) {
    const int extra = k == 2 || k == 4 ? half : 0;
    value[k] = static_cast<uint8_t>((guess[k] + d[k] + extra) & kMask[k]);
  }
  return value;
}

struct Neighbor {
  int offset;  // in Guesser::grid_
  int weight;
};

// The values of a cell so far, with a margin of one voxel around it.
class Guesser {
 public:
  Guesser() {
    size_t next = 0;
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          if (x >= 0 && y >= 0 && z >= 0) continue;  // never comes earlier
          const int away = std::abs(x) + std::abs(y) + std::abs(z);
          neighbors_[next++] = {kStep[0] * x + kStep[1] * y + kStep[2] * z, away == 1   ? 4
                                                                            : away == 2 ? 2
                                                                                        : 1};
        }
      }
    }
  }

  void start_cell() { known_.fill(0); }

  // `at` as index_of() gives it.
  Values guess(size_t at) const {
    int total = 0;
    std::array<int, kComponents> sums{};
    for (const Neighbor& n : neighbors_) {
      const size_t where = static_cast<size_t>(static_cast<int>(at) + n.offset);
      if (!known_[where]) continue;
      total += n.weight;
      for (size_t k = 0; k < kComponents; ++k) sums[k] += n.weight * grid_[where][k];
    }
    if (total == 0) return last_;
    Values mean;
    for (size_t k = 0; k < kComponents; ++k) {
      mean[k] = static_cast<uint8_t>((sums[k] + total / 2) / total);
    }
    return mean;
  }
  void set(size_t at, const Values& value) {
    grid_[at] = value;
    known_[at] = 1;
    last_ = value;
  }

  static size_t index_of(uint32_t x, uint32_t y, uint32_t z) {
    return static_cast<size_t>(kStep[0]) * (x + 1) + static_cast<size_t>(kStep[1]) * (y + 1) +
           static_cast<size_t>(kStep[2]) * (z + 1);
  }

 private:
  static constexpr int kStep[3] = {1, 10, 100};
  std::array<Neighbor, 19> neighbors_;
  std::array<uint8_t, 1000> known_{};
  std::array<Values, 1000> grid_;
  Values last_ = kFirstGuess;
};

// Calls visit(index of the voxel, its place for the Guesser) for every voxel of the block,
// start() before every cell.
template <class Start, class Visit>
void for_each_voxel(const Svo& svo, uint32_t block, const Start& start, const Visit& visit) {
  size_t index = svo.blocks[block].first_voxel;
  const uint64_t* brick = svo.bricks.data() + svo.blocks[block].first_brick;
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    start();
    for (uint32_t slots = svo.cells[c].bricks; slots != 0; slots &= slots - 1) {
      const auto slot = static_cast<uint32_t>(std::countr_zero(slots));
      for (uint64_t bits = *brick++; bits != 0; bits &= bits - 1) {
        const auto bit = static_cast<uint32_t>(std::countr_zero(bits));
        visit(index++,
              Guesser::index_of(4 * (slot & 1) + (bit & 3), 4 * (slot >> 1 & 1) + (bit >> 2 & 3),
                                4 * (slot >> 2) + (bit >> 4)));
      }
    }
  }
}

constexpr size_t kEndBytes = 6;  // of a brick: red, green and blue of both ends

// The first end against that of the brick before, the second against the first.
void write_ends(const Svo& svo, uint32_t block, StreamWriter& out) {
  const Counts counts = counts_of(svo, block);
  const SvoColorEnds* const ends = svo.color_ends.data() + svo.blocks[block].first_brick;
  std::array<std::vector<uint8_t>, kEndBytes> planes;
  Values last = kFirstGuess;
  for (size_t i = 0; i < counts.bricks; ++i) {
    const Values a = values_of(0, ends[i].a), b = values_of(0, ends[i].b);
    const Values to_last = difference(a, last), to_first = difference(b, a);
    for (size_t k = 0; k < 3; ++k) {
      planes[k].push_back(to_last[k + 2]);
      planes[k + 3].push_back(to_first[k + 2]);
    }
    last = a;
  }
  for (const std::vector<uint8_t>& plane : planes) out.add(Part::colors, plane);
  out.add<uint8_t>(Part::colors, (size_t{counts.voxels} + 3) / 4, [&](size_t i) {
    uint32_t four = 0;
    for (size_t v = 4 * i; v < std::min<size_t>(4 * i + 4, counts.voxels); ++v) {
      const size_t at = svo.blocks[block].first_voxel + v;
      four |= (svo.color_selectors[at / 16] >> (2 * (at % 16)) & 3) << (2 * (v % 4));
    }
    return four;
  });
}

bool read_ends(StreamReader& in, uint32_t block, Svo& svo) {
  const Counts counts = counts_of(svo, block);
  SvoColorEnds* const ends = svo.color_ends.data() + svo.blocks[block].first_brick;
  std::array<std::vector<uint8_t>, kEndBytes> planes;
  for (std::vector<uint8_t>& plane : planes) plane = in.take<uint8_t>(counts.bricks);
  const std::vector<uint8_t> selectors = in.take<uint8_t>((size_t{counts.voxels} + 3) / 4);
  if (!in.ok()) return false;
  Values last = kFirstGuess;
  for (size_t i = 0; i < counts.bricks; ++i) {
    Values to_last{}, to_first{};
    for (size_t k = 0; k < 3; ++k) {
      to_last[k + 2] = planes[k][i];
      to_first[k + 2] = planes[k + 3][i];
    }
    last = sum(to_last, last);
    ends[i] = {color_of(last), color_of(sum(to_first, last))};
  }
  for (size_t v = 0; v < counts.voxels; ++v) {
    const size_t at = svo.blocks[block].first_voxel + v;
    const uint32_t selector = selectors[v / 4] >> (2 * (v % 4)) & 3;
    // Two blocks may have parts of one word.
    std::atomic_ref(svo.color_selectors[at / 16])
        .fetch_or(selector << (2 * (at % 16)), std::memory_order_relaxed);
  }
  return true;
}

}  // namespace

void write_voxels(const Svo& svo, uint32_t block, const PageFormat& format, StreamWriter& out) {
  const size_t count = counts_of(svo, block).voxels;
  std::array<std::vector<uint8_t>, kComponents> planes;
  for (std::vector<uint8_t>& plane : planes) plane.reserve(count);
  Guesser guesser;
  for_each_voxel(
      svo, block, [&] { guesser.start_cell(); },
      [&](size_t index, size_t at) {
        const uint16_t color = format.colors ? svo.colors[index] : uint16_t{0};
        const Values value = values_of(svo.normals[index], color);
        const Values d = difference(value, guesser.guess(at));
        for (size_t k = 0; k < kComponents; ++k) planes[k].push_back(d[k]);
        guesser.set(at, value);
      });
  for (size_t k = 0; k < (format.colors ? kComponents : 2); ++k) {
    out.add(k < 2 ? Part::normals : Part::colors, planes[k]);
  }
  if (!format.colors) write_ends(svo, block, out);
}

bool read_voxels(StreamReader& in, uint32_t block, const PageFormat& format, Svo& svo) {
  const size_t count = counts_of(svo, block).voxels;
  const size_t components = format.colors ? kComponents : 2;
  std::array<std::vector<uint8_t>, kComponents> planes;
  for (size_t k = 0; k < components; ++k) planes[k] = in.take<uint8_t>(count);
  if (!in.ok()) return false;
  size_t next = 0;
  Guesser guesser;
  for_each_voxel(
      svo, block, [&] { guesser.start_cell(); },
      [&](size_t index, size_t at) {
        Values d{};
        for (size_t k = 0; k < components; ++k) d[k] = planes[k][next];
        ++next;
        const Values value = sum(d, guesser.guess(at));
        svo.normals[index] = normal_of(value);
        if (format.colors) svo.colors[index] = color_of(value);
        guesser.set(at, value);
      });
  return format.colors || read_ends(in, block, svo);
}

void write_level(const SvoLevel& level, size_t begin, size_t end, Part part, StreamWriter& out) {
  std::vector<Values> differences;
  Values last = kFirstGuess;
  for (size_t i = begin; i < end; ++i) {
    const Values value = values_of(level.normals[i], level.colors[i]);
    differences.push_back(difference(value, last));
    last = value;
  }
  for (size_t k = 0; k < kComponents; ++k) {
    out.add<uint8_t>(part, differences.size(), [&](size_t i) { return differences[i][k]; });
  }
  out.add<uint8_t>(part, end - begin, [&](size_t i) {
    const int before = i == 0 ? 0 : level.spreads[begin + i - 1];
    return static_cast<uint8_t>(level.spreads[begin + i] - before);
  });
}

bool read_level(StreamReader& in, size_t begin, size_t end, SvoLevel& level) {
  std::array<std::vector<uint8_t>, kComponents> planes;
  for (std::vector<uint8_t>& plane : planes) plane = in.take<uint8_t>(end - begin);
  const std::vector<uint8_t> spreads = in.take<uint8_t>(end - begin);
  if (!in.ok()) return false;
  Values last = kFirstGuess;
  uint8_t spread = 0;
  for (size_t i = 0; i < end - begin; ++i) {
    Values d;
    for (size_t k = 0; k < kComponents; ++k) d[k] = planes[k][i];
    last = sum(d, last);
    level.normals[begin + i] = normal_of(last);
    level.colors[begin + i] = color_of(last);
    level.spreads[begin + i] = spread = static_cast<uint8_t>(spread + spreads[i]);
  }
  return true;
}

}  // namespace sinew::svo_file
