// Alpha in ray queries: filters for World queries that let rays through masked-out texels and
// attenuate shadow rays in blended surfaces. The product of transmittances does not depend on the
// order in which a hierarchy meets the surfaces: logarithms are summed in fixed point.
#pragma once

#include <cstdint>

#include "sinew/bvh/traverse.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct AlphaContext {
  const Scene* scene = nullptr;
  uint32_t* optical_depth = nullptr;  // shadow filter: one a ray, zero before the query
};

// For closest hits: rejects holes of masks and fully transparent texels of blends.
HitFilter visible_filter(const AlphaContext& context);

// For any hits: rejects holes of masks; a blend adds to the ray's optical depth and stops the ray
// when less than a thousandth of the light is left.
HitFilter shadow_filter(const AlphaContext& context);

// The share of light that the summed depth leaves.
float transmittance(uint32_t optical_depth);

}  // namespace sinew
