// The creature's skin: colours and scales as functions of the point on the resting body.
#pragma once

#include <vector>

#include "sinew/scene/procedural/creature_body.h"
#include "sinew/scene/procedural/implicit_mesh.h"
#include "sinew/scene/procedural/unwrap.h"

namespace sinew {

// What the paint needs to know about each vertex; interpolated in between.
struct SkinRegion {
  float belly = 0.0f;  // 1 on the underside of trunk, neck, jaw and tail
  float back = 0.0f;   // 1 on top
  float leg = 0.0f;    // 1 on legs
  float hand = 0.0f;   // 1 on feet and toes
};
std::vector<SkinRegion> skin_regions(const ImplicitMesh& body,
                                     const std::vector<SkinWeights>& weights);

PaintedTextures paint_skin(const ImplicitMesh& body, const std::vector<SkinRegion>& regions,
                           const Unwrapping& unwrapping, uint32_t resolution);

// The eye seen from the front, its middle at (0.5, 0.5).
Image8 paint_eye(uint32_t resolution);

}  // namespace sinew
