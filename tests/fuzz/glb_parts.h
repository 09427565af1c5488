// GLB files from their parts, so that mutations need not guess the lengths around them:
//
//   uint16 size of the JSON text | JSON text | buffer
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace sinew::fuzz {

inline std::string glb_number(size_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

inline std::string glb_chunk(std::string_view type, std::string_view bytes) {
  return glb_number(bytes.size()) + std::string(type) + std::string(bytes);
}

inline std::string make_glb(std::string_view parts) {
  if (parts.size() < 2) return {};
  const auto byte = [&](size_t i) { return size_t{static_cast<unsigned char>(parts[i])}; };
  const size_t json_size = std::min(byte(0) + 256 * byte(1), parts.size() - 2);
  const std::string body = glb_chunk("JSON", parts.substr(2, json_size)) +
                           glb_chunk(std::string_view("BIN\0", 4), parts.substr(2 + json_size));
  return "glTF" + glb_number(2) + glb_number(body.size() + 12) + body;
}

}  // namespace sinew::fuzz
