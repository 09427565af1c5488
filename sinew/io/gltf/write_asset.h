// A glTF 2.0 asset on its way out: a JSON document, and binary data that are made only when they
// are written, one buffer view after the other. Based on: glTF 2.0 specification, sections 3.6.2
// (accessors, alignment) and 4.4 (GLB).
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/gltf/accessor.h"

namespace sinew::gltf {

struct ElementType {
  ComponentType component = ComponentType::f32;
  const char* type = "SCALAR";
  uint32_t components = 1;
};

// What buffer views are for, with the numbers of the specification.
enum class ViewUse : uint16_t { data = 0, vertices = 34962, indices = 34963 };

// Small data of one kind share a buffer view; glTF wants no two kinds in one.
enum class Pool : uint8_t { animations, matrices };

// Whether an accessor states its least and largest values.
enum class Limits : uint8_t { omitted, stated };

template <class T>
constexpr ElementType element_type() {
  if constexpr (std::is_arithmetic_v<T>) {
    if (sizeof(T) == 2) return {ComponentType::u16, "SCALAR", 1};
    if (std::is_same_v<T, uint32_t>) return {ComponentType::u32, "SCALAR", 1};
    return {ComponentType::f32, "SCALAR", 1};
  } else {
    constexpr const char* kTypes[] = {"VEC2", "VEC3", "VEC4"};
    using Component = typename T::value_type;
    const ComponentType component = sizeof(Component) == 1   ? ComponentType::u8
                                    : sizeof(Component) == 2 ? ComponentType::u16
                                                             : ComponentType::f32;
    return {component, kTypes[T::length() - 2], static_cast<uint32_t>(T::length())};
  }
}

class AssetWriter {
 public:
  using Json = nlohmann::ordered_json;

  AssetWriter();
  ~AssetWriter();

  Json& root() { return *root_; }
  // Appends to a top-level array; returns the index.
  uint32_t add(const char* array, Json item);
  void use_extension(std::string_view name);

  // An accessor with a buffer view of its own, whose element i is at(i). What `at` refers to must
  // live until the asset is written. At least one element.
  template <class T, class At>
  uint32_t add_elements(uint32_t count, ViewUse use, Limits limits, const At& at);

  // An accessor over a copy of the values in the pool.
  uint32_t add_values(Pool pool, std::span<const float> values, const ElementType& type,
                      Limits limits = Limits::omitted);

  // A buffer view of bytes as they are (an image).
  uint32_t add_bytes(std::vector<uint8_t> bytes);

  // To be called once, when all is added: the buffers, and the JSON text. `binary_uri` is empty for
  // a GLB.
  std::string finish(const std::string& binary_uri);
  uint64_t binary_size() const { return binary_size_; }
  // Whether the format can hold what finish() counted; also true of a .gltf and its .bin, for many
  // programs count those bytes in 32 bits as well.
  Result<void> check_size(const std::string& json, const std::string& file) const;

  // Writes what finish() counted: all buffer views, or a whole GLB around them.
  using Sink = std::function<Result<void>(std::span<const uint8_t>)>;
  Result<void> write_binary(const Sink& write) const;
  Result<void> write_glb(const std::string& json, const Sink& write) const;

 private:
  using Fill = std::function<void(std::span<uint8_t>)>;
  struct Chunk {
    uint64_t size = 0;
    Fill fill;
  };
  struct SharedView {
    int64_t view = -1;  // none yet
    std::vector<uint8_t> bytes;
  };
  struct Range {
    std::array<float, 4> least, largest;
  };

  uint32_t add_chunk(uint64_t size, ViewUse use, Fill fill);
  uint32_t add_accessor(uint32_t view, uint64_t offset, uint32_t count, const ElementType& type,
                        const Range* range);
  static void extend(Range& range, const float* values, uint32_t components, bool first);

  std::unique_ptr<Json> root_;
  std::vector<Chunk> chunks_;
  uint64_t binary_size_ = 0;
  std::array<SharedView, 2> pools_;  // by Pool
};

template <class T, class At>
uint32_t AssetWriter::add_elements(uint32_t count, ViewUse use, Limits limits, const At& at) {
  constexpr ElementType kType = element_type<T>();
  Range range;
  if constexpr (kType.component == ComponentType::f32) {
    for (size_t i = 0; i < count && limits == Limits::stated; ++i) {
      const T value = at(i);
      float values[kType.components];
      std::memcpy(values, &value, sizeof values);
      extend(range, values, kType.components, i == 0);
    }
  }
  const uint32_t view = add_chunk(uint64_t{count} * sizeof(T), use, [at](std::span<uint8_t> out) {
    for (size_t i = 0; i < out.size() / sizeof(T); ++i) {
      const T value = at(i);
      std::memcpy(&out[i * sizeof(T)], &value, sizeof(T));
    }
  });
  return add_accessor(view, 0, count, kType, limits == Limits::stated ? &range : nullptr);
}

}  // namespace sinew::gltf
