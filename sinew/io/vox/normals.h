// Normals of voxels that know no triangles.
#pragma once

#include <vector>

#include "sinew/math/vec.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew::vox {

// Sets the normal of each voxel to the direction in which the voxels around it, two away at most,
// are fewest. `voxels` are sorted and lie within the resolution, at most 256 a side.
void set_normals(uvec3 resolution, std::vector<PlainVoxel>& voxels);

}  // namespace sinew::vox
