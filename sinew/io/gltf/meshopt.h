// Buffer views compressed with meshoptimizer (EXT_meshopt_compression, and the part of
// KHR_meshopt_compression that is the same). Where the package was not found, meshopt_missing.cpp
// stands in for meshopt.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sinew/io/gltf/asset.h"
#include "sinew/io/gltf/json.h"

namespace sinew::gltf {

bool meshopt_available();

// The extension's object in `owner` (a buffer or buffer view) under either name, or a view of
// nothing.
Result<Json> meshopt_extension(const Json& owner);

struct DecodedView {
  std::string bytes;    // empty: the view is not compressed
  uint32_t stride = 0;  // bytes from element to element
};

// `extension` describes what `bytes` hold.
Result<DecodedView> decode_meshopt(const Json& extension, std::span<const uint8_t> bytes,
                                   MemoryBudget& budget);

}  // namespace sinew::gltf
