// Meshes of a scene as glTF meshes: a primitive for each part that has triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/io/gltf/write_cache.h"
#include "sinew/io/gltf/write_context.h"
#include "sinew/io/gltf/write_vertices.h"

namespace sinew::gltf {

// A mesh on its way out. Must live until the asset is written.
struct MeshOutput {
  int32_t json_mesh = -1;  // -1: no object shows it, or it has no triangles
  bool skinned = false;    // some object's skin moves it
  MeshVertices vertices;
  std::vector<vec3> normals;     // one a position, where the mesh has none of its own
  std::vector<uint32_t> points;  // see kPointAttribute in extras.h
  uint32_t columns = 0;          // influences of a position, a multiple of 4
  std::vector<uint16_t> joints;  // position-major columns; what is not used is 0
  std::vector<float> weights;
};

std::vector<MeshOutput> write_meshes(const WriteContext& context,
                                     const std::vector<MeshCache>& caches);

}  // namespace sinew::gltf
