// How many points of one triangle look: normals and colours of voxels. Internal to voxel_looks.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sinew/scene/image.h"
#include "sinew/scene/material.h"

namespace sinew {

// A value at the first vertex, and by how much it grows to the second and the third.
template <class T>
struct Linear {
  T first{0.0f}, to_second{0.0f}, to_third{0.0f};
};

// A texture on the triangle: the level whose texels are about as large as voxels.
struct LookTexture {
  const Image8* image = nullptr;  // null: white
  Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
  bool nearest = false;
  Linear<vec2> uv;  // transformed
};

// All that a triangle's points share.
struct LookTriangle {
  Linear<vec4> base;  // base colour factor times vertex colour
  LookTexture base_texture;
  float least_alpha = -1.0f;  // what is below it is left out

  vec3 face{0.0f};      // unit normal
  bool smooth = false;  // else the face's normal
  Linear<vec3> normal;
  LookTexture normal_texture;
  float normal_scale = 1.0f;
  bool has_tangents = false;
  Linear<vec4> tangent;             // if it has them
  vec3 side_u{0.0f}, side_v{0.0f};  // else: along growing u, and up in the image
};

// Points with weights (u, v) for the second and the third vertex; `present` is set to 0 where
// nothing is seen.
struct LookPoints {
  const float* u = nullptr;
  const float* v = nullptr;
  size_t count = 0;
  uint16_t* normals = nullptr;
  uint16_t* colors = nullptr;
  uint8_t* present = nullptr;
};
void look_at_points(const LookTriangle& triangle, const LookPoints& points);

}  // namespace sinew
