#include "sinew/io/obj/obj.h"

#include <filesystem>
#include <utility>

#include "sinew/io/obj/material.h"
#include "sinew/io/obj/mesh.h"
#include "sinew/io/obj/parse.h"

namespace sinew {

Result<Scene> load_obj(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(ObjModel model, read_obj(path, options));
  Scene scene;
  scene.warnings = std::move(model.warnings);
  ObjMaterials materials(scene, path, options);
  SINEW_TRY(const std::vector<uint32_t> part_materials, materials.of_parts(model));
  scene.meshes.push_back(make_obj_mesh(model, part_materials, scene.warnings));
  Node& node = scene.nodes.emplace_back();
  node.name = scene.meshes[0].name = std::filesystem::path(path).stem().string();
  node.mesh = 0;
  list_objects(scene);
  return scene;
}

}  // namespace sinew
