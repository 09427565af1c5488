#include "sinew/io/gltf/asset.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "sinew/io/asset_folder.h"
#include "sinew/io/gltf/meshopt.h"
#include "sinew/io/gltf/uri.h"
#include "sinew/io/output_file.h"

namespace sinew::gltf {
namespace {

constexpr uint32_t kMagic = 0x46546C67;        // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr uint32_t kBinaryChunk = 0x004E4942;  // "BIN\0"
constexpr size_t kHeaderSize = 12;
constexpr size_t kChunkHeaderSize = 8;
constexpr uint64_t kBytesPerJsonByte = 32;  // a parsed document's size over its text's, at most

tl::unexpected<Error> damaged(const std::string& file, std::string problem) {
  return fail({ErrorKind::bad_input, file, "", std::move(problem),
               "check that the file is complete, or export it again"});
}

uint32_t read_u32(const std::string& bytes, size_t offset) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Where the chunks of a GLB file lie.
struct Chunks {
  size_t json_offset = 0;
  size_t json_size = 0;
  size_t binary_offset = 0;
  size_t binary_size = 0;
  bool has_binary = false;
};

Result<Chunks> find_chunks(const std::string& file, const std::string& bytes) {
  if (bytes.size() < kHeaderSize + kChunkHeaderSize)
    return damaged(file, "the GLB file is cut off");
  const uint32_t version = read_u32(bytes, 4);
  if (version != 2) {
    return fail({ErrorKind::bad_input, file, "",
                 fmt::format("is a GLB file of version {}; only version 2 is supported", version),
                 "convert it to glTF 2.0"});
  }
  const size_t length = read_u32(bytes, 8);
  if (length > bytes.size()) {
    return damaged(
        file, fmt::format("the GLB file is cut off: it has {} of {} bytes", bytes.size(), length));
  }
  Chunks chunks;
  for (size_t offset = kHeaderSize; offset < length;) {
    if (length - offset < kChunkHeaderSize) return damaged(file, "the GLB chunks are damaged");
    const size_t size = read_u32(bytes, offset);
    const uint32_t type = read_u32(bytes, offset + 4);
    const bool first = offset == kHeaderSize;
    offset += kChunkHeaderSize;
    if (size > length - offset)
      return damaged(file, "a GLB chunk reaches past the end of the file");
    if (first != (type == kJsonChunk)) {
      return damaged(file, "the first GLB chunk, and no other, must be JSON");
    }
    if (first) {
      chunks.json_offset = offset;
      chunks.json_size = size;
    } else if (type == kBinaryChunk && !chunks.has_binary) {
      chunks.binary_offset = offset;
      chunks.binary_size = size;
      chunks.has_binary = true;
    }
    offset += size;
  }
  if (chunks.json_offset == 0) return damaged(file, "the GLB file has no JSON chunk");
  return chunks;
}

Result<void> check_version(const Json& root) {
  SINEW_TRY(const Json asset, root.object("asset"));
  SINEW_TRY(const std::string version, asset.text("version"));
  SINEW_TRY(const std::string least, asset.text("minVersion", "2.0"));
  if (version.substr(0, 2) != "2.") {
    return root.error(version.empty() ? "is not a glTF file: \"asset.version\" is missing"
                                      : "is glTF " + version + "; only version 2 is supported",
                      "convert it to glTF 2.0");
  }
  if (least != "2.0") return root.error("needs glTF " + least + "; version 2.0 is supported");
  return {};
}

// Fills asset.buffers; `binary` is the GLB's BIN chunk, which buffer 0 means if it has no URI.
Result<void> load_buffers(Asset& asset, std::string binary, bool has_binary, MemoryBudget& budget) {
  SINEW_TRY(const std::vector<Json> buffers, asset.root().objects("buffers", "buffer"));
  asset.buffers.resize(buffers.size());
  asset.buffer_missing.resize(buffers.size());
  for (size_t i = 0; i < buffers.size(); ++i) {
    SINEW_TRY(const uint64_t size,
              buffers[i].unsigned_number("byteLength", 0, std::numeric_limits<uint32_t>::max()));
    SINEW_TRY(const Json compression, meshopt_extension(buffers[i]));
    SINEW_TRY(const bool is_fallback, compression.boolean("fallback", false));
    if (is_fallback && meshopt_available()) {  // only readers that cannot decompress need it
      asset.buffer_missing[i] = true;
      continue;
    }
    if (buffers[i].has("uri")) {
      SINEW_TRY(asset.buffers[i], load_uri(asset, buffers[i], budget));
    } else if (i == 0 && has_binary) {
      asset.buffers[i] = std::move(binary);
    } else {
      asset.buffer_missing[i] = true;
      continue;
    }
    if (asset.buffers[i].size() < size) {
      return buffers[i].error(
          fmt::format("has {} bytes, but the file says {}", asset.buffers[i].size(), size),
          "check that the file is complete");
    }
    asset.buffers[i].resize(size);
  }
  return {};
}

}  // namespace

Result<void> MemoryBudget::take(const Json& element, uint64_t count, uint64_t size) {
  if (size != 0 && count > left_ / size) {
    return element.error("needs more memory than the limit allows",
                         "raise the memory limit if the file is trustworthy");
  }
  left_ -= count * size;
  return {};
}

Result<std::string> load_uri(const Asset& asset, const Json& owner, MemoryBudget& budget) {
  SINEW_TRY(const std::string uri, owner.text("uri"));
  if (is_data_uri(uri)) {
    SINEW_CHECKED(budget.take(owner, uri.size(), 1));
    auto bytes = decode_data_uri(uri);
    if (!bytes) return owner.error(bytes.error(), "export the file again");
    return std::move(*bytes);
  }
  const auto file = file_of_uri(asset.folder, uri);
  if (!file) return owner.error(file.error(), "put the file beside the asset");
  Result<std::string> bytes = read_file(file->string(), budget.left());
  if (!bytes) {
    return owner.error("cannot read \"" + percent_decode(uri) + "\": " + bytes.error().problem,
                       "put the file beside the asset");
  }
  SINEW_CHECKED(budget.take(owner, bytes->size(), 1));
  return bytes;
}

Result<Asset> open_asset(const std::string& path, std::string bytes, MemoryBudget& budget) {
  Asset asset;
  asset.file = path;
  asset.folder = asset_folder(path);
  if (bytes.empty()) return damaged(path, "is empty");
  Chunks chunks{.json_size = bytes.size()};
  const bool binary = bytes.size() >= 4 && read_u32(bytes, 0) == kMagic;
  if (binary) {
    SINEW_TRY(chunks, find_chunks(path, bytes));
  }
  const Json whole(nullptr, &asset.file, "");
  SINEW_CHECKED(budget.take(whole, bytes.size(), 1));
  SINEW_CHECKED(budget.take(whole, chunks.json_size, kBytesPerJsonByte));
  const std::string_view text =
      std::string_view(bytes).substr(chunks.json_offset, chunks.json_size);
  SINEW_TRY(asset.document, Document::parse(text, path));
  SINEW_CHECKED(check_version(asset.root()));
  if (chunks.has_binary) bytes.resize(chunks.binary_offset + chunks.binary_size);
  bytes.erase(0, chunks.binary_offset);
  SINEW_CHECKED(load_buffers(asset, std::move(bytes), chunks.has_binary, budget));
  return asset;
}

}  // namespace sinew::gltf
