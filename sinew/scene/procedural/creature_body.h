// The creature's flesh, and what is cut out of it.
#pragma once

#include "sinew/scene/procedural/flesh.h"

namespace sinew {

class CreatureBody {
 public:
  CreatureBody();

  const Box& box() const { return flesh_.box(); }  // contains the surface
  float field(vec3 p) const;                       // negative inside, nearly a distance outside
  SkinWeights skin_weights(vec3 p) const { return flesh_.skin_weights(p); }

  // The point of the surface that a ray from inside the body leaves by.
  vec3 leave(vec3 inside, vec3 direction) const;

 private:
  FleshBody flesh_;
};

}  // namespace sinew
