// What is asked of a colour as a whole.
#pragma once

#include <algorithm>

#include "sinew/math/vec.h"

namespace sinew {

// The brightest channel.
inline float largest(vec3 color) {
  return std::max({color.x, color.y, color.z});
}

}  // namespace sinew
