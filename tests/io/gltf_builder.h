// Makes small glTF assets in memory for tests: JSON that a test may change freely, and a buffer.
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hostile.h"
#include "sinew/io/gltf/gltf.h"

namespace sinew {

class GltfBuilder {
 public:
  nlohmann::json json = {{"asset", {{"version", "2.0"}}},
                         {"scene", 0},
                         {"scenes", {{{"nodes", nlohmann::json::array({0})}}}},
                         {"nodes", nlohmann::json::array()}};
  std::string bytes;

  // Appends the values to the buffer, aligned to 4 bytes; returns the buffer view's index.
  template <class T>
  int view(const std::vector<T>& values) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const size_t offset = bytes.size();
    const size_t size = values.size() * sizeof(T);
    bytes.resize(offset + size);
    if (size > 0) std::memcpy(bytes.data() + offset, values.data(), size);
    return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
  }

  // An accessor over the values, type "SCALAR", "VEC3", ...; returns its index.
  template <class T>
  int accessor(const std::vector<T>& values, const std::string& type, bool normalized = false) {
    nlohmann::json item = {{"bufferView", view(values)},
                           {"componentType", component_type(T())},
                           {"type", type},
                           {"count", values.size() / components(type)}};
    if (normalized) item["normalized"] = true;
    return add("accessors", item);
  }

  // Appends to a top-level array; returns the index.
  int add(const std::string& array, const nlohmann::json& item) {
    json[array].push_back(item);
    return static_cast<int>(json[array].size()) - 1;
  }

  // A node with a mesh of this one primitive; returns the node's index.
  int add_mesh_node(const nlohmann::json& primitive) {
    const int mesh = add("meshes", {{"primitives", nlohmann::json::array({primitive})}});
    return add("nodes", {{"mesh", mesh}});
  }
  // The triangle (0,0,0), (1,0,0), (0,1,0) as a mesh node.
  int add_triangle() {
    return add_mesh_node({{"attributes", {{"POSITION", triangle_positions()}}}});
  }
  int triangle_positions() { return accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3"); }

  std::string glb() const {
    nlohmann::json whole = json;
    if (!bytes.empty()) whole["buffers"][size_t{0}] = {{"byteLength", bytes.size()}};
    std::string text = whole.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string binary = bytes;
    binary.resize((binary.size() + 3) / 4 * 4);
    std::string body = chunk(0x4E4F534A, text);
    if (!binary.empty()) body += chunk(0x004E4942, binary);
    return u32(0x46546C67) + u32(2) + u32(static_cast<uint32_t>(body.size() + 12)) + body;
  }

  // A .gltf file with the buffer as a data URI.
  std::string gltf() const {
    nlohmann::json whole = json;
    if (!bytes.empty()) {
      whole["buffers"][size_t{0}] = {
          {"byteLength", bytes.size()},
          {"uri", "data:application/octet-stream;base64," + base64(bytes)}};
    }
    return whole.dump();
  }

  Result<Scene> load(const LoadOptions& options = {}) const {
    const TemporaryFolder folder;
    return load_gltf(folder.write("test.glb", glb()), options);
  }

  static std::string u32(uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  }
  static std::string chunk(uint32_t type, const std::string& data) {
    return u32(static_cast<uint32_t>(data.size())) + u32(type) + data;
  }

  static std::string base64(const std::string& data) {
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < data.size(); i += 3) {
      uint32_t bits = 0;
      for (size_t k = 0; k < 3; ++k) {
        bits = bits << 8 | (i + k < data.size() ? static_cast<uint8_t>(data[i + k]) : 0);
      }
      for (size_t k = 0; k < 4; ++k) {
        text += i + k > data.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
      }
    }
    return text;
  }

 private:
  static size_t components(const std::string& type) {
    if (type == "MAT4") return 16;
    return type == "SCALAR" ? 1 : static_cast<size_t>(type.back() - '0');
  }
  static int component_type(int8_t) { return 5120; }
  static int component_type(uint8_t) { return 5121; }
  static int component_type(int16_t) { return 5122; }
  static int component_type(uint16_t) { return 5123; }
  static int component_type(uint32_t) { return 5125; }
  static int component_type(float) { return 5126; }
};

// Loads, and fails the test if that fails or the scene is not valid.
inline Scene load_or_fail(const GltfBuilder& builder) {
  Result<Scene> scene = builder.load();
  if (!scene) {
    ADD_FAILURE() << scene.error().message();
    return {};
  }
  EXPECT_EQ(validate(*scene), "");
  return std::move(*scene);
}

// The message of the error that loading must end with.
inline std::string load_error(const GltfBuilder& builder, const LoadOptions& options = {}) {
  const Result<Scene> scene = builder.load(options);
  if (scene) return "(loaded without error)";
  EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
  EXPECT_FALSE(scene.error().file.empty());
  return scene.error().message();
}

// Whether `text` is contained in the message; prints both if not.
inline void expect_contains(const std::string& message, const std::string& text) {
  EXPECT_NE(message.find(text), std::string::npos) << "\"" << text << "\" not in: " << message;
}

}  // namespace sinew
