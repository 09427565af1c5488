#include "app/draw_mode.h"

#include <algorithm>

#include "app/hide.h"
#include "sinew/render/voxelize_scene.h"

namespace sinew::app {
namespace {

tl::unexpected<Error> usage(const Scene& scene, std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, scene.name, "", std::move(problem), std::move(remedy)});
}

// Leaves octrees out of the scene.
Result<void> keep_triangles(Scene& scene) {
  if (scene.voxels.empty()) return {};
  if (scene.objects.empty()) {
    return usage(scene, "--mode triangles: the scene has only voxels", "use --mode voxels");
  }
  for (const SceneVoxels& object : scene.voxels) {
    Node& node = scene.nodes[object.node];
    node.octree = node.skin = -1;
    node.weights.clear();
  }
  for (Clip& clip : scene.clips) {
    std::erase_if(clip.channels, [&](const Channel& channel) {
      return channel.path == ChannelPath::weights && scene.nodes[channel.node].mesh < 0;
    });
  }
  list_objects(scene);
  return {};
}

// Makes octrees of the chosen objects; empty: of all.
Result<void> voxelize(const DrawModeChoice& choice, std::vector<uint8_t> chosen,
                      uint64_t memory_limit, Scene& scene) {
  VoxelizeSceneOptions options;
  options.resolution = choice.resolution;
  options.chosen = std::move(chosen);
  options.memory_limit = memory_limit;
  SINEW_TRY(VoxelizedScene made, voxelize_scene(scene, options));
  scene = std::move(made.scene);
  return {};
}

Result<void> mix(const DrawModeChoice& choice, uint64_t memory_limit, Scene& scene) {
  if (choice.voxelize.empty()) {
    if (!scene.voxels.empty()) return {};
    return usage(scene, "--mode mixed: the scene has no voxels",
                 "say with --voxelize PATTERN which objects become voxels");
  }
  SINEW_TRY(const std::vector<uint8_t> nodes, find_objects(scene, choice.voxelize, "--voxelize"));
  std::vector<uint8_t> chosen;
  for (const SceneObject& object : scene.objects) chosen.push_back(nodes[object.node]);
  // What the patterns found may be octrees already.
  if (std::find(chosen.begin(), chosen.end(), 1) == chosen.end()) return {};
  return voxelize(choice, std::move(chosen), memory_limit, scene);
}

}  // namespace

Result<DrawMode> parse_mode(const std::string& word) {
  if (word.empty() || word == "auto") return DrawMode::automatic;
  if (word == "triangles") return DrawMode::triangles;
  if (word == "voxels") return DrawMode::voxels;
  if (word == "mixed") return DrawMode::mixed;
  return fail({ErrorKind::usage, "", "", "--mode '" + word + "' is unknown",
               "use auto, triangles, voxels or mixed"});
}

Result<void> apply_mode(const DrawModeChoice& choice, uint64_t memory_limit, Scene& scene) {
  switch (choice.mode) {
    case DrawMode::automatic:
      return {};
    case DrawMode::triangles:
      return keep_triangles(scene);
    case DrawMode::voxels:
      if (scene.objects.empty()) return {};
      return voxelize(choice, {}, memory_limit, scene);
    case DrawMode::mixed:
      return mix(choice, memory_limit, scene);
  }
  return {};
}

}  // namespace sinew::app
