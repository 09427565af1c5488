#include "sinew/io/polygon/scene.h"

#include <filesystem>
#include <utility>

#include "sinew/io/obj/material.h"
#include "sinew/io/obj/parse.h"
#include "sinew/io/output_file.h"
#include "sinew/io/ply/parse.h"
#include "sinew/io/polygon/mesh.h"
#include "sinew/io/text.h"

namespace sinew {

Result<PolygonModel> read_polygons(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(const std::string bytes, read_file(path, options.memory_limit));
  const auto parse = extension_of(path) == ".ply" ? parse_ply : parse_obj;
  return parse(bytes, path, options);
}

Result<Scene> load_polygons(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(PolygonModel model, read_polygons(path, options));
  return make_polygon_scene(std::move(model), path, options);
}

Result<Scene> make_polygon_scene(PolygonModel model, const std::string& path,
                                 const LoadOptions& options) {
  Scene scene;
  scene.warnings = std::move(model.warnings);
  ObjMaterials materials(scene, path, options);
  SINEW_TRY(const std::vector<uint32_t> part_materials, materials.of_parts(model));
  scene.meshes.push_back(make_polygon_mesh(model, part_materials, scene.warnings));
  Node& node = scene.nodes.emplace_back();
  node.name = scene.meshes[0].name = std::filesystem::path(path).stem().string();
  node.mesh = 0;
  list_objects(scene);
  return scene;
}

}  // namespace sinew
