// Loads glTF 2.0 assets (.gltf with its files, or .glb). Based on: glTF 2.0 specification (Khronos
// Group, 2021; ISO/IEC 12113:2022) and the extensions named in gltf.cpp.
#pragma once

#include <string>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew {

// The default scene of the file. Buffers and images must lie in the file's folder or below it.
Result<Scene> load_gltf(const std::string& path, const LoadOptions& options = {});

// The same, from the bytes of the file; `path` stands in errors and says where other files lie.
Result<Scene> parse_gltf(std::string bytes, const std::string& path, const LoadOptions& options);

}  // namespace sinew
