// Compresses glTF assets for tests, with the encoders of the libraries that sinew decodes with.
#pragma once

#include "gltf_builder.h"

namespace sinew {

// A .glb file to be changed: its JSON and its buffer.
GltfBuilder open_glb(const std::string& path);

struct DracoSettings {
  bool edgebreaker = false;  // else sequential, which keeps the order of vertices and triangles
  int position_bits = 0;     // quantisation; 0: none
};
// Moves every primitive's attributes and indices into KHR_draco_mesh_compression.
void compress_with_draco(GltfBuilder& asset, const DracoSettings& settings);

struct MeshoptSettings {
  const char* index_mode = "INDICES";  // or "TRIANGLES", which may turn triangles
};
// Compresses every buffer view that accessors use, without loss. The plain bytes move to a fallback
// buffer without data.
void compress_with_meshopt(GltfBuilder& asset, const MeshoptSettings& settings);

// One compressed view of `count` elements of `stride` bytes; returns its index.
int add_meshopt_view(GltfBuilder& asset, const std::string& data, size_t count, size_t stride,
                     const std::string& mode, const std::string& filter = "NONE");

}  // namespace sinew
