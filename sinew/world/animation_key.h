// A number that tells animations apart: by it a cached tree knows what it was made for.
#pragma once

#include <cstdint>

#include "sinew/scene/scene.h"

namespace sinew {

// A hash (XXH3-64) of all that says where triangles are: meshes, nodes, skins, clips; of motions
// that are programs, their vertices at a few times. Not of names, materials, lights or cameras.
uint64_t animation_key(const Scene& scene);

}  // namespace sinew
