// Bytes made smaller and back: zstd behind two functions, and checksums.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"

namespace sinew {

// XXH3-64.
uint64_t checksum(std::span<const uint8_t> bytes);

struct Packed {
  std::vector<uint8_t> bytes;
  std::vector<size_t> ends;  // of each kind in `bytes`, as near as can be told; the last is the end
};

// One zstd frame. `ends` (rising) are where one kind of bytes ends and the next begins: each kind
// is coded by its own statistics. `effort` is zstd's level, 1 to 19.
Packed pack(std::span<const uint8_t> bytes, std::span<const size_t> ends, int effort);

// The most that `packed` bytes can become.
uint64_t most_unpacked(uint64_t packed);

// Fills `out`; false if the bytes are not a frame of exactly as many.
bool unpack(std::span<const uint8_t> packed, std::span<uint8_t> out);

}  // namespace sinew
