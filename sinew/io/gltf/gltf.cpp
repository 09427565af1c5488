// The glTF loader, stage by stage. The JSON is read by nlohmann::json behind checked accessors of
// our own rather than by tinygltf, which reads files and image URIs itself (CVE-2022-3008), leaves
// bounds, sparse data and node cycles to its caller, and asserts on odd documents.
#include "sinew/io/gltf/gltf.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "sinew/io/gltf/animation.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/io/gltf/extras.h"
#include "sinew/io/gltf/material.h"
#include "sinew/io/gltf/mesh.h"
#include "sinew/io/gltf/node.h"
#include "sinew/io/gltf/view.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace gltf {
namespace {

constexpr std::array<std::string_view, 16> kSupported = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",  // describes the asset, changes nothing that is seen
};

template <size_t N>
bool contains(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Result<void> check_extensions(const Json& root, Warnings& warnings) {
  SINEW_TRY(const std::vector<std::string> required, root.texts("extensionsRequired"));
  for (const std::string& name : required) {
    if (contains(kSupported, name)) continue;
    return root.error(fmt::format("needs the extension {}, which is not supported", name),
                      "export the file without this extension");
  }
  SINEW_TRY(const std::vector<std::string> used, root.texts("extensionsUsed"));
  for (const std::string& name : used) {
    if (!contains(kSupported, name)) {
      warnings.add("", fmt::format("the extension {} is not supported; ignored", name));
    }
  }
  return {};
}

// The name of the scene and its extras.
Result<void> read_scene(const Json& root, Scene& scene) {
  SINEW_TRY(const std::vector<Json> scenes, root.objects("scenes", "scene"));
  if (scenes.empty()) return {};
  SINEW_TRY(const auto index, root.index("scene", scenes.size()));
  const Json& json = scenes[index.value_or(0)];
  SINEW_TRY(scene.name, json.text("name"));
  return read_scene_extras(json, scene);
}

Result<Scene> parse(std::string bytes, const std::string& path, std::vector<Svo> octrees,
                    const LoadOptions& options) {
  MemoryBudget budget(options.memory_limit);
  Warnings warnings;
  SINEW_TRY(const Asset asset, open_asset(path, std::move(bytes), budget));
  const Json root = asset.root();
  SINEW_CHECKED(check_extensions(root, warnings));
  SINEW_TRY(const AccessorReader accessors, AccessorReader::create(asset, budget, warnings));
  const Reader reader{asset, accessors, budget, warnings};

  Scene scene;
  scene.octrees = std::move(octrees);
  SINEW_CHECKED(read_scene(root, scene));
  SINEW_TRY(const NodeGraph graph, read_graph(root));
  SINEW_CHECKED(read_cameras(root, scene));
  SINEW_CHECKED(read_lights(root, scene));
  SINEW_CHECKED(read_materials(reader, scene));
  SINEW_TRY(const std::vector<int32_t> meshes, read_meshes(reader, graph, scene));
  SINEW_TRY(const std::vector<NodePlace> places, read_nodes(reader, graph, meshes, scene));
  SINEW_CHECKED(read_skins(reader, graph, places, scene));
  SINEW_CHECKED(read_animations(reader, places, scene));
  list_objects(scene);

  scene.warnings = warnings.texts();
  if (options.strict && !scene.warnings.empty()) {
    return root.error(fmt::format("{}", fmt::join(scene.warnings, "; ")),
                      "load without --strict to ignore this");
  }
  return scene;
}

}  // namespace

Result<Scene> decode_glb(std::string bytes, const std::string& path, std::vector<Svo> octrees,
                         const LoadOptions& options) {
  return parse(std::move(bytes), path, std::move(octrees), options);
}

}  // namespace gltf

Result<Scene> load_gltf(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(std::string bytes, read_file(path, options.memory_limit));
  return parse_gltf(std::move(bytes), path, options);
}

Result<Scene> parse_gltf(std::string bytes, const std::string& path, const LoadOptions& options) {
  return gltf::parse(std::move(bytes), path, {}, options);
}

}  // namespace sinew
