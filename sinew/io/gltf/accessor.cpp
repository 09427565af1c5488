#include "sinew/io/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace sinew::gltf {
namespace {

constexpr uint64_t kLargestSize = std::numeric_limits<uint32_t>::max();
constexpr uint64_t kLargestStride = 252;
// Zeros cost a file nothing, so they have a limit of their own (bytes after conversion to float).
constexpr uint64_t kMostZeroBytes = uint64_t{64} << 20;

uint32_t size_of(ComponentType type) {
  switch (type) {
    case ComponentType::i8:
    case ComponentType::u8:
      return 1;
    case ComponentType::i16:
    case ComponentType::u16:
      return 2;
    case ComponentType::u32:
    case ComponentType::f32:
      break;
  }
  return 4;
}

// Calls function(Source()) with a value of the C++ type that `type` names.
template <class F>
auto with_type(ComponentType type, const F& function) {
  switch (type) {
    case ComponentType::i8:
      return function(int8_t());
    case ComponentType::u8:
      return function(uint8_t());
    case ComponentType::i16:
      return function(int16_t());
    case ComponentType::u16:
      return function(uint16_t());
    case ComponentType::u32:
      return function(uint32_t());
    case ComponentType::f32:
      break;
  }
  return function(float());
}

Result<ComponentType> component_type(const Json& json, const char* key) {
  SINEW_TRY(const uint64_t number, json.unsigned_number(key, 0, kLargestSize));
  const bool known = number >= 5120 && number <= 5126 && number != 5124;
  if (!known) return json.error(fmt::format("\"{}\" {} is not a component type", key, number));
  return static_cast<ComponentType>(number);
}

Result<uint32_t> component_count(const Json& json) {
  SINEW_TRY(const std::string type, json.text("type"));
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  if (type == "MAT4") return kMatrixComponents;
  return json.error(fmt::format("has the unexpected type \"{}\"", type));
}

bool accepts(Numbers numbers, ComponentType type, bool normalized) {
  const bool is_float = type == ComponentType::f32;
  const bool is_small = size_of(type) < 4;
  switch (numbers) {
    case Numbers::real:
      return is_float;
    case Numbers::real_or_normalized:
      return is_float || (is_small && normalized);
    case Numbers::any_real:
      return is_float || is_small;
    case Numbers::index:
      break;
  }
  return !normalized &&
         (type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::u32);
}

template <class Source>
Source load(const uint8_t* bytes) {
  Source value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// One component as glTF 2.0, section 3.11 defines it: c / max for unsigned, max(c / max, -1) for
// signed normalised integers.
template <class Target, class Source>
Target convert(Source value, bool normalized) {
  if constexpr (std::is_same_v<Target, float> && !std::is_same_v<Source, float>) {
    if (!normalized) return static_cast<float>(value);
    constexpr float kMax = static_cast<float>(std::numeric_limits<Source>::max());
    return std::max(static_cast<float>(value) / kMax, -1.0f);
  } else {
    return static_cast<Target>(value);
  }
}

template <class Target>
void read_elements(const Accessor& accessor, const uint8_t* bytes, uint32_t stride, uint32_t count,
                   Target* out) {
  with_type(accessor.type, [&](auto source) {
    using Source = decltype(source);
    for (uint32_t i = 0; i < count; ++i, bytes += stride) {
      for (uint32_t k = 0; k < accessor.components; ++k) {
        *out++ = convert<Target>(load<Source>(bytes + k * sizeof(Source)), accessor.normalized);
      }
    }
  });
}

// Replaces the sparse elements in `out`. Their indices must rise and stay below the count.
template <class Target>
Result<void> read_sparse(const Accessor& accessor, std::span<Target> out) {
  const uint32_t size = accessor.components * size_of(accessor.type);
  int64_t last = -1;
  for (uint32_t i = 0; i < accessor.sparse_count; ++i) {
    const int64_t index = with_type(accessor.sparse_index_type, [&](auto source) {
      using Source = decltype(source);
      return static_cast<int64_t>(load<Source>(accessor.sparse_indices + i * sizeof(Source)));
    });
    if (index <= last || index >= int64_t{accessor.count}) {
      return accessor.json.error(fmt::format(
          "its sparse index {} is {}: they must rise and stay below {}", i, index, accessor.count));
    }
    read_elements(accessor, accessor.sparse_values + uint64_t{i} * size, size, 1,
                  &out[static_cast<size_t>(index) * accessor.components]);
    last = index;
  }
  return {};
}

template <class Target>
Result<void> read_all(const Accessor& accessor, std::span<Target> out) {
  if (accessor.bytes) {
    read_elements(accessor, accessor.bytes, accessor.stride, accessor.count, out.data());
  } else {
    std::fill(out.begin(), out.end(), Target(0));
  }
  return read_sparse(accessor, out);
}

}  // namespace

Result<Json> meshopt_extension(const Json& owner) {
  SINEW_TRY(const Json extensions, owner.object("extensions"));
  return extensions.object(extensions.has("EXT_meshopt_compression") ? "EXT_meshopt_compression"
                                                                     : "KHR_meshopt_compression");
}

Result<AccessorReader> AccessorReader::create(const Asset& asset, MemoryBudget& budget,
                                              Warnings& warnings) {
  AccessorReader reader(asset, warnings);
  SINEW_TRY(reader.accessors_, asset.root().objects("accessors", "accessor"));
  SINEW_TRY(reader.views_, asset.root().objects("bufferViews", "buffer view"));
  SINEW_CHECKED(reader.decode_views(budget));
  return reader;
}

// Where the uncompressed bytes are there too, they are exact and need no decoder.
Result<void> AccessorReader::decode_views(MemoryBudget& budget) {
  decoded_views_.resize(views_.size());
  for (size_t i = 0; i < views_.size(); ++i) {
    SINEW_TRY(const Json extension, meshopt_extension(views_[i]));
    if (!extension.has("buffer")) continue;
    SINEW_TRY(const uint32_t buffer, views_[i].required_index("buffer", asset_->buffers.size()));
    if (!asset_->buffer_missing[buffer]) continue;
    SINEW_TRY(const std::span<const uint8_t> bytes, range(extension));
    SINEW_TRY(decoded_views_[i], decode_meshopt(extension, bytes, budget));
  }
  return {};
}

// The bytes that the members "buffer", "byteOffset" and "byteLength" of `owner` mean.
Result<std::span<const uint8_t>> AccessorReader::range(const Json& owner) const {
  SINEW_TRY(const uint32_t buffer, owner.required_index("buffer", asset_->buffers.size()));
  if (asset_->buffer_missing[buffer]) {
    return owner.error(fmt::format("refers to buffer {}, which has no data", buffer));
  }
  const std::string& data = asset_->buffers[buffer];
  SINEW_TRY(const uint64_t offset, owner.unsigned_number("byteOffset", 0, kLargestSize));
  SINEW_TRY(const uint64_t length, owner.unsigned_number("byteLength", 0, kLargestSize));
  if (length == 0) return owner.error("has no \"byteLength\", or one of 0");
  if (offset + length > data.size()) {
    return owner.error(fmt::format("reaches past the end of buffer {} ({} + {} of {} bytes)",
                                   buffer, offset, length, data.size()));
  }
  return std::span(reinterpret_cast<const uint8_t*>(data.data()) + offset, length);
}

Result<AccessorReader::View> AccessorReader::find_view(const Json& owner, const char* key) const {
  SINEW_TRY(const uint32_t index, owner.required_index(key, views_.size()));
  if (const DecodedView& view = decoded_views_[index]; !view.bytes.empty()) {
    return View{{reinterpret_cast<const uint8_t*>(view.bytes.data()), view.bytes.size()},
                view.stride};
  }
  SINEW_TRY(const std::span<const uint8_t> bytes, range(views_[index]));
  SINEW_TRY(const uint64_t stride, views_[index].unsigned_number("byteStride", 0, kLargestStride));
  return View{bytes, static_cast<uint32_t>(stride)};
}

Result<std::span<const uint8_t>> AccessorReader::view_bytes(const Json& owner,
                                                            const char* key) const {
  SINEW_TRY(const View view, find_view(owner, key));
  return view.bytes;
}

// Where `count` tightly packed elements begin in the view and at the offset that `owner` names.
Result<const uint8_t*> AccessorReader::packed(const Json& owner, uint64_t count,
                                              uint64_t element_size) const {
  SINEW_TRY(const View view, find_view(owner, "bufferView"));
  SINEW_TRY(const uint64_t offset, owner.unsigned_number("byteOffset", 0, kLargestSize));
  if (offset + count * element_size > view.bytes.size()) {
    return owner.error("its sparse data reach past the end of their buffer view");
  }
  return view.bytes.data() + offset;
}

Result<void> AccessorReader::find_elements(Accessor& accessor) const {
  const Json& json = accessor.json;
  const uint64_t size = accessor.components * size_of(accessor.type);
  if (!json.has("bufferView")) {
    if (uint64_t{accessor.count} * accessor.components * sizeof(float) > kMostZeroBytes) {
      return json.error(fmt::format("stands for {} elements without data", accessor.count));
    }
    return {};
  }
  SINEW_TRY(const View view, find_view(json, "bufferView"));
  SINEW_TRY(const uint64_t offset, json.unsigned_number("byteOffset", 0, kLargestSize));
  const uint64_t stride = view.stride == 0 ? size : view.stride;
  if (stride < size) {
    return json.error(
        fmt::format("its elements of {} bytes overlap: the stride is {}", size, stride));
  }
  const uint64_t end = offset + (uint64_t{accessor.count} - 1) * stride + size;
  if (end > view.bytes.size()) {
    return json.error(fmt::format("reaches past the end of its buffer view ({} of {} bytes)", end,
                                  view.bytes.size()),
                      "check that the file is complete, or export it again");
  }
  accessor.bytes = view.bytes.data() + offset;
  accessor.stride = static_cast<uint32_t>(stride);
  const size_t component = size_of(accessor.type);
  if (offset % component != 0 || stride % component != 0) {
    warnings_->add(json.element(), "is not aligned to its component size; read nevertheless");
  }
  return {};
}

Result<void> AccessorReader::find_sparse(Accessor& accessor) const {
  SINEW_TRY(const Json sparse, accessor.json.object("sparse"));
  SINEW_TRY(const uint64_t count, sparse.unsigned_number("count", 0, accessor.count));
  if (count == 0) return {};
  SINEW_TRY(const Json indices, sparse.object("indices"));
  SINEW_TRY(const Json values, sparse.object("values"));
  SINEW_TRY(accessor.sparse_index_type, component_type(indices, "componentType"));
  if (!accepts(Numbers::index, accessor.sparse_index_type, false)) {
    return accessor.json.error("its sparse indices are not unsigned integers");
  }
  accessor.sparse_count = static_cast<uint32_t>(count);
  SINEW_TRY(accessor.sparse_indices, packed(indices, count, size_of(accessor.sparse_index_type)));
  SINEW_TRY(accessor.sparse_values,
            packed(values, count, uint64_t{accessor.components} * size_of(accessor.type)));
  return {};
}

Result<Accessor> AccessorReader::describe(const Json& owner, const char* key, uint32_t components,
                                          Numbers numbers) const {
  SINEW_TRY(const uint32_t index, owner.required_index(key, accessors_.size()));
  Accessor accessor;
  accessor.json = accessors_[index];
  const Json& json = accessor.json;
  SINEW_TRY(accessor.components, component_count(json));
  SINEW_TRY(accessor.type, component_type(json, "componentType"));
  SINEW_TRY(accessor.normalized, json.boolean("normalized", false));
  const bool fits =
      components == kAnyComponents ? accessor.components <= 4 : accessor.components == components;
  if (!fits || !accepts(numbers, accessor.type, accessor.normalized)) {
    return json.error(fmt::format("has the wrong type for \"{}\" of {}", key, owner.element()));
  }
  SINEW_TRY(const uint64_t count, json.unsigned_number("count", 0, kLargestSize));
  if (count == 0) return json.error("has no elements");
  accessor.count = static_cast<uint32_t>(count);
  return accessor;
}

Result<Accessor> AccessorReader::find(const Json& owner, const char* key, uint32_t components,
                                      Numbers numbers) const {
  SINEW_TRY(Accessor accessor, describe(owner, key, components, numbers));
  SINEW_CHECKED(find_elements(accessor));
  SINEW_CHECKED(find_sparse(accessor));
  return accessor;
}

Result<void> read(const Accessor& accessor, std::span<float> out) {
  SINEW_CHECKED(read_all(accessor, out));
  const auto bad = std::find_if(out.begin(), out.end(), [](float x) { return !std::isfinite(x); });
  if (bad != out.end()) {
    return accessor.json.error(
        fmt::format("its element {} is not finite", (bad - out.begin()) / accessor.components));
  }
  return {};
}

Result<void> read(const Accessor& accessor, std::span<uint32_t> out) {
  return read_all(accessor, out);
}

}  // namespace sinew::gltf
