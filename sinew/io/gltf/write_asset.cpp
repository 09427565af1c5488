#include "sinew/io/gltf/write_asset.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sinew/base/check.h"

namespace sinew::gltf {
namespace {

constexpr uint64_t kAlignment = 4;
constexpr uint32_t kMagic = 0x46546C67;        // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942;  // "BIN\0"

uint64_t aligned(uint64_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

uint64_t glb_size(uint64_t json_size, uint64_t binary_size) {
  constexpr uint64_t kHeader = 12, kChunkHeader = 8;
  return kHeader + kChunkHeader + json_size + (binary_size > 0 ? kChunkHeader + binary_size : 0);
}

Result<void> write_words(const AssetWriter::Sink& write, std::initializer_list<uint64_t> words) {
  std::vector<uint8_t> bytes;
  for (const uint64_t word : words) {
    const uint32_t narrow = static_cast<uint32_t>(word);
    const auto* begin = reinterpret_cast<const uint8_t*>(&narrow);
    bytes.insert(bytes.end(), begin, begin + sizeof narrow);
  }
  return write(bytes);
}

}  // namespace

AssetWriter::AssetWriter() : root_(std::make_unique<Json>()) {
  *root_ = {{"asset", {{"version", "2.0"}, {"generator", "sinew"}}}};
}
AssetWriter::~AssetWriter() = default;

uint32_t AssetWriter::add(const char* array, Json item) {
  Json& items = root()[array];
  items.push_back(std::move(item));
  return static_cast<uint32_t>(items.size() - 1);
}

void AssetWriter::use_extension(std::string_view name) {
  Json& used = root()["extensionsUsed"];
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

uint32_t AssetWriter::add_chunk(uint64_t size, ViewUse use, Fill fill) {
  SINEW_CHECK(size > 0);
  Json view = {{"buffer", 0}, {"byteOffset", binary_size_}, {"byteLength", size}};
  if (use != ViewUse::data) view["target"] = static_cast<int>(use);
  chunks_.push_back({size, std::move(fill)});
  binary_size_ += aligned(size);
  return add("bufferViews", std::move(view));
}

uint32_t AssetWriter::add_accessor(uint32_t view, uint64_t offset, uint32_t count,
                                   const ElementType& type, const Range* range) {
  Json accessor = {{"bufferView", view},
                   {"componentType", static_cast<int>(type.component)},
                   {"count", count},
                   {"type", type.type}};
  if (offset > 0) accessor["byteOffset"] = offset;
  for (uint32_t k = 0; range && k < type.components; ++k) {
    accessor["min"].push_back(double{range->least[k]});
    accessor["max"].push_back(double{range->largest[k]});
  }
  return add("accessors", std::move(accessor));
}

void AssetWriter::extend(Range& range, const float* values, uint32_t components, bool first) {
  for (uint32_t k = 0; k < components; ++k) {
    range.least[k] = first ? values[k] : std::min(range.least[k], values[k]);
    range.largest[k] = first ? values[k] : std::max(range.largest[k], values[k]);
  }
}

uint32_t AssetWriter::add_values(Pool pool, std::span<const float> values, const ElementType& type,
                                 Limits limits) {
  SINEW_CHECK(!values.empty() && values.size() % type.components == 0);
  Range range;
  if (limits == Limits::stated) {
    for (size_t i = 0; i < values.size(); i += type.components) {
      extend(range, &values[i], type.components, i == 0);
    }
  }
  SharedView& shared = pools_[static_cast<size_t>(pool)];
  if (shared.view < 0) shared.view = add("bufferViews", {{"buffer", 0}});
  const size_t offset = shared.bytes.size();
  const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
  shared.bytes.insert(shared.bytes.end(), bytes, bytes + values.size_bytes());
  return add_accessor(static_cast<uint32_t>(shared.view), offset,
                      static_cast<uint32_t>(values.size() / type.components), type,
                      limits == Limits::stated ? &range : nullptr);
}

uint32_t AssetWriter::add_bytes(std::vector<uint8_t> bytes) {
  const uint64_t size = bytes.size();
  return add_chunk(size, ViewUse::data, [bytes = std::move(bytes)](std::span<uint8_t> out) {
    std::copy(bytes.begin(), bytes.end(), out.begin());
  });
}

std::string AssetWriter::finish(const std::string& binary_uri) {
  for (const SharedView& shared : pools_) {
    if (shared.view < 0) continue;
    Json& view = root()["bufferViews"][static_cast<size_t>(shared.view)];
    view["byteOffset"] = binary_size_;
    view["byteLength"] = shared.bytes.size();
    chunks_.push_back({shared.bytes.size(), [&shared](std::span<uint8_t> out) {
                         std::copy(shared.bytes.begin(), shared.bytes.end(), out.begin());
                       }});
    binary_size_ += aligned(shared.bytes.size());
  }
  if (binary_size_ > 0) {
    Json buffer = {{"byteLength", binary_size_}};
    if (!binary_uri.empty()) buffer["uri"] = binary_uri;
    add("buffers", std::move(buffer));
  }
  const int indent = binary_uri.empty() ? -1 : 2;
  return root().dump(indent, ' ', false, Json::error_handler_t::replace);
}

Result<void> AssetWriter::check_size(const std::string& json, const std::string& file) const {
  const uint64_t size = glb_size(aligned(json.size()), binary_size_);
  if (size <= UINT32_MAX) return {};
  return fail({ErrorKind::bad_input, file, "",
               "would have " + std::to_string(size) + " bytes, but glTF files end at 4 GiB",
               "split the scene into several files"});
}

Result<void> AssetWriter::write_binary(const Sink& write) const {
  std::vector<uint8_t> bytes;
  for (const Chunk& chunk : chunks_) {
    bytes.assign(aligned(chunk.size), 0);
    chunk.fill(std::span(bytes).first(chunk.size));
    SINEW_CHECKED(write(bytes));
  }
  return {};
}

Result<void> AssetWriter::write_glb(const std::string& json, const Sink& write) const {
  std::string text = json;
  text.resize(aligned(text.size()), ' ');
  const uint64_t total = glb_size(text.size(), binary_size_);
  SINEW_CHECKED(write_words(write, {kMagic, 2, total, text.size(), kJsonChunk}));
  SINEW_CHECKED(write({reinterpret_cast<const uint8_t*>(text.data()), text.size()}));
  if (binary_size_ == 0) return {};
  SINEW_CHECKED(write_words(write, {binary_size_, kBinaryChunk}));
  return write_binary(write);
}

}  // namespace sinew::gltf
