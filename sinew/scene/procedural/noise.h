// Noise and textures for study scenes; every value is a pure function of its arguments.
// Based on: K. Perlin, "Improving Noise", SIGGRAPH 2002; S. Worley, "A Cellular Texture Basis
// Function", SIGGRAPH 1996. Lattice values come from our own integer hash.
#pragma once

#include <cstdint>
#include <functional>

#include "sinew/math/vec.h"
#include "sinew/scene/image.h"

namespace sinew {

// Gradient noise, about [-1, 1], zero at the integer points.
float gradient_noise(vec3 p, uint32_t seed);

// Sum of `octaves` noises, each of twice the frequency and half the height; about [-1, 1].
float fractal_noise(vec3 p, uint32_t octaves, uint32_t seed);

// Distances to the nearest two of the points scattered one in every unit cell.
struct Cells {
  float nearest = 0.0f;
  float second = 0.0f;
  vec3 to_nearest{0.0f};  // from p to the point
  vec3 to_second{0.0f};
  uint32_t id = 0;  // of the nearest point
};
// `jitter` in [0, 1]: how far points stray from the centres of their cells.
Cells cellular_noise(vec3 p, float jitter, uint32_t seed);

// Linear colour to sRGB bytes.
void store_srgb(vec3 linear, uint8_t* rgba);

// An image whose pixel at (u, v), both in (0, 1), v downwards, has the linear colour color(u, v).
// Calls run in parallel.
Image8 paint_image(uint32_t width, uint32_t height,
                   const std::function<vec3(float u, float v)>& color);

}  // namespace sinew
