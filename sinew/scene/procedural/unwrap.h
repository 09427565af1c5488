// Texture coordinates for any closed surface, and textures painted in space.
// A chart is a connected set of triangles that face the same side of a cube; it is flattened by
// dropping that axis, and charts are packed into the unit square in rows. Nothing overlaps and
// distortion is bounded by the angle to the axis. What is painted is a function of the point in
// space, so the many seams do not show.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sinew/math/vec.h"
#include "sinew/scene/image.h"

namespace sinew {

struct Unwrapping {
  std::vector<uvec3> corners;      // one a triangle, indices into the two below
  std::vector<vec2> texcoords;     // v downwards, as glTF has it
  std::vector<uint32_t> vertices;  // the vertex that each entry belongs to
};

// `resolution`: of the texture to come, in texels; charts keep a few texels apart.
Unwrapping unwrap(std::span<const vec3> positions, std::span<const vec3> normals,
                  std::span<const uvec3> triangles, uint32_t resolution);

// A texel's place on the surface.
struct SurfacePoint {
  uint32_t triangle = 0;
  vec3 barycentric{0.0f};  // weights of the triangle's corners
  vec3 tangent{0.0f};      // unit, along +u
  vec3 bitangent{0.0f};    // unit, along -v: "up" in the texture
};

// What a texel gets: linear colour, and the bumpy normal in the space of tangent, bitangent and
// smooth normal.
struct Paint {
  vec3 color{0.0f};
  vec3 normal{0.0f, 0.0f, 1.0f};
};

struct PaintedTextures {
  Image8 color;   // sRGB
  Image8 normal;  // linear
};

// Calls `paint` once for every texel that a triangle covers, in parallel, and lets the colours run
// over the edges of the charts.
PaintedTextures paint_surface(const Unwrapping& unwrapping, std::span<const vec3> positions,
                              std::span<const uvec3> triangles, uint32_t resolution,
                              const std::function<Paint(const SurfacePoint&)>& paint);

}  // namespace sinew
