// OpenVDB's meshToVolume, as an opponent of voxelising: there if the library was when sinew was
// built.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/math/vec.h"

namespace sinew::bench {

#ifdef SINEW_OPENVDB
inline constexpr bool kHasOpenVdb = true;
#else
inline constexpr bool kHasOpenVdb = false;
#endif

// Makes the voxels within one voxel of a mesh's surface, with their distances to it (unsigned, as
// surfaces may be open), on all threads that this one may use; the volume is let go. Returns how
// many voxels there were; nothing where OpenVDB is not.
std::optional<uint64_t> mesh_to_volume(std::span<const vec3> positions,
                                       std::span<const uvec3> triangles, float voxel);

}  // namespace sinew::bench
