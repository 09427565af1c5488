// The node hierarchy that a glTF file shows: the nodes of its default scene (or its first, or all
// roots if it has no scene), parents before children. Rejects cycles and second parents.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/io/gltf/json.h"

namespace sinew::gltf {

struct NodeGraph {
  std::vector<Json> nodes;      // all JSON nodes
  std::vector<uint32_t> order;  // the JSON nodes of the scene, depth first
  std::vector<int32_t> parent;  // one a JSON node: its parent in the scene, or -1
};

Result<NodeGraph> read_graph(const Json& root);

}  // namespace sinew::gltf
