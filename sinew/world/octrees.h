// Parts of World that deal with voxel objects. Internal to sinew/world.
#pragma once

#include <string>

#include "sinew/world/world_impl.h"

namespace sinew {

// Whether the pose has as many joints and morph weights as the octree needs.
bool counts_fit(const Svo& svo, const Pose& pose);

// Of all that shapes the octree, but not of its placement. The counts must fit.
uint64_t pose_hash(const Svo& svo, const Pose& pose);

// Adds what has been made of the octrees that the frame shows.
void count_octrees(const WorldFrame& frame, UpdateStats& stats);

// Empty text if the object's octree is as it must be, else what is wrong.
std::string validate_octree(const WorldFrame& frame, ObjectId id);

}  // namespace sinew
