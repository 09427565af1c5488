// Meshes of a glTF file (glTF 2.0 specification, section 3.7.2): the primitives of one glTF mesh
// become one Mesh with a part each. Primitives that name the same vertex accessors share vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/io/gltf/graph.h"
#include "sinew/io/gltf/reader.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// Appends the meshes that nodes of `graph` use to scene.meshes, and the default material to
// scene.materials where one is needed. Returns, one a JSON mesh, its index in scene.meshes; -1 for
// unused meshes and those without triangles.
Result<std::vector<int32_t>> read_meshes(const Reader& reader, const NodeGraph& graph,
                                         Scene& scene);

}  // namespace sinew::gltf
