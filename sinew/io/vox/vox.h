// MagicaVoxel's .vox files, versions 150 and 200. Based on: ephtracy, "MagicaVoxel .vox File
// Format" and its extension for scene graphs, materials and animation
// (github.com/ephtracy/voxel-model).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {

inline constexpr double kVoxFps = 30.0;     // .vox frames have numbers, no times
inline constexpr float kVoxSide = 0.1f;     // metres: what a voxel of a file becomes
inline constexpr uint32_t kVoxModel = 256;  // the longest side of a model, voxels
inline constexpr uint32_t kVoxColors = 255;

// One octree a model, one node a transform, group and shape, one material for each set of surface
// properties in use; frames become a clip. +Z up becomes +Y up.
Result<Scene> load_vox(const std::string& path, const LoadOptions& options = {});

// The same from the bytes of the file; `path` stands in errors.
Result<Scene> parse_vox(std::span<const uint8_t> bytes, const std::string& path,
                        const LoadOptions& options);

// What becomes one object of a .vox file.
struct VoxObject {
  std::string name;
  VoxelGrid grid;  // all objects of a file have voxels of one size
  // One frame, or as many as the other objects that have more than one. Sorted, each place once.
  std::vector<std::vector<PlainVoxel>> frames;
};

struct SavedVox {
  std::string path;
  uint64_t bytes = 0;
  uint64_t voxels = 0;  // over all frames
  uint32_t models = 0;  // after cutting into pieces of at most 256^3
  uint32_t frames = 0;  // 1: nothing moves
  uint32_t colors = 0;  // in the palette
  std::vector<std::string> warnings;
};

// `materials` are what PlainVoxel::material indexes. Voxels keep their places to each other: grids
// are placed by whole voxels. The file appears whole or not at all; "-" is standard output.
Result<SavedVox> save_vox(std::span<const VoxObject> objects, std::span<const Material> materials,
                          const std::string& path);

// Whether save_vox can write `path`: to be asked before long work.
Result<void> check_save_vox(const std::string& path);

// The voxels of an octree at rest, sorted: of copies of one place, the first.
std::vector<PlainVoxel> plain_voxels(const Svo& svo);

// The voxel objects that the scene shows at rest, one frame each. What that leaves out goes to
// `warnings`.
std::vector<VoxObject> vox_objects(const Scene& scene, std::vector<std::string>& warnings);

}  // namespace sinew
