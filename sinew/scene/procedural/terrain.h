// A wide grassy valley between hills, as a heightfield: height(x, z) in metres, +Y up. The floor of
// the valley winds along +Z.
// Based on: F. K. Musgrave et al., "The Synthesis and Rendering of Eroded Fractal Terrains", 1989
// (fractal sums whose roughness grows with height).
#pragma once

#include <cstdint>

#include "sinew/scene/mesh.h"
#include "sinew/scene/procedural/noise.h"

namespace sinew {

inline constexpr float kTerrainWidth = 320.0f;   // metres along X
inline constexpr float kTerrainLength = 400.0f;  // metres along Z; the middle is at the origin

// Where the middle of the valley's floor is at z, and how fast that changes.
float valley_middle(float z);
float valley_slope(float z);

float terrain_height(float x, float z);

// A grid of about `triangles` triangles with normals, vertex colours, and texture coordinates in
// which one repeat is `tile` metres.
Mesh make_terrain(uint32_t triangles, float tile, uint32_t material);

// Grass, for that tile: repeats in both directions, and is white on average so that it only
// modulates vertex colours.
Image8 paint_grass(uint32_t resolution);

}  // namespace sinew
