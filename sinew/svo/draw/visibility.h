// Which voxel is in front in every pixel: what the rasteriser writes, and shading reads.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/affine.h"
#include "sinew/svo/format.h"
#include "sinew/svo/posed.h"

namespace sinew {

// A view as four linear functions of a point (p, 1) in the world: it is seen at the pixel
// (dot(x, p) / dot(w, p), dot(y, p) / dot(w, p)), y down, pixel centres at .5, if its depth is
// above `near`. Perspective: w = depth. Orthographic: w = 1.
struct RasterView {
  vec4 x{0.0f}, y{0.0f}, w{0.0f}, depth{0.0f};
  float near = 0.0f;  // > 0
  uint32_t width = 0, height = 0;
};

// An octree in the picture. *Units* are what a key can name: the instance's cells, then its nodes.
struct VoxelInstance {
  PosedSvo* posed = nullptr;
  Affine placement = identity_affine();  // object -> world
  uint32_t first_unit = 0;               // units of the instances before it
};
inline uint32_t unit_count(const Svo& svo) {
  return static_cast<uint32_t>(svo.cells.size() + svo.nodes.size());
}

// What wins a pixel: the least depth, at full precision (a key's is cut off); of equal depths the
// first in the order of instances, blocks, cells and codes. So the picture depends on no order of
// drawing, and keys of different pictures may be compared.
//
//   63        37 36        10 9      0
//   [ depth 27  | unit 27    | code 10 ]      code: a VoxelCode, or 0 for a node
//
// 27 bits of units are 134 million: 1,000 bodies of 3 million voxels have 110 million.
using VisibilityKey = uint64_t;
inline constexpr VisibilityKey kNothing = ~VisibilityKey{0};
inline constexpr uint32_t kMostUnits = 1u << 27;

// `depth` > 0: its upper 19 bits of mantissa count.
inline VisibilityKey make_key(float depth, uint32_t unit, VoxelCode code) {
  return VisibilityKey{std::bit_cast<uint32_t>(depth) >> 4} << 37 | VisibilityKey{unit} << 10 |
         code;
}
inline float key_depth(VisibilityKey key) {
  return std::bit_cast<float>(static_cast<uint32_t>(key >> 37) << 4);
}
inline uint32_t key_unit(VisibilityKey key) {
  return static_cast<uint32_t>(key >> 10) & (kMostUnits - 1);
}
inline VoxelCode key_code(VisibilityKey key) {
  return static_cast<VoxelCode>(key & 1023);
}
// What names the voxel: unit and code.
inline uint64_t key_name(VisibilityKey key) {
  return key & ((uint64_t{1} << 37) - 1);
}

struct Visibility {
  uint32_t width = 0, height = 0;
  std::vector<VisibilityKey> keys;  // rows from top to bottom
};

// Depth alone, for shadow maps: infinite where nothing is.
struct DepthMap {
  uint32_t width = 0, height = 0;
  std::vector<float> depth;
};

// The surface that a key names, for one pixel: the slow obvious way, and the one for rays.
struct VoxelSample {
  uint32_t instance = 0;
  uint32_t unit = 0;  // within the instance
  VoxelCode code = 0;
  uint32_t level = 0;      // 0: a voxel
  uint32_t material = 0;   // of a node: of its first cell
  vec3 position{0.0f};     // world: the middle of the drawn voxel
  float size = 0.0f;       // world: side of the voxel at rest times the scale of the placement
  vec3 normal{0.0f};       // world, unit, outside of the surface
  vec3 color{0.0f};        // linear
  float spread = 1.0f;     // length of the mean normal
  float clearance = 0.0f;  // world: how far from `position`, along the normal, a ray must start to
                           // be clear of the boxes of this voxel and its neighbours on a plane
};
VoxelSample sample_voxel(std::span<const VoxelInstance> instances, VisibilityKey key);
// The same of what a ray has met: Hit::primitive is cell << 10 | code.
VoxelSample sample_voxel_hit(const VoxelInstance& instance, uint32_t primitive);

}  // namespace sinew
