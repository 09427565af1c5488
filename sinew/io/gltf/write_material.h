// Materials, textures and images of a scene as glTF has them (glTF 2.0 specification, section 3.9,
// and the KHR_materials_ extensions that material.h names). Images become PNG in the binary data.
#pragma once

#include "sinew/io/gltf/write_context.h"

namespace sinew::gltf {

// One JSON material for each of the scene's, in order.
Result<void> write_materials(const WriteContext& context);

}  // namespace sinew::gltf
