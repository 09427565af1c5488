#include "bench/embree_world.h"

#include <algorithm>
#include <map>

#include "sinew/base/parallel.h"

namespace sinew::bench {
namespace {

constexpr uint32_t kNoShape = 0xffffffffu;
constexpr uint32_t kChunk = 2048;  // vertices a task moves

// Whether the clip leaves each node where it is.
std::vector<bool> still_nodes(const Scene& scene, int clip) {
  std::vector<bool> still(scene.nodes.size(), true);
  if (clip != kRestPose) {
    for (const Channel& channel : scene.clips[clip].channels) still[channel.node] = false;
  }
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const int32_t parent = scene.nodes[i].parent;
    if (parent >= 0 && !still[parent]) still[i] = false;
  }
  return still;
}

void place(const Affine& placement, std::span<vec3> points) {
  if (placement == identity_affine()) return;
  for (vec3& p : points) p = transform_point(placement, p);
}

}  // namespace

EmbreeWorld::EmbreeWorld(const Scene& scene, int clip, const ScenePose& pose,
                         const EmbreeConfig& config)
    : embree_(config), shape_of_(scene.objects.size(), kNoShape), vertices_(scene.objects.size()) {
  const std::vector<bool> still = still_nodes(scene, clip);
  for (const SceneObject& object : scene.objects) {
    meshes_.push_back(&scene.meshes[object.mesh]);
    motions_.push_back(motion_of(*meshes_.back(), object.skin >= 0));
  }
  std::map<const Mesh*, uint32_t> shapes;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh& mesh = *meshes_[i];
    const bool rigid = !deforms(motions_[i]), stays = still[scene.objects[i].node];
    if (rigid && !stays) {
      const auto [found, added] = shapes.try_emplace(&mesh, 0);
      if (added) found->second = embree_.add_shape(mesh.positions, mesh.triangles);
      shape_of_[i] = found->second;
    }
    add_object(i, rigid && stays, pose);
  }
  deform(pose);
  embree_.commit();
}

void EmbreeWorld::add_object(uint32_t object, bool still, const ScenePose& pose) {
  const Mesh& mesh = *meshes_[object];
  if (shape_of_[object] != kNoShape) {
    embree_.add_instance(shape_of_[object], pose.objects[object].placement);
    embree_.set_present(object, pose.objects[object].present);
    return;
  }
  std::vector<vec3> at = mesh.positions;
  place(pose.objects[object].placement, at);
  embree_.add_mesh(at, mesh.triangles, still ? EmbreeMotion::still : EmbreeMotion::deforms);
  embree_.set_present(object, pose.objects[object].present);
  if (still) return;
  deforming_.push_back(object);
  const uint32_t count = vertex_count(motions_[object]);
  for (uint32_t first = 0; first < count; first += kChunk) {
    chunks_.push_back({object, first, std::min(kChunk, count - first)});
  }
}

void EmbreeWorld::deform(const ScenePose& pose) {
  for (const uint32_t object : deforming_) {
    if (pose.objects[object].present) vertices_[object] = embree_.vertices(object);
  }
  parallel_for(chunks_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      const auto [object, first, count] = chunks_[c];
      const Pose& p = pose.objects[object];
      if (!p.present) continue;
      const std::span<vec3> out = vertices_[object].subspan(first, count);
      positions(motions_[object], p, first, out);
      place(p.placement, out);
    }
  });
}

void EmbreeWorld::update(const ScenePose& pose) {
  for (uint32_t i = 0; i < meshes_.size(); ++i) {
    embree_.set_present(i, pose.objects[i].present);
    if (shape_of_[i] != kNoShape) embree_.place(i, pose.objects[i].placement);
  }
  deform(pose);
  embree_.commit();
}

}  // namespace sinew::bench
