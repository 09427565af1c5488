// Repairs the directions that files give at vertices, so that all have unit length.
#pragma once

#include <cstdint>

#include "sinew/scene/mesh.h"

namespace sinew::gltf {

// Normalises mesh.normals; those without length become the mean of the normals of the triangles
// around, weighted by area. Returns how many had no length.
uint64_t repair_normals(Mesh& mesh);

// Normalises mesh.tangents and sets w to +1 or -1; those without length become some direction
// across the normal. Call after repair_normals.
void repair_tangents(Mesh& mesh);

}  // namespace sinew::gltf
