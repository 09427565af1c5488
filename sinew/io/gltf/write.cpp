// Writes a scene as glTF 2.0 (Khronos Group, 2021; ISO/IEC 12113:2022): first the JSON document,
// which says where everything will be, then the binary data, view by view, so that memory holds one
// view at a time beside the scene. Names of extras that begin with sinew_ are our own; load() reads
// them back, others ignore them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>

#include "sinew/io/gltf/embed.h"
#include "sinew/io/gltf/uri.h"
#include "sinew/io/gltf/write_animation.h"
#include "sinew/io/gltf/write_material.h"
#include "sinew/io/gltf/write_mesh.h"
#include "sinew/io/gltf/write_node.h"
#include "sinew/io/output_file.h"
#include "sinew/io/save.h"
#include "sinew/io/text.h"

namespace sinew {
namespace gltf {
namespace {

namespace fs = std::filesystem;

// What the output's name says.
struct OutputNames {
  std::string scene;   // as the user named it
  std::string stem;    // without folder and extension
  std::string binary;  // of a .gltf: the .bin beside it; empty: it is a GLB
  std::string beside(const std::string& name) const {
    return (fs::path(scene).parent_path() / name).string();
  }
};

Result<OutputNames> names_of(const std::string& path) {
  OutputNames names{path, fs::path(path).stem().string(), ""};
  const std::string extension = extension_of(path);
  if (extension == ".gltf") {
    names.binary = names.stem + ".bin";
  } else if (extension != ".glb" && path != "-") {
    return fail(
        {ErrorKind::usage, path, "", "is no name of a glTF file", "name the output .glb or .gltf"});
  }
  return names;
}

// Faces alone may be more than any glTF file holds; then nothing needs to be prepared.
Result<void> check_size(const Scene& scene) {
  constexpr uint64_t kLeastBytes = 6;  // a triangle's indices
  uint64_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  if (triangles <= UINT32_MAX / kLeastBytes) return {};
  return fail({ErrorKind::bad_input, scene.name, "",
               fmt::format("has {} triangles, more than the 4 GiB of a glTF file hold", triangles),
               "split the scene into several files"});
}

// Fills the asset's JSON; returns what must live until its binary data are written.
Result<std::vector<MeshOutput>> describe(const WriteContext& context,
                                         const std::vector<MeshCache>& caches, SaveReport& report) {
  const std::vector<Clip> clips = clips_with_caches(context.scene, caches);
  SINEW_CHECKED(write_materials(context));
  std::vector<MeshOutput> meshes = write_meshes(context, caches);
  write_cameras(context);
  write_lights(context);
  const std::vector<NodeOutput> places = write_nodes(context, meshes, clips);
  report.clips = write_animations(context, clips, places, meshes, caches);
  report.triangles = count(context.scene).triangles;
  report.nodes = static_cast<uint32_t>(context.asset.root().value("nodes", JsonOut()).size());
  return meshes;
}

AssetWriter::Sink sink_of(OutputFile& file) {
  return [&file](std::span<const uint8_t> bytes) { return file.write(bytes); };
}

// Writes all files beside their places; nobody sees them yet. The scene comes last.
Result<std::vector<OutputFile>> write_files(const Scene& scene, const OutputNames& names,
                                            const std::vector<MeshCache>& caches,
                                            std::span<const MeshOutput> meshes,
                                            AssetWriter& asset) {
  const std::string json = asset.finish(percent_encode(names.binary));
  SINEW_CHECKED(asset.check_size(json, names.scene));
  std::vector<OutputFile> files;
  for (size_t i = 0; i < caches.size(); ++i) {
    if (caches[i].keys == 0) continue;
    SINEW_TRY(OutputFile file, OutputFile::create(names.beside(caches[i].file_name)));
    SINEW_CHECKED(write_cache(scene.meshes[i], caches[i], meshes[i].vertices, file));
    SINEW_CHECKED(file.close());
    files.push_back(std::move(file));
  }
  if (!names.binary.empty() && asset.binary_size() > 0) {
    SINEW_TRY(OutputFile file, OutputFile::create(names.beside(names.binary)));
    SINEW_CHECKED(asset.write_binary(sink_of(file)));
    SINEW_CHECKED(file.close());
    files.push_back(std::move(file));
  }
  SINEW_TRY(OutputFile file, OutputFile::create(names.scene));
  if (names.binary.empty()) {
    SINEW_CHECKED(asset.write_glb(json, sink_of(file)));
  } else {
    SINEW_CHECKED(file.write({reinterpret_cast<const uint8_t*>(json.data()), json.size()}));
  }
  SINEW_CHECKED(file.close());
  files.push_back(std::move(file));
  return files;
}

Result<SaveReport> save(const Scene& scene, const std::string& path, const SaveOptions& options) {
  SINEW_TRY(const OutputNames names, names_of(path));
  if (const std::string problem = validate(scene); !problem.empty()) {
    return fail({ErrorKind::bad_input, scene.name, "", problem, "correct the scene"});
  }
  SINEW_CHECKED(check_size(scene));
  SINEW_TRY(const std::vector<MeshCache> caches, plan_caches(scene, names.stem, options));
  const bool has_cache = std::any_of(caches.begin(), caches.end(),
                                     [](const MeshCache& cache) { return cache.keys > 0; });
  if (has_cache && path == "-") {
    return fail({ErrorKind::usage, "standard output", "",
                 "cannot hold the vertex caches, which are files of their own",
                 "name the output .glb or .gltf"});
  }
  SaveReport report;
  Warnings warnings;
  AssetWriter asset;
  const WriteContext context{scene, asset, warnings};
  SINEW_TRY(const std::vector<MeshOutput> meshes, describe(context, caches, report));
  for (const Svo& octree : scene.octrees) {
    warnings.add(element("octree", octree.name), "left out: glTF has no voxels; .svo files have");
  }
  if (has_cache) {
    warnings.add("", "glTF has no vertex caches: other programs show the caches' meshes at rest");
  }
  SINEW_TRY(std::vector<OutputFile> files, write_files(scene, names, caches, meshes, asset));
  for (OutputFile& file : files) {
    SINEW_CHECKED(file.publish());
    report.files.push_back({file.path(), file.size()});
  }
  std::rotate(report.files.begin(), report.files.end() - 1, report.files.end());
  report.warnings = warnings.texts();
  return report;
}

}  // namespace

Result<std::vector<uint8_t>> encode_glb(const Scene& scene, std::vector<std::string>& warnings) {
  SINEW_CHECKED(check_size(scene));
  const std::vector<MeshCache> caches(scene.meshes.size());
  SaveReport report;
  Warnings found;
  AssetWriter asset;
  const WriteContext context{scene, asset, found, true};
  SINEW_TRY(const std::vector<MeshOutput> meshes, describe(context, caches, report));
  const std::string json = asset.finish("");
  SINEW_CHECKED(asset.check_size(json, scene.name));
  std::vector<uint8_t> bytes;
  SINEW_CHECKED(asset.write_glb(json, [&](std::span<const uint8_t> more) -> Result<void> {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return {};
  }));
  const std::vector<std::string> texts = found.texts();
  warnings.insert(warnings.end(), texts.begin(), texts.end());
  return bytes;
}

}  // namespace gltf

Result<void> check_save(const std::string& path) {
  SINEW_CHECKED(gltf::names_of(path));
  return check_writable(path);
}

Result<SaveReport> save_gltf(const Scene& scene, const std::string& path,
                             const SaveOptions& options) {
  try {
    return gltf::save(scene, path, options);
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::runtime, path, "", "does not fit into this machine's memory",
                 "use a smaller scene"});
  } catch (const std::exception& error) {
    return fail(
        {ErrorKind::runtime, path, "", std::string("cannot be written: ") + error.what(), ""});
  }
}

}  // namespace sinew
