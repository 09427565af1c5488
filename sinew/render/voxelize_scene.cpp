#include "sinew/render/voxelize_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>

#include "sinew/base/memory_use.h"
#include "sinew/math/srgb.h"
#include "sinew/render/voxels/voxel_looks.h"
#include "sinew/scene/sample.h"
#include "sinew/svo/make/make_parts.h"
#include "sinew/svo/make/rims.h"

namespace sinew {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool stands_still(const Mesh& mesh) {
  return mesh.keys > 0 || mesh.vertex_program != nullptr;
}

std::string name_of(const Scene& scene, const SceneObject& object) {
  const std::string& mesh = scene.meshes[object.mesh].name;
  if (!mesh.empty()) return mesh;
  const std::string& node = scene.nodes[object.node].name;
  return node.empty() ? fmt::format("object {}", &object - scene.objects.data()) : node;
}

// One octree: a mesh, with the joints of a skin or without.
struct OctreeJob {
  uint32_t object = 0;  // the first one that shows it
  double scale = 0.0;   // world over object, by lengths of edges; the largest of its instances
};

// The object's vertices at rest in the world.
std::vector<vec3> world_vertices(const Scene& scene, const ScenePose& pose, uint32_t object) {
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  std::vector<vec3> positions(mesh.positions.size());
  if (!stands_still(mesh)) {
    world_positions(scene, pose, object, positions);
    return positions;
  }
  std::transform(mesh.positions.begin(), mesh.positions.end(), positions.begin(),
                 [&](vec3 p) { return transform_point(pose.objects[object].placement, p); });
  return positions;
}

double sum_of_edges(std::span<const vec3> positions, std::span<const uvec3> triangles) {
  double sum = 0.0;
  for (const uvec3& t : triangles) {
    const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
    const double edges = length(b - a) + length(c - b) + length(a - c);
    if (std::isfinite(edges)) sum += edges;
  }
  return sum;
}

Motion motion_of_voxels(const Mesh& mesh, bool skinned) {
  return stands_still(mesh) ? Motion(RigidMotion{mesh.positions}) : motion_of(mesh, skinned);
}

Error named(Error error, const std::string& name) {
  error.element = error.element.empty() ? name : name + ", " + error.element;
  return error;
}

std::vector<uint16_t> materials_of(const Mesh& mesh) {
  std::vector<uint16_t> materials(mesh.triangles.size());
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    materials[i] = static_cast<uint16_t>(mesh.material_of(i));
  }
  return materials;
}

// `voxel`: the side in the object's space; 0: the resolution counts.
Result<VoxelGrid> choose_grid(const Scene& scene, const Mesh& mesh, float voxel,
                              const VoxelizeSceneOptions& options) {
  if (scene.materials.size() > std::numeric_limits<uint16_t>::max()) {
    return fail({ErrorKind::bad_input, scene.name, "", "more materials than octrees can name", ""});
  }
  const Box box = surface_box(mesh.positions, mesh.triangles);
  return voxel > 0.0f ? grid_of_voxels(box, voxel) : grid_of_resolution(box, options.resolution);
}

// Thin shells reach beyond open edges and sharp folds.
std::vector<uint8_t> rims_of(const Mesh& mesh, const VoxelizeSceneOptions& options) {
  if (options.shell != Shell::thin) return {};
  return rim_triangles(mesh.positions, mesh.triangles);
}

VoxelizeOptions surface_options(const VoxelizeSceneOptions& options, std::span<const uint8_t> rims,
                                const MeshLooks& looks) {
  return {.shell = options.shell,
          .rims = rims,
          .solid = options.solid,
          .inside_color = looks.mean_color(),
          .memory_limit = options.memory_limit};
}

Result<VoxelizedObject> voxelize_with(const Scene& scene, uint32_t index, float voxel,
                                      const VoxelizeSceneOptions& options, LookTextures& textures) {
  const SceneObject& object = scene.objects[index];
  const Mesh& mesh = scene.meshes[object.mesh];
  SINEW_TRY(const VoxelGrid grid, choose_grid(scene, mesh, voxel, options));
  textures.prepare(mesh, grid.voxel);
  const MeshLooks looks(scene, mesh, textures);
  VoxelizedObject out;
  const std::vector<uint8_t> rims = rims_of(mesh, options);
  SINEW_TRY(out.surface, voxelize(mesh.positions, mesh.triangles, grid, looks,
                                  surface_options(options, rims, looks)));
  out.triangles = mesh.triangles;
  out.materials = materials_of(mesh);
  out.motion = motion_of_voxels(mesh, object.skin >= 0);
  return out;
}

// The image's mean, each channel in 0..1; white if there is none.
vec4 mean_of(std::span<const Image8> images, const TextureRef& texture, bool srgb) {
  const Image8* image = texture_image(images, texture);
  if (image == nullptr) return vec4(1.0f);
  const std::array<float, 256>& decode = srgb_codes_to_linear();
  glm::dvec4 sum(0.0);
  for (size_t i = 0; i < image->pixels.size(); ++i) {
    const uint8_t code = image->pixels[i];
    sum[static_cast<int>(i % 4)] += srgb && i % 4 < 3 ? decode[code] : code / 255.0;
  }
  return vec4(sum / static_cast<double>(image->pixels.size() / 4));
}

// Voxels have their colours and normals; of other textures the mean is left.
void drop_textures(std::span<const Image8> images, Material& m) {
  const vec4 surface = mean_of(images, m.metallic_roughness_texture, false);
  m.roughness *= surface.y;
  m.metallic *= surface.z;
  m.emissive *= vec3(mean_of(images, m.emissive_texture, true));
  m.transmission *= mean_of(images, m.transmission_texture, false).x;
  for (TextureRef* texture :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
        &m.occlusion_texture, &m.emissive_texture, &m.transmission_texture}) {
    *texture = {};
  }
}

// The work on one scene.
class SceneVoxelizer {
 public:
  SceneVoxelizer(const Scene& scene, const VoxelizeSceneOptions& options)
      : from_(scene), options_(options), textures_(scene) {}

  Result<VoxelizedScene> run() {
    SINEW_CHECKED(list_jobs());
    SINEW_CHECKED(choose_voxel());
    out_.scene = from_;
    for (uint32_t i = 0; i < jobs_.size(); ++i) {
      const std::string name = name_of(from_, from_.objects[jobs_[i].object]);
      if (options_.on_octree && !options_.on_octree(i, static_cast<uint32_t>(jobs_.size()), name)) {
        return fail({ErrorKind::runtime, from_.name, "", "voxelising was ended", ""});
      }
      if (Result<void> made = make_octree(jobs_[i], name); !made) {
        return fail(named(made.error(), name));
      }
    }
    hang_octrees();
    drop_meshes();
    list_objects(out_.scene);
    return std::move(out_);
  }

 private:
  bool is_chosen(uint32_t object) const {
    return options_.chosen.empty() || options_.chosen[object] != 0;
  }

  // Which octrees there will be, and how large what they show is.
  Result<void> list_jobs() {
    ScenePose pose;
    sample(from_, kRestPose, 0.0, pose);
    std::map<std::pair<uint32_t, bool>, uint32_t> known;
    job_of_.assign(from_.objects.size(), -1);
    uint32_t chosen = 0;
    for (uint32_t i = 0; i < from_.objects.size(); ++i) {
      if (!is_chosen(i)) continue;
      ++chosen;
      const SceneObject& object = from_.objects[i];
      const Mesh& mesh = from_.meshes[object.mesh];
      const std::vector<vec3> positions = world_vertices(from_, pose, i);
      const Box box = surface_box(positions, mesh.triangles);
      const double own = sum_of_edges(mesh.positions, mesh.triangles);
      const double scale = sum_of_edges(positions, mesh.triangles) / own;
      if (box.empty() || !is_finite(box) || !(scale > 0.0) || !std::isfinite(scale)) {
        warn(i, "has no surface at rest and is left out");
        continue;
      }
      world_.extend(box);
      const auto [place, is_new] =
          known.try_emplace({object.mesh, object.skin >= 0}, static_cast<uint32_t>(jobs_.size()));
      if (is_new) {
        jobs_.push_back({i, scale});
        if (stands_still(mesh)) {
          warn(i, "moves by a vertex cache or program: its voxels stand still");
        }
      }
      OctreeJob& job = jobs_[place->second];
      job.scale = std::max(job.scale, scale);
      job_of_[i] = static_cast<int32_t>(place->second);
    }
    if (jobs_.empty()) {
      return fail({chosen == 0 ? ErrorKind::usage : ErrorKind::bad_input, from_.name, "",
                   "there is no object to voxelise", ""});
    }
    return {};
  }

  void warn(uint32_t object, const char* what) {
    warnings_.push_back(fmt::format("'{}' {}", name_of(from_, from_.objects[object]), what));
  }

  Result<void> choose_voxel() {
    if (options_.voxel > 0.0) {
      out_.voxel = options_.voxel;
      return {};
    }
    if (options_.resolution == 0 || options_.resolution > kHighestResolution) {
      return fail({ErrorKind::usage, "", fmt::format("resolution {}", options_.resolution),
                   "that is no resolution", fmt::format("write 1 to {}", kHighestResolution)});
    }
    const glm::dvec3 extent = glm::dvec3(world_.max) - glm::dvec3(world_.min);
    out_.voxel = voxel_side(std::max({extent.x, extent.y, extent.z}), options_.resolution);
    return {};
  }

  Result<void> make_octree(const OctreeJob& job, const std::string& name) {
    const Mesh& mesh = from_.meshes[from_.objects[job.object].mesh];
    const bool own = options_.each && !(options_.voxel > 0.0);
    const float voxel = own ? 0.0f : static_cast<float>(out_.voxel / job.scale);
    OctreeReport report;
    report.name = name;
    report.triangles = mesh.triangles.size();
    SINEW_TRY(Svo octree, options_.taker != nullptr ? make_by_parts(job, voxel, name, report)
                                                    : make_at_once(job, voxel, name, report));
    report.resolution = octree.grid.resolution;
    report.voxel = octree.grid.voxel;
    out_.octrees.push_back(std::move(report));
    out_.scene.octrees.push_back(std::move(octree));
    return {};
  }

  static void set_name(const Mesh& mesh, const std::string& name, Svo& octree) {
    octree.name = name;
    octree.morph_weights.resize(octree.morph_targets, 0.0f);
    std::copy_n(mesh.morph_weights.begin(),
                std::min(mesh.morph_weights.size(), octree.morph_weights.size()),
                octree.morph_weights.begin());
  }

  Result<Svo> make_at_once(const OctreeJob& job, float voxel, const std::string& name,
                           OctreeReport& report) {
    const auto start = Clock::now();
    SINEW_TRY(const VoxelizedObject made,
              voxelize_with(from_, job.object, voxel, options_, textures_));
    report.voxelize_s = seconds_since(start);
    const auto between = Clock::now();
    SINEW_TRY(Svo octree, make_svo(made.surface, made.source()));
    report.octree_s = seconds_since(between);
    set_name(from_.meshes[from_.objects[job.object].mesh], name, octree);
    report.fragments = made.surface.fragments.size();
    report.voxels = octree.voxel_count();
    report.bytes = octree.bytes();
    return octree;
  }

  // Bytes of the limit that are taken before an octree is begun.
  uint64_t standing_bytes() const { return options_.whole_process ? resident_bytes() : 0; }

  // Returns what the scene around has to know of it.
  Result<Svo> make_by_parts(const OctreeJob& job, float voxel, const std::string& name,
                            OctreeReport& report) {
    const auto start = Clock::now();
    const SceneObject& object = from_.objects[job.object];
    const Mesh& mesh = from_.meshes[object.mesh];
    SINEW_TRY(const VoxelGrid grid, choose_grid(from_, mesh, voxel, options_));
    textures_.prepare(mesh, grid.voxel);
    const MeshLooks looks(from_, mesh, textures_);
    const std::vector<uint8_t> rims = rims_of(mesh, options_);
    SurfaceVoxelizer surface(mesh.positions, mesh.triangles, grid, looks,
                             surface_options(options_, rims, looks));
    const std::vector<uint16_t> materials = materials_of(mesh);
    SvoPartsOptions parts;
    return_free_memory();
    parts.standing = standing_bytes();
    parts.memory = options_.memory_limit;
    parts.on_part = options_.on_part;
    parts.take = [&](const Svo& part) {
      report.voxels += part.voxel_count();
      return options_.taker->part(part);
    };
    SINEW_TRY(
        SvoPartsMade made,
        make_svo_by_parts(
            surface, {mesh.triangles, materials, motion_of_voxels(mesh, object.skin >= 0)}, parts));
    set_name(mesh, name, made.outline);
    SINEW_CHECKED(options_.taker->outline(made.outline));
    report.voxelize_s = seconds_since(start);
    report.fragments = made.fragments;
    report.bytes = made.bytes;
    report.parts = made.parts;
    Svo hollow = std::move(made.outline);
    hollow.nodes.clear();
    hollow.node_level = {};
    hollow.blocks.clear();
    return hollow;
  }

  // Nodes of chosen objects show octrees instead of meshes.
  void hang_octrees() {
    Scene& scene = out_.scene;
    const auto first = static_cast<int32_t>(from_.octrees.size());
    for (uint32_t i = 0; i < from_.objects.size(); ++i) {
      if (!is_chosen(i) && options_.keep_meshes) continue;
      Node& node = scene.nodes[from_.objects[i].node];
      node.mesh = -1;
      if (job_of_[i] >= 0) node.octree = first + job_of_[i];
      const uint32_t targets =
          node.octree < 0 ? 0 : scene.octrees[static_cast<size_t>(node.octree)].morph_targets;
      if (node.weights.size() != targets) node.weights.clear();
      if (node.octree < 0) node.skin = -1;
    }
    for (Clip& clip : scene.clips) {
      std::erase_if(clip.channels, [&](const Channel& channel) {
        const Node& node = scene.nodes[channel.node];
        if (node.mesh >= 0) return false;
        if (channel.path == ChannelPath::cache_key) return true;
        return channel.path == ChannelPath::weights &&
               (node.octree < 0 ||
                scene.octrees[static_cast<size_t>(node.octree)].morph_targets == 0);
      });
    }
    scene.warnings = from_.warnings;
    scene.warnings.insert(scene.warnings.end(), warnings_.begin(), warnings_.end());
  }

  void drop_meshes() {
    Scene& scene = out_.scene;
    std::vector<int32_t> place(scene.meshes.size(), -1);
    for (const Node& node : scene.nodes) {
      if (node.mesh >= 0) place[static_cast<size_t>(node.mesh)] = 0;
    }
    std::vector<Mesh> kept;
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
      if (place[i] < 0) continue;
      place[i] = static_cast<int32_t>(kept.size());
      kept.push_back(std::move(scene.meshes[i]));
    }
    scene.meshes = std::move(kept);
    for (Node& node : scene.nodes) {
      if (node.mesh >= 0) node.mesh = place[static_cast<size_t>(node.mesh)];
    }
    if (!scene.meshes.empty()) return;
    for (Material& material : scene.materials) drop_textures(scene.images, material);
    scene.images.clear();
  }

  const Scene& from_;
  const VoxelizeSceneOptions& options_;
  LookTextures textures_;
  std::vector<OctreeJob> jobs_;
  std::vector<int32_t> job_of_;  // one an object; -1: none
  std::vector<std::string> warnings_;
  Box world_;
  VoxelizedScene out_;
};

}  // namespace

Result<VoxelizedObject> voxelize_object(const Scene& scene, uint32_t object,
                                        const VoxelizeSceneOptions& options) {
  LookTextures textures(scene);
  Result<VoxelizedObject> made =
      voxelize_with(scene, object, static_cast<float>(options.voxel), options, textures);
  if (!made) return fail(named(made.error(), name_of(scene, scene.objects[object])));
  return made;
}

Result<VoxelizedScene> voxelize_scene(const Scene& scene, const VoxelizeSceneOptions& options) {
  return SceneVoxelizer(scene, options).run();
}

}  // namespace sinew
