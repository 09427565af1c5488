// What a .vox file says, before it becomes a scene. The file's own axes: +Z up.
//
//   "VOX " | version | MAIN chunk, whose children are all others
//   chunk: id (4) | bytes of content | bytes of children | content | children
//
// SIZE and XYZI make a model; nTRN, nGRP and nSHP place models; MATL and RGBA say how the 255
// colours look. Chunks that are not known are skipped.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/math/vec.h"

namespace sinew::vox {

struct Voxel {
  uint8_t x = 0, y = 0, z = 0;
  uint8_t color = 0;  // index into the palette; 0: no voxel
};
static_assert(sizeof(Voxel) == 4);

struct Model {
  uvec3 size{0};  // 1 to 256
  std::vector<Voxel> voxels;
};

// A signed permutation of axes: row i of the matrix has `sign[i]` in column `column[i]`.
struct Rotation {
  std::array<uint8_t, 3> column{0, 1, 2};
  std::array<int8_t, 3> sign{1, 1, 1};
  mat3 matrix() const;
  bool operator==(const Rotation&) const = default;
};

struct TransformKey {
  int32_t frame = 0;
  glm::ivec3 translation{0};  // of the model's middle: half its size, rounded down
  Rotation rotation;
};
struct ModelKey {
  int32_t frame = 0;
  uint32_t model = 0;
};

enum class NodeKind : uint8_t { transform, group, shape };

struct VoxNode {
  NodeKind kind = NodeKind::group;
  std::string name;
  bool hidden = false;
  int32_t layer = -1;
  std::vector<int32_t> children;     // of a transform: one
  std::vector<TransformKey> places;  // of a transform: at least one, frames rising
  std::vector<ModelKey> models;      // of a shape: at least one, frames rising
};

struct VoxMaterial {
  float metal = 0.0f;
  float roughness = 1.0f;
  float emission = 0.0f;  // times the colour: radiance
  bool glass = false;
  bool operator==(const VoxMaterial&) const = default;
};

struct VoxFile {
  int32_t version = 0;
  std::vector<Model> models;
  std::array<std::array<uint8_t, 4>, 256> palette;  // sRGB and alpha; [0] is not used
  std::map<int32_t, VoxMaterial> materials;         // by colour
  std::map<int32_t, VoxNode> nodes;                 // by id; 0 is the root
  std::map<int32_t, bool> layer_hidden;
};

// The palette of files that have none.
std::array<std::array<uint8_t, 4>, 256> default_palette();

// Errors (bad_input) name `path`.
Result<VoxFile> parse_file(std::span<const uint8_t> bytes, const std::string& path);

}  // namespace sinew::vox
