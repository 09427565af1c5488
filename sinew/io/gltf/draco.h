// Primitives compressed with Draco (KHR_draco_mesh_compression). Where the package was not found,
// draco_missing.cpp stands in for draco.cpp.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/io/gltf/accessor.h"
#include "sinew/io/gltf/asset.h"

namespace sinew::gltf {

struct DracoAttribute {
  std::string name;         // "POSITION", ...
  uint32_t unique_id = 0;   // in the compressed data
  uint32_t components = 0;  // those of the attribute's accessor
  ComponentType type = ComponentType::f32;
  std::vector<uint8_t> bytes;  // decoded: tightly packed elements, one a vertex
};

struct DracoMesh {
  uint32_t vertex_count = 0;
  std::vector<uint32_t> indices;  // three a triangle, below vertex_count
  std::vector<DracoAttribute> attributes;

  // Null if the compressed data do not hold it.
  const DracoAttribute* find(std::string_view name) const {
    const auto found = std::find_if(attributes.begin(), attributes.end(),
                                    [&](const DracoAttribute& a) { return a.name == name; });
    return found == attributes.end() ? nullptr : &*found;
  }
};

// Fills everything of `mesh` but what its attributes say themselves. Errors name `primitive`.
Result<void> decode_draco(const Json& primitive, std::span<const uint8_t> bytes,
                          MemoryBudget& budget, DracoMesh& mesh);

}  // namespace sinew::gltf
