// One voxel of an octree, of any level: where it is at rest, and what moves it. For picks.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/motion/influences.h"
#include "sinew/svo/format.h"

namespace sinew {

// Of the block that holds the cell.
uint32_t block_of(const Svo& svo, uint32_t cell);

struct RestVoxel {
  uvec3 place{0};     // of its first voxel of level 0, in the grid
  uint32_t side = 1;  // in voxels of level 0
  vec3 middle{0.0f};  // at rest, in the octree's space
};
RestVoxel rest_voxel(const Svo& svo, uint32_t cell, VoxelCode code);

// The joints that move the voxel's middle, the heaviest first: the weights of its cell's corners,
// as the skin lattice mixes them. Empty if the octree has no joints.
std::vector<JointWeight> joint_weights(const Svo& svo, uint32_t cell, VoxelCode code);

}  // namespace sinew
