// Nodes and skins of a glTF file (glTF 2.0 specification, sections 3.5 and 3.7.3), with
// EXT_mesh_gpu_instancing (one child node an instance) and KHR_node_visibility.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/io/gltf/graph.h"
#include "sinew/io/gltf/reader.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// Where a JSON node went.
struct NodePlace {
  int32_t node = -1;        // in Scene::nodes; -1: not part of the scene
  uint32_t first_mesh = 0;  // the nodes that carry its mesh: itself, or its instances
  uint32_t mesh_count = 0;
  bool visibility = false;  // it only shows and hides `node`, which stands for it
};

// Fills scene.nodes; `meshes` is what read_meshes returned. One place a JSON node.
Result<std::vector<NodePlace>> read_nodes(const Reader& reader, const NodeGraph& graph,
                                          std::span<const int32_t> meshes, Scene& scene);

// Morph targets of the mesh or the octree that the node shows.
size_t targets_of(const Scene& scene, const Node& node);

// Fills scene.skins with those that nodes use, and sets Node::skin. Equal skins become one.
Result<void> read_skins(const Reader& reader, const NodeGraph& graph,
                        std::span<const NodePlace> places, Scene& scene);

}  // namespace sinew::gltf
