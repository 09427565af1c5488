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

// Errors (bad_input) name no file.
Result<Sections> find_sections(std::span<const uint8_t> bytes);

// Header and table of a file with these sections.
std::vector<uint8_t> make_header(const Sections& sections);

// The scene's section from its GLB, and back.
std::vector<uint8_t> pack_scene(std::span<const uint8_t> glb, int effort);
Result<std::vector<uint8_t>> unpack_scene(std::span<const uint8_t> section, uint64_t limit);

}  // namespace sinew::svo_file
