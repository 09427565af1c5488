// The one checked reader of glTF accessors: bounds, strides, types, sparse and normalised data,
// finite values. Based on: glTF 2.0 specification, sections 3.6.2 (accessors, sparse accessors,
// data alignment) and 3.11 (normalised integers). Errors name the accessor ("accessor 12").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/gltf/asset.h"
#include "sinew/io/gltf/json.h"
#include "sinew/io/gltf/meshopt.h"
#include "sinew/io/gltf/warnings.h"

namespace sinew::gltf {

enum class ComponentType : uint16_t { i8 = 5120, u8, i16, u16, u32 = 5125, f32 };

// Which component types a reader accepts.
enum class Numbers : uint8_t {
  real,                // f32
  real_or_normalized,  // f32, or normalised 8 or 16 bit integers
  any_real,            // also plain 8 or 16 bit integers (KHR_mesh_quantization)
  index,               // u8, u16, u32
};

inline constexpr uint32_t kAnyComponents = 0;  // 1 to 4
inline constexpr uint32_t kMatrixComponents = 16;

// An accessor whose whole range is known to lie within its buffers.
struct Accessor {
  Json json;                // for error messages
  uint32_t count = 0;       // elements, at least 1
  uint32_t components = 0;  // 1 to 4, or 16: a matrix, column-major
  ComponentType type = ComponentType::f32;
  bool normalized = false;
  const uint8_t* bytes = nullptr;  // the first element; null: all elements are zero
  uint32_t stride = 0;             // bytes from element to element
  uint32_t sparse_count = 0;       // elements replaced
  ComponentType sparse_index_type = ComponentType::u32;
  const uint8_t* sparse_indices = nullptr;  // tightly packed
  const uint8_t* sparse_values = nullptr;   // tightly packed elements
};

class AccessorReader {
 public:
  // Decodes compressed buffer views.
  static Result<AccessorReader> create(const Asset& asset, MemoryBudget& budget,
                                       Warnings& warnings);

  // The accessor that `owner`'s member `key` refers to, checked in full.
  Result<Accessor> find(const Json& owner, const char* key, uint32_t components,
                        Numbers numbers) const;
  // The same, but what the accessor stands for is not looked for: all elements are zero.
  Result<Accessor> describe(const Json& owner, const char* key, uint32_t components,
                            Numbers numbers) const;
  // The bytes of the buffer view that `owner`'s member `key` refers to.
  Result<std::span<const uint8_t>> view_bytes(const Json& owner, const char* key) const;

 private:
  struct View {
    std::span<const uint8_t> bytes;
    uint32_t stride = 0;  // 0: tightly packed
  };
  AccessorReader(const Asset& asset, Warnings& warnings) : asset_(&asset), warnings_(&warnings) {}
  Result<std::span<const uint8_t>> range(const Json& owner) const;
  Result<void> decode_views(MemoryBudget& budget);
  Result<View> find_view(const Json& owner, const char* key) const;
  Result<const uint8_t*> packed(const Json& owner, uint64_t count, uint64_t element_size) const;
  Result<void> find_elements(Accessor& accessor) const;
  Result<void> find_sparse(Accessor& accessor) const;

  const Asset* asset_;
  Warnings* warnings_;
  std::vector<Json> accessors_;
  std::vector<Json> views_;
  std::vector<DecodedView> decoded_views_;  // one a view
};

// All elements, converted: out has accessor.count * accessor.components entries. Values that are
// not finite are errors.
Result<void> read(const Accessor& accessor, std::span<float> out);
// Accessors found with Numbers::index only.
Result<void> read(const Accessor& accessor, std::span<uint32_t> out);

}  // namespace sinew::gltf
