// The scene around octrees as a GLB in memory, for files that hold the octrees themselves: glTF,
// but for nodes whose extras name an octree by its index ("sinew_octree"), and which may have a
// skin and morph weights like those with a mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

inline constexpr const char* kOctreeExtra = "sinew_octree";

// Of the scene's octrees only joints and morph targets count. Meshes must need no other files: no
// vertex caches or programs. What cannot be said goes to `warnings`.
Result<std::vector<uint8_t>> encode_glb(const Scene& scene, std::vector<std::string>& warnings);

// `octrees` become the scene's; `path` stands in errors.
Result<Scene> decode_glb(std::string bytes, const std::string& path, std::vector<Svo> octrees,
                         const LoadOptions& options);

}  // namespace sinew::gltf
