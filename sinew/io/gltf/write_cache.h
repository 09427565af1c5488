// Vertex caches of a scene on their way to PC2 files: meshes that have keys, and meshes with a
// vertex program, which is sampled at an even rate over all clips. A PC2 file holds the vertices in
// the order in which the glTF file has them, so other programs can play it over the mesh as well.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/io/gltf/write_vertices.h"
#include "sinew/io/output_file.h"
#include "sinew/io/save.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

struct MeshCache {
  uint32_t keys = 0;      // 0: the mesh has no cache
  bool program = false;   // sampled from Mesh::vertex_program, else Mesh::key_positions
  double start = 0.0;     // seconds: the time of the program's first sample
  double fps = 24.0;      // samples a second; of caches as their first clip plays them
  std::string file_name;  // without its folder
};

// One a mesh. `stem` is the output's name without folder and extension. Errors: too many keys.
Result<std::vector<MeshCache>> plan_caches(const Scene& scene, const std::string& stem,
                                           const SaveOptions& options);

// The clips as they play the caches: with a channel `cache_key` for each object with a vertex
// program, and a clip where a program has none.
std::vector<Clip> clips_with_caches(const Scene& scene, const std::vector<MeshCache>& caches);

Result<void> write_cache(const Mesh& mesh, const MeshCache& cache, const MeshVertices& vertices,
                         OutputFile& out);

}  // namespace sinew::gltf
