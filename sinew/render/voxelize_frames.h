// Voxels of a scene as it is seen at some times: for programs whose voxels have no skeletons.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/render/voxelize_scene.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew {

// One object, in the world. All frames have the same grid.
struct VoxelFrames {
  std::string name;
  uint64_t triangles = 0;
  VoxelGrid grid;
  std::vector<std::vector<PlainVoxel>> frames;  // sorted, each place once
};

// One entry a chosen object; voxels are of one size, and the resolution counts along the longest
// side of the box of all objects at all times. `clip` is an index or kRestPose; there is at least
// one time. Normals are those at rest. Where triangles share a voxel, the first is seen. Ignores
// `each` and `on_octree`. Errors as voxelize_scene().
Result<std::vector<VoxelFrames>> voxelize_frames(const Scene& scene, int clip,
                                                 std::span<const double> times,
                                                 const VoxelizeSceneOptions& options);

}  // namespace sinew
