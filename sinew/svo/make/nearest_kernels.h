// Where on a triangle the points nearest to voxels are. Internal to the voxeliser.
#pragma once

#include <cstddef>

#include "sinew/svo/make/voxelize_triangle.h"

namespace sinew {

// A triangle for nearest_points(), in voxels. Edges go from its first vertex.
struct NearestSetup {
  vec3 offset;  // from the first vertex to the centre of the block's first voxel
  vec3 edge1, edge2;
  vec3 dual1, dual2;  // dot with a vector from the first vertex: weights of the other two
  float dot11 = 0.0f, dot12 = 0.0f, dot22 = 0.0f;              // of the edges
  float inverse11 = 0.0f, inverse22 = 0.0f, inverse33 = 0.0f;  // 1 / squared length of edge 1, 2,
                                                               // and from 1 to 2; 0 if that is 0
};
NearestSetup make_nearest_setup(const GridTriangle& triangle);

// Weights u, v of the second and third vertex at the triangle's point nearest to each voxel's
// centre: not negative, u + v at most 1, up to rounding.
void nearest_points(const NearestSetup& setup, const BlockPlace* places, size_t count, float* u,
                    float* v);

}  // namespace sinew
