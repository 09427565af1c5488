// Stands in for meshopt.cpp in builds without meshoptimizer.
#include "sinew/io/gltf/meshopt.h"

namespace sinew::gltf {

bool meshopt_available() {
  return false;
}

Result<DecodedView> decode_meshopt(const Json& extension, std::span<const uint8_t>, MemoryBudget&) {
  return extension.error(
      "is compressed with EXT_meshopt_compression, and this build of sinew has no meshoptimizer",
      "export the file without compression, or build sinew where meshoptimizer is installed");
}

}  // namespace sinew::gltf
