// Counts and lists what a scene holds.
#include "sinew/scene/scene.h"

namespace sinew {

SceneCounts count(const Scene& scene) {
  SceneCounts counts;
  for (const SceneObject& object : scene.objects) {
    counts.triangles += scene.meshes[object.mesh].triangles.size();
    counts.vertices += scene.meshes[object.mesh].positions.size();
  }
  for (const Skin& skin : scene.skins) counts.joints += static_cast<uint32_t>(skin.joints.size());
  for (const Mesh& mesh : scene.meshes) counts.morphs += mesh.morph_targets;
  for (const Svo& octree : scene.octrees) counts.morphs += octree.morph_targets;
  for (const SceneVoxels& object : scene.voxels) {
    counts.voxels += scene.octrees[object.octree].voxel_count();
  }
  return counts;
}

void list_objects(Scene& scene) {
  scene.objects.clear();
  scene.voxels.clear();
  for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.octree >= 0) {
      const bool skinned = node.skin >= 0 && scene.octrees[node.octree].joints > 0;
      scene.voxels.push_back({i, static_cast<uint32_t>(node.octree), skinned ? node.skin : -1});
    }
    if (node.mesh < 0) continue;
    const bool skinned = node.skin >= 0 && scene.meshes[node.mesh].skinnable();
    scene.objects.push_back({i, static_cast<uint32_t>(node.mesh), skinned ? node.skin : -1});
  }
}

}  // namespace sinew
