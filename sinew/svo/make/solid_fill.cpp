#include "sinew/svo/make/solid_fill.h"

namespace sinew {
namespace {

constexpr uint32_t kSide = kBlockSide;

// Spreads bits over neighbouring open ones, to both sides.
uint64_t spread_along_row(uint64_t bits, uint64_t open) {
  uint64_t up = bits, down = bits, open_up = open, open_down = open;
  for (uint32_t step = 1; step < kSide; step *= 2) {
    up |= open_up & (up << step);
    open_up &= open_up << step;
    down |= open_down & (down >> step);
    open_down &= open_down >> step;
  }
  return up | down;
}

class Flood {
 public:
  Flood(const BlockGrid& grid, std::span<const int32_t> slot, std::span<const BlockBits> shell)
      : grid_(grid), slot_(slot), shell_(shell), queued_(grid.size(), 0) {
    out_.whole.assign(grid.size(), 0);
    out_.parts.assign(shell.size(), BlockBits{});
  }

  Outside run() {
    const uvec3 n = grid_.count;
    for (uint32_t z = 0; z < n.z; ++z) {
      for (uint32_t y = 0; y < n.y; ++y) {
        for (uint32_t x = 0; x < n.x; ++x) {
          const bool on_border =
              x == 0 || y == 0 || z == 0 || x + 1 == n.x || y + 1 == n.y || z + 1 == n.z;
          if (on_border) enqueue({x, y, z});
        }
      }
    }
    for (size_t next = 0; next < queue_.size(); ++next) visit(queue_[next]);
    return std::move(out_);
  }

 private:
  struct Faces {
    bool changed[6] = {};  // -x, +x, -y, +y, -z, +z
  };

  void enqueue(uvec3 block) {
    const uint32_t index = grid_.index(block);
    if (queued_[index] != 0 || out_.whole[index] != 0) return;
    queued_[index] = 1;
    queue_.push_back(block);
  }

  // The neighbour's row, all ones beyond the grid.
  uint64_t row(glm::ivec3 block, uint32_t y, uint32_t z) const {
    if (any(lessThan(block, glm::ivec3(0))) ||
        any(greaterThanEqual(block, glm::ivec3(grid_.count)))) {
      return ~uint64_t{0};
    }
    const uint32_t index = grid_.index(uvec3(block));
    if (slot_[index] != kNoShell)
      return out_.parts[static_cast<size_t>(slot_[index])][y + kSide * z];
    return out_.whole[index] != 0 ? ~uint64_t{0} : 0;
  }

  // What comes into the row from the blocks around.
  uint64_t entering(glm::ivec3 b, uint32_t y, uint32_t z) const {
    uint64_t bits = row({b.x - 1, b.y, b.z}, y, z) >> 63 | row({b.x + 1, b.y, b.z}, y, z) << 63;
    if (y == 0) bits |= row({b.x, b.y - 1, b.z}, kSide - 1, z);
    if (y == kSide - 1) bits |= row({b.x, b.y + 1, b.z}, 0, z);
    if (z == 0) bits |= row({b.x, b.y, b.z - 1}, y, kSide - 1);
    if (z == kSide - 1) bits |= row({b.x, b.y, b.z + 1}, y, 0);
    return bits;
  }

  void visit(uvec3 block) {
    const uint32_t index = grid_.index(block);
    queued_[index] = 0;
    if (out_.whole[index] != 0) return;
    const Faces faces = slot_[index] == kNoShell ? fill_whole(block) : fill_part(block);
    for (int face = 0; face < 6; ++face) {
      if (!faces.changed[face]) continue;
      glm::ivec3 other(block);
      other[face / 2] += face % 2 == 0 ? -1 : 1;
      if (other[face / 2] < 0 || other[face / 2] >= static_cast<int>(grid_.count[face / 2]))
        continue;
      enqueue(uvec3(other));
    }
  }

  Faces fill_whole(uvec3 block) {
    Faces faces;
    for (uint32_t z = 0; z < kSide; ++z) {
      for (uint32_t y = 0; y < kSide; ++y) {
        if (entering(glm::ivec3(block), y, z) == 0) continue;
        out_.whole[grid_.index(block)] = 1;
        for (bool& changed : faces.changed) changed = true;
        return faces;
      }
    }
    return faces;
  }

  Faces fill_part(uvec3 block) {
    const auto slot = static_cast<size_t>(slot_[grid_.index(block)]);
    const BlockBits &shell = shell_[slot], before = out_.parts[slot];
    BlockBits& bits = out_.parts[slot];
    for (uint32_t z = 0; z < kSide; ++z) {
      for (uint32_t y = 0; y < kSide; ++y) {
        const uint32_t i = y + kSide * z;
        bits[i] |= entering(glm::ivec3(block), y, z) & ~shell[i];
      }
    }
    bool changed = true;
    while (changed) {
      changed = false;
      for (uint32_t i = 0; i < bits.size(); ++i) changed |= grow_row(bits, shell, i);
      for (auto i = static_cast<uint32_t>(bits.size()); i-- > 0;)
        changed |= grow_row(bits, shell, i);
    }
    Faces faces;
    for (uint32_t i = 0; i < bits.size(); ++i) {
      const uint64_t is_new = bits[i] & ~before[i];
      if (is_new == 0) continue;
      const uint32_t y = i % kSide, z = i / kSide;
      faces.changed[0] |= (is_new & 1) != 0;
      faces.changed[1] |= is_new >> 63 != 0;
      faces.changed[2] |= y == 0;
      faces.changed[3] |= y == kSide - 1;
      faces.changed[4] |= z == 0;
      faces.changed[5] |= z == kSide - 1;
    }
    return faces;
  }

  static bool grow_row(BlockBits& bits, const BlockBits& shell, uint32_t i) {
    const uint32_t y = i % kSide, z = i / kSide;
    uint64_t grown = bits[i];
    if (y > 0) grown |= bits[i - 1];
    if (y + 1 < kSide) grown |= bits[i + 1];
    if (z > 0) grown |= bits[i - kSide];
    if (z + 1 < kSide) grown |= bits[i + kSide];
    grown = spread_along_row(grown & ~shell[i], ~shell[i]);
    const bool changed = grown != bits[i];
    bits[i] = grown;
    return changed;
  }

  BlockGrid grid_;
  std::span<const int32_t> slot_;
  std::span<const BlockBits> shell_;
  Outside out_;
  std::vector<uint8_t> queued_;
  std::vector<uvec3> queue_;
};

}  // namespace

Outside flood_from_outside(const BlockGrid& grid, std::span<const int32_t> slot,
                           std::span<const BlockBits> shell) {
  return Flood(grid, slot, shell).run();
}

}  // namespace sinew
