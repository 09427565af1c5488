// Clips of a scene as glTF animations (glTF 2.0 specification, section 3.11). What glTF has no
// channels for stands in the extras of the animation, where load() finds it:
//
//   "sinew_cache_keys": [{"node", "interpolation", "times", "values"}]   ChannelPath::cache_key
//   "sinew_start", "sinew_end"     where the clip's extent is not that of its keys
#pragma once

#include <span>

#include "sinew/io/gltf/write_context.h"
#include "sinew/io/gltf/write_mesh.h"
#include "sinew/io/gltf/write_node.h"

namespace sinew::gltf {

// Returns how many animations the file has.
uint32_t write_animations(const WriteContext& context, std::span<const Clip> clips,
                          std::span<const NodeOutput> places, std::span<const MeshOutput> meshes,
                          const std::vector<MeshCache>& caches);

}  // namespace sinew::gltf
