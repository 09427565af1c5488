// Normals and colours of voxels as differences from a guess: the mean of those of the 26 neighbours
// that come earlier in the cell, faces counting most. Voxels of a surface have three such
// neighbours or more; where there is none, the voxel before guesses.
#include <array>
#include <bit>
#include <cstring>

#include "sinew/svo/page.h"

namespace sinew::svo_file {
namespace {

constexpr size_t kComponents = 5;  // normal: two; colour: red, green, blue
constexpr uint8_t kMask[kComponents] = {0xff, 0xff, 0x1f, 0x3f, 0x1f};

using Values = std::array<uint8_t, kComponents>;

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
          const int away = std::abs(x) + std::abs(y) + std::abs(z);
          if (away == 0) continue;
          neighbors_[next++] = {kStep[0] * x + kStep[1] * y + kStep[2] * z,
                                away == 1   ? 4
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
  std::array<Neighbor, 26> neighbors_;
  std::array<uint8_t, 1000> known_{};
  std::array<Values, 1000> grid_;
  Values last_{127, 127, 16, 32, 16};
};

// Calls visit(index in the level's arrays, its place for the Guesser) for every voxel of the block,
// start() before every cell.
template <class Start, class Visit>
void for_each_voxel(const Svo& svo, uint32_t block, const Start& start, const Visit& visit) {
  size_t index = svo.blocks[block].first_voxel[0];
  const uint64_t* brick = svo.bricks.data() + svo.blocks[block].first_brick;
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    start();
    for (uint32_t slots = svo.cells[c].bricks; slots != 0; slots &= slots - 1) {
      const auto slot = static_cast<uint32_t>(std::countr_zero(slots));
      for (uint64_t bits = *brick++; bits != 0; bits &= bits - 1) {
        const auto bit = static_cast<uint32_t>(std::countr_zero(bits));
        visit(index++, Guesser::index_of(4 * (slot & 1) + (bit & 3),
                                         4 * (slot >> 1 & 1) + (bit >> 2 & 3),
                                         4 * (slot >> 2) + (bit >> 4)));
      }
    }
  }
}

}  // namespace

void write_voxels(const Svo& svo, uint32_t block, StreamWriter& out) {
  const size_t count = counts_of(svo, block).voxels[0];
  std::array<std::vector<uint8_t>, kComponents> planes;
  for (std::vector<uint8_t>& plane : planes) plane.reserve(count);
  Guesser guesser;
  for_each_voxel(
      svo, block, [&] { guesser.start_cell(); },
      [&](size_t index, size_t at) {
        const Values value = values_of(svo.levels[0].normals[index], svo.levels[0].colors[index]);
        const Values d = difference(value, guesser.guess(at));
        for (size_t k = 0; k < kComponents; ++k) planes[k].push_back(d[k]);
        guesser.set(at, value);
      });
  for (size_t k = 0; k < kComponents; ++k) {
    out.add(k < 2 ? Part::normals : Part::colors, planes[k]);
  }
}

bool read_voxels(StreamReader& in, uint32_t block, Svo& svo) {
  const size_t count = counts_of(svo, block).voxels[0];
  std::array<std::vector<uint8_t>, kComponents> planes;
  for (std::vector<uint8_t>& plane : planes) plane = in.take<uint8_t>(count);
  if (!in.ok()) return false;
  size_t next = 0;
  Guesser guesser;
  for_each_voxel(
      svo, block, [&] { guesser.start_cell(); },
      [&](size_t index, size_t at) {
        Values d;
        for (size_t k = 0; k < kComponents; ++k) d[k] = planes[k][next];
        ++next;
        const Values value = sum(d, guesser.guess(at));
        svo.levels[0].normals[index] = normal_of(value);
        svo.levels[0].colors[index] = color_of(value);
        guesser.set(at, value);
      });
  return true;
}

void write_level(const SvoLevel& level, size_t begin, size_t end, Part part, StreamWriter& out) {
  std::vector<Values> differences;
  Values last{127, 127, 16, 32, 16};
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
  Values last{127, 127, 16, 32, 16};
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

void write_levels(const Svo& svo, uint32_t block, StreamWriter& out) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  for (int level = 1; level < 3; ++level) {
    write_level(svo.levels[level], here.first_voxel[level], next.first_voxel[level],
                Part::levels, out);
  }
  write_level(svo.cell_level, here.first_cell, next.first_cell, Part::levels, out);
}

bool read_levels(StreamReader& in, uint32_t block, Svo& svo) {
  const SvoBlock &here = svo.blocks[block], &next = svo.blocks[block + 1];
  for (int level = 1; level < 3; ++level) {
    if (!read_level(in, here.first_voxel[level], next.first_voxel[level], svo.levels[level])) {
      return false;
    }
  }
  return read_level(in, here.first_cell, next.first_cell, svo.cell_level);
}

}  // namespace sinew::svo_file
