// glTF: a .glb or .gltf file as it is; or, if the first byte is 0, the parts of a GLB file without
// the lengths around them, so that mutations need not guess those:
//
//   0 | uint16 size of the JSON text | JSON text | buffer
#include "sinew/io/gltf/gltf.h"

#include <algorithm>

#include "fuzz.h"

namespace {

std::string u32(size_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

std::string chunk(std::string_view type, std::string_view bytes) {
  return u32(bytes.size()) + std::string(type) + std::string(bytes);
}

std::string make_glb(std::string_view parts) {
  if (parts.size() < 3) return {};
  const auto byte = [&](size_t i) { return size_t{static_cast<unsigned char>(parts[i])}; };
  const size_t json_size = std::min(byte(1) + 256 * byte(2), parts.size() - 3);
  const std::string body = chunk("JSON", parts.substr(3, json_size)) +
                           chunk(std::string_view("BIN\0", 4), parts.substr(3 + json_size));
  return "glTF" + u32(2) + u32(body.size() + 12) + body;
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view input = sinew::fuzz::as_text(data, size);
  const bool parts = size > 0 && data[0] == 0;
  sinew::fuzz::check_scene(sinew::parse_gltf(parts ? make_glb(input) : std::string(input),
                                             sinew::fuzz::kFolder + "a.glb",
                                             sinew::fuzz::kLimited));
  return 0;
}
