// What all parts of the glTF loader share.
#pragma once

#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "sinew/io/gltf/accessor.h"
#include "sinew/io/gltf/asset.h"
#include "sinew/io/gltf/warnings.h"

namespace sinew::gltf {

struct Reader {
  const Asset& asset;
  const AccessorReader& accessors;
  MemoryBudget& budget;
  Warnings& warnings;
};

// All elements of an accessor; T is float, uint32_t or a glm vector or matrix of float with the
// accessor's number of components.
template <class T>
Result<std::vector<T>> read_vector(const Reader& reader, const Accessor& accessor) {
  SINEW_CHECKED(reader.budget.take(accessor.json, accessor.count, sizeof(T)));
  std::vector<T> result(accessor.count);
  if constexpr (std::is_arithmetic_v<T>) {
    SINEW_CHECKED(read(accessor, std::span<T>(result)));
  } else {
    const size_t size = result.size() * (sizeof(T) / sizeof(float));
    SINEW_CHECKED(read(accessor, std::span<float>(glm::value_ptr(result[0]), size)));
  }
  return result;
}

}  // namespace sinew::gltf
