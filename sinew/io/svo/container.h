// The sections of a .svo file; see svo.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::svo_file {

struct Sections {
  std::span<const uint8_t> scene;                 // packed
  std::vector<std::span<const uint8_t>> octrees;  // encoded
};

struct SectionPlace {
  uint64_t offset = 0;  // in the file
  uint64_t size = 0;
};
struct SectionTable {
  SectionPlace scene;
  std::vector<SectionPlace> octrees;
};

// For who reads a file of `size` bytes part by part: where its table ends, from the first
// kContainerHeader bytes; and the table from the bytes before that. Errors (bad_input) name no
// file.
inline constexpr size_t kContainerHeader = 32;
Result<uint64_t> table_end(std::span<const uint8_t> bytes, uint64_t size);
Result<SectionTable> read_table(std::span<const uint8_t> bytes, uint64_t size);

// Errors (bad_input) name no file.
Result<Sections> find_sections(std::span<const uint8_t> bytes);

// Header and table of a file with sections of these sizes, in bytes.
std::vector<uint8_t> make_header(uint64_t scene, std::span<const uint64_t> octrees);

// The scene's section from its GLB, and back.
std::vector<uint8_t> pack_scene(std::span<const uint8_t> glb, int effort);
Result<std::vector<uint8_t>> unpack_scene(std::span<const uint8_t> section, uint64_t limit);

}  // namespace sinew::svo_file
