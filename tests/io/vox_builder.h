// Bytes of .vox files, chunk by chunk.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace sinew::test {

inline std::string vox_number(int32_t value) {
  const auto bits = static_cast<uint32_t>(value);
  std::string out;
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(bits >> shift & 0xff);
  return out;
}
inline std::string vox_text(const std::string& text) {
  return vox_number(static_cast<int32_t>(text.size())) + text;
}
using VoxEntries = std::vector<std::pair<std::string, std::string>>;
inline std::string vox_dictionary(const VoxEntries& entries) {
  std::string out = vox_number(static_cast<int32_t>(entries.size()));
  for (const auto& [key, value] : entries) out += vox_text(key) + vox_text(value);
  return out;
}
inline std::string vox_chunk(const std::string& id, const std::string& content) {
  return id + vox_number(static_cast<int32_t>(content.size())) + vox_number(0) + content;
}
inline std::string vox_file(const std::string& chunks, int32_t version = 200) {
  return "VOX " + vox_number(version) + "MAIN" + vox_number(0) +
         vox_number(static_cast<int32_t>(chunks.size())) + chunks;
}

// Voxels are x, y, z, colour.
inline std::string vox_model(int32_t x, int32_t y, int32_t z,
                             const std::vector<std::array<uint8_t, 4>>& voxels) {
  std::string content = vox_number(static_cast<int32_t>(voxels.size()));
  for (const auto& voxel : voxels) {
    for (const uint8_t byte : voxel) content += static_cast<char>(byte);
  }
  return vox_chunk("SIZE", vox_number(x) + vox_number(y) + vox_number(z)) +
         vox_chunk("XYZI", content);
}
// Frames are dictionaries with _r, _t, _f.
inline std::string vox_transform(int32_t id, int32_t child, const VoxEntries& attributes,
                                 const std::vector<VoxEntries>& frames, int32_t layer = -1) {
  std::string content = vox_number(id) + vox_dictionary(attributes) + vox_number(child) +
                        vox_number(-1) + vox_number(layer) +
                        vox_number(static_cast<int32_t>(frames.size()));
  for (const VoxEntries& frame : frames) content += vox_dictionary(frame);
  return vox_chunk("nTRN", content);
}
inline std::string vox_group(int32_t id, const std::vector<int32_t>& children) {
  std::string content =
      vox_number(id) + vox_dictionary({}) + vox_number(static_cast<int32_t>(children.size()));
  for (const int32_t child : children) content += vox_number(child);
  return vox_chunk("nGRP", content);
}
inline std::string vox_shape(int32_t id,
                             const std::vector<std::pair<int32_t, VoxEntries>>& models) {
  std::string content =
      vox_number(id) + vox_dictionary({}) + vox_number(static_cast<int32_t>(models.size()));
  for (const auto& [model, attributes] : models) {
    content += vox_number(model) + vox_dictionary(attributes);
  }
  return vox_chunk("nSHP", content);
}
inline std::string vox_material(int32_t color, const VoxEntries& entries) {
  return vox_chunk("MATL", vox_number(color) + vox_dictionary(entries));
}

}  // namespace sinew::test
