// What the creature wears: horns, plates along its back, claws, and eyes. All are closed shapes,
// skinned to the same joints as the body.
#pragma once

#include "sinew/scene/mesh.h"
#include "sinew/scene/procedural/creature_body.h"

namespace sinew {

// Horns and claws (material `horn`) and plates (material `plate`), with vertex colours.
// `triangles`: about how many in all.
Mesh make_creature_armour(const CreatureBody& body, uint32_t triangles, uint32_t horn,
                          uint32_t plate);

// Two balls whose texture coordinates look at them from the front.
Mesh make_creature_eyes(uint32_t triangles, uint32_t material);

}  // namespace sinew
