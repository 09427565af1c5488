// What things of a scene are called in texts and files.
#pragma once

#include "sinew/scene/scene.h"

namespace sinew {

// As KHR_lights_punctual has it.
inline const char* name_of(LightType type) {
  switch (type) {
    case LightType::directional:
      return "directional";
    case LightType::point:
      return "point";
    case LightType::spot:
      return "spot";
  }
  return "point";
}

}  // namespace sinew
