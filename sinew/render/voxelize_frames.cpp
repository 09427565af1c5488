#include "sinew/render/voxelize_frames.h"

#include <algorithm>

#include "sinew/render/voxels/voxel_looks.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

// The object's vertices at one time; none if it is not there.
std::vector<vec3> world_vertices(const Scene& scene, const ScenePose& pose, uint32_t object) {
  const Pose& own = pose.objects[object];
  if (!own.present) return {};
  std::vector<vec3> positions(scene.meshes[scene.objects[object].mesh].positions.size());
  world_positions(scene, pose, object, positions);
  return positions;
}

std::vector<PlainVoxel> plain_voxels_of(const Mesh& mesh, const VoxelSurface& surface) {
  std::vector<PlainVoxel> out;
  out.reserve(surface.voxels);
  uint16_t material = 0;  // of the last triangle, for what is inside
  for (const VoxelFragment& f : surface.fragments) {
    if (!out.empty() && out.back().voxel == f.voxel) continue;
    if (f.triangle != kInside) material = static_cast<uint16_t>(mesh.material_of(f.triangle));
    out.push_back({f.voxel, f.normal, f.color, material});
  }
  return out;
}

// Boxes of the objects over all times.
std::vector<Box> boxes_over(const Scene& scene, int clip, std::span<const double> times,
                            std::span<const uint32_t> objects) {
  std::vector<Box> boxes(objects.size());
  ScenePose pose;
  for (const double time : times) {
    sample(scene, clip, time, pose);
    for (size_t i = 0; i < objects.size(); ++i) {
      const std::vector<vec3> positions = world_vertices(scene, pose, objects[i]);
      if (positions.empty()) continue;
      boxes[i].extend(
          surface_box(positions, scene.meshes[scene.objects[objects[i]].mesh].triangles));
    }
  }
  return boxes;
}

Result<float> side_of_voxels(std::span<const Box> boxes, const VoxelizeSceneOptions& options) {
  if (options.voxel > 0.0) return static_cast<float>(options.voxel);
  Box all;
  for (const Box& box : boxes) all.extend(box);
  SINEW_TRY(const VoxelGrid grid, grid_of_resolution(all, options.resolution));
  return grid.voxel;
}

// An object that is seen at some time.
struct Shown {
  uint32_t object = 0;
  MeshLooks looks;
};

Result<void> add_frame(const Scene& scene, const ScenePose& pose, const Shown& shown,
                       const VoxelizeSceneOptions& options, VoxelFrames& out) {
  const Mesh& mesh = scene.meshes[scene.objects[shown.object].mesh];
  out.frames.emplace_back();
  const std::vector<vec3> positions = world_vertices(scene, pose, shown.object);
  if (positions.empty()) return {};
  SINEW_TRY(const VoxelSurface surface, voxelize(positions, mesh.triangles, out.grid, shown.looks,
                                                 {.shell = options.shell,
                                                  .solid = options.solid,
                                                  .inside_color = shown.looks.mean_color(),
                                                  .memory_limit = options.memory_limit}));
  out.frames.back() = plain_voxels_of(mesh, surface);
  return {};
}

}  // namespace

Result<std::vector<VoxelFrames>> voxelize_frames(const Scene& scene, int clip,
                                                 std::span<const double> times,
                                                 const VoxelizeSceneOptions& options) {
  std::vector<uint32_t> objects;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (options.chosen.empty() || options.chosen[i] != 0) objects.push_back(i);
  }
  const std::vector<Box> boxes = boxes_over(scene, clip, times, objects);
  SINEW_TRY(const float voxel, side_of_voxels(boxes, options));
  LookTextures textures(scene);
  std::vector<VoxelFrames> out;
  std::vector<Shown> shown;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (boxes[i].empty()) continue;
    const SceneObject& object = scene.objects[objects[i]];
    const Mesh& mesh = scene.meshes[object.mesh];
    VoxelFrames made;
    made.name = scene.nodes[object.node].name.empty() ? mesh.name : scene.nodes[object.node].name;
    made.triangles = mesh.triangles.size();
    SINEW_TRY(made.grid, grid_of_voxels(boxes[i], voxel));
    textures.prepare(mesh, voxel);
    shown.push_back({objects[i], MeshLooks(scene, mesh, textures)});
    out.push_back(std::move(made));
  }
  ScenePose pose;
  for (const double time : times) {
    sample(scene, clip, time, pose);
    for (size_t i = 0; i < shown.size(); ++i) {
      SINEW_CHECKED(add_frame(scene, pose, shown[i], options, out[i]));
    }
  }
  return out;
}

}  // namespace sinew
