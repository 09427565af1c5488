// The vector types of the library are glm's; this header makes sure they have the layout that the
// kernels and files rely on, whatever GLM_FORCE_ macros a user sets.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace sinew {

using glm::mat3;
using glm::mat4;
using glm::quat;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

static_assert(sizeof(vec2) == 8 && sizeof(vec3) == 12 && sizeof(vec4) == 16);
static_assert(sizeof(uvec3) == 12 && sizeof(mat3) == 36 && sizeof(mat4) == 64);
static_assert(sizeof(quat) == 16);

}  // namespace sinew
