// Nodes, skins, cameras and lights of a scene as glTF has them. glTF nodes neither shear nor hide:
//
//   a shearing matrix       two nodes, by its singular values: translation, rotation and scale,
//                           and in it the mesh and the children with another rotation
//   animated visibility     a node above with kVisibilityExtra, whose scale is stepped between 1
//                           and 0; load() makes it a visibility channel again
//   visible = false         KHR_node_visibility
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/io/gltf/write_context.h"
#include "sinew/io/gltf/write_mesh.h"

namespace sinew::gltf {

// Where a scene's node went, as JSON nodes.
struct NodeOutput {
  int32_t visibility = -1;  // the one above it whose scale shows and hides it
  uint32_t outer = 0;       // what its parent has as a child
  uint32_t main = 0;        // what has its mesh and its children
};

// Also writes the skins, and the scene. `clips` are those that will be written. One a node.
std::vector<NodeOutput> write_nodes(const WriteContext& context, std::span<const MeshOutput> meshes,
                                    std::span<const Clip> clips);

void write_cameras(const WriteContext& context);
void write_lights(const WriteContext& context);

}  // namespace sinew::gltf
