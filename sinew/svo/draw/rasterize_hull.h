// The outline of a voxel on the screen, and the depths of its faces: for voxels of many pixels.
#pragma once

#include "sinew/svo/draw/rasterize_view.h"

namespace sinew {

// Convex, its corners in a cycle.
struct Outline {
  static constexpr uint32_t kMost = 4 * SeenPoints::kMost;  // each may be a box
  uint32_t count = 0;
  double x[kMost], y[kMost];
  double pad = 0.0;  // pixels: rounding of points within
};

// Of what of the hull of the corners lies beyond the near plane, as project_hull().
Outline outline_of(const ClipPoint corners[8], float near, bool perspective, const float reach[3]);

// Columns whose pixel centres may lie within the outline, for rows [first, first + count): from
// low[i] to high[i]. None: low > high.
void rows_of(const Outline& outline, int first, int count, int16_t* low, int16_t* high);

// A voxel as the parallelepiped that it is to first order in its middle. The ray through the pixel
// (x, y) enters it, through the last of three faces, at depth
//   max_i (o_i - sign(n_i)) / n_i   with n_i = n[i] . (x, y, 1) and o_i = o[i] . (x, y, 1),
// kept between the least and the greatest depth of the voxel's corners.
struct FaceDepths {
  float n[3][3] = {}, o[3][3] = {};
  float low = 0.0f, high = 0.0f;
};
FaceDepths face_depths(const ClipPoint corners[8], float near, bool perspective);

}  // namespace sinew
