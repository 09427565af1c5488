// `--mode`: what of a scene is drawn as triangles, and what as voxels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew::app {

enum class DrawMode : uint8_t {
  automatic,  // whatever the scene has
  triangles,  // octrees are left out
  voxels,     // meshes become octrees
  mixed,      // those that are asked for do
};

struct DrawModeChoice {
  DrawMode mode = DrawMode::automatic;
  std::vector<std::string> voxelize;  // mixed: patterns of object names
  uint32_t resolution = 512;          // voxels along the longest side of what is voxelised
};

// "auto", "triangles", "voxels", "mixed"; empty: auto.
Result<DrawMode> parse_mode(const std::string& word);

// Makes the scene what the mode draws. Meshes are voxelised within the memory limit (bytes).
// Errors: usage if nothing would be left, or no object has such a name; what voxelising says.
Result<void> apply_mode(const DrawModeChoice& choice, uint64_t memory_limit, Scene& scene);

}  // namespace sinew::app
