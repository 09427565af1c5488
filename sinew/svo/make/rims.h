// Rims: edges at which a surface ends or folds sharply. A thin shell leaves out voxels that the
// surface only grazes, up to half a voxel deep there, and nothing beyond the edge covers for them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

// One a triangle: 1 if one of its edges is a rim: no other triangle goes on there that turns by at
// most 75 degrees from it (vertices at equal positions are one). Triangles of no size have none,
// nor have those with vertices that are not finite.
std::vector<uint8_t> rim_triangles(std::span<const vec3> positions,
                                   std::span<const uvec3> triangles);

}  // namespace sinew
