// Stands in for draco.cpp in builds without Draco.
#include "sinew/io/gltf/draco.h"

namespace sinew::gltf {

Result<void> decode_draco(const Json& primitive, std::span<const uint8_t>, MemoryBudget&,
                          DracoMesh&) {
  return primitive.error(
      "is compressed with KHR_draco_mesh_compression, and this build of sinew has no Draco",
      "export the file without compression, or build sinew where Draco is installed");
}

}  // namespace sinew::gltf
