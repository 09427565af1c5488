// The raw contents of a glTF 2.0 asset: its JSON document and the bytes of its buffers, from a
// .gltf or .glb file (glTF 2.0 specification, sections 3.6.1 and 4.4).
//
//   GLB:  "glTF" | version | length || length | "JSON" | text || length | "BIN\0" | bytes
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/gltf/json.h"

namespace sinew::gltf {

// What loading may still allocate. Sizes are taken from it before memory is, so that a small file
// cannot ask for a large machine.
class MemoryBudget {
 public:
  explicit MemoryBudget(uint64_t bytes) : left_(bytes) {}
  // Counts count * size bytes for `element`, or fails.
  Result<void> take(const Json& element, uint64_t count, uint64_t size);
  uint64_t left() const { return left_; }

 private:
  uint64_t left_;
};

struct Asset {
  std::string file;              // as the user named it
  std::filesystem::path folder;  // canonical
  std::unique_ptr<Document> document;
  std::vector<std::string> buffers;  // bytes; at least byteLength of each JSON buffer
  std::vector<bool> buffer_missing;  // a buffer without data (only extensions fill such ones)

  Json root() const { return document->root(); }
};

// `bytes` are those of the file `path`.
Result<Asset> open_asset(const std::string& path, std::string bytes, MemoryBudget& budget);

// The bytes that the "uri" of `owner` (a buffer or an image) means.
Result<std::string> load_uri(const Asset& asset, const Json& owner, MemoryBudget& budget);

}  // namespace sinew::gltf
