// Writes .svo files.
#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "sinew/io/gltf/embed.h"
#include "sinew/io/output_file.h"
#include "sinew/io/svo/container.h"
#include "sinew/io/svo/svo.h"
#include "sinew/io/text.h"
#include "sinew/svo/file/file.h"

namespace sinew {
namespace {

// Leaves out the meshes that only other files can hold, and channels that move nothing then.
void remove_caches(Scene& scene, std::vector<std::string>& warnings) {
  for (Node& node : scene.nodes) {
    if (node.mesh < 0) continue;
    const Mesh& mesh = scene.meshes[static_cast<size_t>(node.mesh)];
    if (mesh.keys == 0 && !mesh.vertex_program) continue;
    warnings.push_back(fmt::format("mesh '{}': left out: .svo files have no vertex caches",
                                   mesh.name.empty() ? node.name : mesh.name));
    node.mesh = -1;
    node.skin = -1;
    node.weights.clear();
  }
  for (Clip& clip : scene.clips) {
    std::erase_if(clip.channels, [&](const Channel& channel) {
      const Node& node = scene.nodes[channel.node];
      return channel.path == ChannelPath::cache_key ||
             (channel.path == ChannelPath::weights && node.mesh < 0 && node.octree < 0);
    });
  }
}

// Calls visit with every texture of the material.
template <class Visit>
void for_each_texture(Material& material, const Visit& visit) {
  for (TextureRef* const texture :
       {&material.base_color_texture, &material.metallic_roughness_texture,
        &material.normal_texture, &material.occlusion_texture, &material.emissive_texture,
        &material.transmission_texture}) {
    visit(*texture);
  }
}

// Leaves out textures of materials that only voxels have, and images that nobody uses then.
void remove_textures(Scene& scene) {
  std::vector<bool> on_mesh(scene.materials.size(), false);
  for (const SceneObject& object : scene.objects) {
    for (const MeshPart& part : scene.meshes[object.mesh].parts) on_mesh[part.material] = true;
  }
  std::vector<int32_t> new_index(scene.images.size(), -1);
  std::vector<Image8> images;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    for_each_texture(scene.materials[i], [&](TextureRef& texture) {
      if (texture.image < 0) return;
      if (!on_mesh[i]) {
        texture = {};
        return;
      }
      int32_t& index = new_index[static_cast<size_t>(texture.image)];
      if (index < 0) {
        index = static_cast<int32_t>(images.size());
        images.push_back(std::move(scene.images[static_cast<size_t>(texture.image)]));
      }
      texture.image = index;
    });
  }
  scene.images = std::move(images);
}

// The scene around the octrees; of those, only what nodes and clips need to know.
Scene scene_around(const Scene& scene, std::vector<std::string>& warnings) {
  Scene result;
  result.name = scene.name;
  for (const Svo& octree : scene.octrees) {
    Svo& hollow = result.octrees.emplace_back();
    hollow.joints = octree.joints;
    hollow.morph_targets = octree.morph_targets;
    hollow.morph_weights = octree.morph_weights;
  }
  std::vector<bool> shown(scene.meshes.size(), false);
  for (const SceneObject& object : scene.objects) shown[object.mesh] = true;
  result.meshes.resize(scene.meshes.size());
  for (size_t i = 0; i < shown.size(); ++i) {
    if (shown[i]) result.meshes[i] = scene.meshes[i];
  }
  result.materials = scene.materials;
  if (!scene.objects.empty())
    result.images = scene.images;
  else
    result.images.resize(scene.images.size());
  result.nodes = scene.nodes;
  result.skins = scene.skins;
  result.cameras = scene.cameras;
  result.lights = scene.lights;
  result.clips = scene.clips;
  result.environment = scene.environment;
  result.default_frames = scene.default_frames;
  result.default_fps = scene.default_fps;
  remove_caches(result, warnings);
  list_objects(result);
  remove_textures(result);
  return result;
}

}  // namespace

// One file. Octrees are in memory, but for the last ones, which are in the store.
class SvoSaver {
 public:
  SvoSaver(const Scene& scene, const SvoStore* store, const std::string& path,
           const SaveSvoOptions& options)
      : scene_(scene), path_(path), options_(options) {
    if (store != nullptr) stored_ = store->octrees_;
  }

  Result<SavedSvo> run() {
    if (const std::string problem = validate(scene_); !problem.empty()) {
      return fail({ErrorKind::bad_input, scene_.name, "", problem, "correct the scene"});
    }
    if (scene_.octrees.empty()) {
      return fail({ErrorKind::bad_input, scene_.name, "", "holds no voxels",
                   "make some with `sinew voxelize`"});
    }
    SavedSvo saved;
    saved.path = path_;
    const Scene around = scene_around(scene_, saved.warnings);
    SINEW_TRY(const std::vector<uint8_t> glb, gltf::encode_glb(around, saved.warnings));
    const std::vector<uint8_t> section = svo_file::pack_scene(glb, options_.effort);
    SINEW_CHECKED(encode(saved));
    const std::vector<uint8_t> header = svo_file::make_header(section.size(), sizes_);
    SINEW_TRY(OutputFile file, OutputFile::create(path_));
    SINEW_CHECKED(file.write(header));
    SINEW_CHECKED(file.write(section));
    for (const EncodedSvo& octree : encoded_) SINEW_CHECKED(file.write(octree.bytes));
    for (const SvoStore::Octree& octree : stored_) {
      SINEW_CHECKED(file.write(octree.front));
      SINEW_CHECKED(octree.skeletons.copy_to(file));
      SINEW_CHECKED(octree.details.copy_to(file));
    }
    SINEW_CHECKED(file.publish());
    saved.bytes = file.size();
    saved.parts = list_parts(parts_, header.size() + section.size());
    return saved;
  }

 private:
  Result<void> encode(SavedSvo& saved) {
    for (const Svo& octree :
         std::span(scene_.octrees).first(scene_.octrees.size() - stored_.size())) {
      SINEW_TRY(encoded_.emplace_back(), encode_svo(octree, options_.effort));
      parts_.add(encoded_.back().parts);
      sizes_.push_back(encoded_.back().bytes.size());
      saved.voxels += octree.voxel_count();
    }
    for (const SvoStore::Octree& octree : stored_) {
      parts_.add(octree.parts);
      sizes_.push_back(octree.size());
      saved.voxels += octree.voxels;
    }
    return {};
  }

  const Scene& scene_;
  const std::string& path_;
  SaveSvoOptions options_;
  std::span<const SvoStore::Octree> stored_;
  std::vector<EncodedSvo> encoded_;
  std::vector<uint64_t> sizes_;  // of the octrees' sections
  SvoFileParts parts_;
};

namespace {

Result<SavedSvo> save(const Scene& scene, const SvoStore* store, const std::string& path,
                      const SaveSvoOptions& options) {
  try {
    SINEW_CHECKED(check_save_svo(path));
    return SvoSaver(scene, store, path, options).run();
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::runtime, path, "", "does not fit into this machine's memory",
                 "use a smaller scene"});
  } catch (const std::exception& error) {
    return fail(
        {ErrorKind::runtime, path, "", std::string("cannot be written: ") + error.what(), ""});
  }
}

}  // namespace

Result<void> SvoStore::add(const Svo& part) {
  if (!encoder_) {
    SINEW_TRY(SpoolFile skeletons, SpoolFile::create(path_));
    SINEW_TRY(SpoolFile details, SpoolFile::create(path_));
    octrees_.push_back({std::move(skeletons), std::move(details), {}, {}, 0});
    encoder_ = std::make_unique<SvoEncoder>(
        options_.effort,
        [this](std::span<const uint8_t> bytes) { return octrees_.back().skeletons.write(bytes); },
        [this](std::span<const uint8_t> bytes) { return octrees_.back().details.write(bytes); });
  }
  octrees_.back().voxels += part.voxel_count();
  return encoder_->add(part);
}

Result<void> SvoStore::finish(const Svo& outline) {
  EncodedSvo front = encoder_->finish(outline);
  encoder_.reset();
  octrees_.back().front = std::move(front.bytes);
  octrees_.back().parts = front.parts;
  return {};
}

Result<SavedSvo> save_svo(const Scene& scene, const std::string& path,
                          const SaveSvoOptions& options) {
  return save(scene, nullptr, path, options);
}

Result<SavedSvo> save_svo(const Scene& scene, const SvoStore& store, const std::string& path,
                          const SaveSvoOptions& options) {
  return save(scene, &store, path, options);
}

Result<void> check_save_svo(const std::string& path) {
  if (path != "-" && extension_of(path) != ".svo") {
    return fail(
        {ErrorKind::usage, path, "", "is no name of a file of octrees", "name the output .svo"});
  }
  return check_writable(path);
}

}  // namespace sinew
