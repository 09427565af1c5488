// Writes scenes as glTF 2.0, which other programs open and load() reads back.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct SaveOptions {
  double fps = 0.0;  // samples a second of vertex programs; 0: the scene's own rate, or 24
};

struct SavedFile {
  std::string path;
  uint64_t bytes = 0;
};

struct SaveReport {
  uint64_t triangles = 0;  // over objects, each instance counted
  uint32_t nodes = 0;      // that the file has
  uint32_t clips = 0;
  std::vector<SavedFile> files;       // the scene first
  std::vector<std::string> warnings;  // what glTF cannot say, or says otherwise
};

// `path` ends in .glb (one file) or .gltf (and a .bin beside it). Vertex caches and vertex programs
// become PC2 files beside it, NAME_cache.pc2, NAME_cache_2.pc2, ...; load() plays them, others show
// the mesh at rest. All files appear whole, or none does. "-" writes a GLB to standard output, if
// the scene needs no other file. The scene must be valid. Errors: usage, output, and bad_input for
// scenes that are not valid or too large for the format.
Result<SaveReport> save_gltf(const Scene& scene, const std::string& path,
                             const SaveOptions& options = {});

// Whether `path` is a name that save_gltf takes, and can be written: to be asked before long work.
Result<void> check_save(const std::string& path);

}  // namespace sinew
