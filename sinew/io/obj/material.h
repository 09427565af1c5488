// Materials of polygon files and their textures: from .mtl statements to Material and Image8.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/obj/mtl.h"
#include "sinew/io/polygon/model.h"
#include "sinew/scene/scene.h"

namespace sinew {

// Adds materials and images to one scene, for any number of OBJ files of one folder. A name that
// was defined before keeps its first definition; libraries and images that are missing are warned
// about, those that lie outside the folder are errors.
class ObjMaterials {
 public:
  // `path` is an OBJ file's.
  ObjMaterials(Scene& scene, const std::string& path, const LoadOptions& options);

  // The scene's material for each part of the model.
  Result<std::vector<uint32_t>> of_parts(const PolygonModel& model);

 private:
  struct Definition {
    MtlMaterial mtl;
    std::string library;  // its path
  };
  Result<void> read_library(const std::string& name);
  Result<Material> convert(const Definition& definition);
  Result<void> add_bump(const Definition& definition, Material& out);
  Result<void> add_opacity_map(const Definition& definition, Material& out);
  Result<TextureRef> texture(const MtlTexture& map, const std::string& library);
  Result<int32_t> image(const MtlTexture& map, const std::string& library);
  Result<void> unsupported(const Error& problem);

  Scene& scene_;
  std::string path_;
  std::filesystem::path folder_;
  LoadOptions options_;
  uint64_t image_bytes_ = 0;
  std::unordered_set<std::string> libraries_;                // those read
  std::unordered_map<std::string, Definition> definitions_;  // by name
  std::unordered_map<std::string, uint32_t> materials_;      // by name: index in the scene
  std::unordered_map<std::string, int32_t> images_;          // by path: index in the scene, or -1
};

}  // namespace sinew
