// The header of a PLY file: which elements its body holds, row by row, and with which properties.
// Based on: Greg Turk, "The PLY Polygon File Format", 1994.
//
//   ply
//   format binary_little_endian 1.0
//   comment TextureFile skin.png        (as MeshLab and others name a texture)
//   element vertex 8
//   property float x                    one value a row
//   property list uchar int indices     a count and so many values a row
//   end_header
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"

namespace sinew {

enum class PlyFormat : uint8_t { ascii, little_endian, big_endian };
enum class PlyType : uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

// Bytes in a binary file.
uint32_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;        // of the value, or of a list's values
  std::optional<PlyType> count_type;  // of lists
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;  // rows; whatever the file claims
  std::vector<PlyProperty> properties;

  // The index of the property of that name and kind, or -1.
  int find(std::string_view property, bool list) const;
  // Bytes that a row takes at the least (all lists empty).
  uint64_t least_row(PlyFormat format) const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;   // of different names
  std::vector<std::string> textures;  // file names
  size_t size = 0;                    // bytes; the body follows
};

// `path` stands in errors.
Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& path);

}  // namespace sinew
