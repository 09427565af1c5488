// Which hits count: filters for World queries. They let rays through masked-out texels, dim and
// tint shadow rays in blended and transmissive surfaces (which pass them unbent: there are no
// caustics), and give single-sided surfaces no back: those exist only for a camera
// or a light that looks at their front, as a rasteriser's back-face culling has it. (Of objects
// that are single-sided as a whole the query's Facing does that by itself.) The product of
// transmittances does not depend on the order in which a hierarchy meets the surfaces: logarithms
// are summed in fixed point.
#pragma once

#include <cstdint>

#include "sinew/bvh/trace/traverse.h"
#include "sinew/math/ray.h"
#include "sinew/render/texture.h"
#include "sinew/scene/scene.h"
#include "sinew/world/world.h"

namespace sinew {

// `rays` and `optical_depth` are indexed by what the query tells its filter (first_ray + i).
struct FilterContext {
  const World* world = nullptr;
  const Scene* scene = nullptr;
  const Ray* rays = nullptr;
  uvec3* optical_depth = nullptr;  // shadow filter: R, G, B of each ray, zero before the query
  const TextureTable* textures = nullptr;  // shadow filter
};

// Whether any hit in this scene needs a filter.
bool needs_filter(const Scene& scene);

// For closest hits: rejects holes of masks, fully transparent texels of blends, and back sides.
HitFilter visible_filter(const FilterContext& context);

// For rays towards light, any hit: rejects holes of masks, and front sides of single-sided surfaces
// (the light is behind them); what lets light through adds to the ray's optical depth and stops the
// ray when less than a thousandth of the light is left.
HitFilter shadow_filter(const FilterContext& context);

// The share of light that the summed depth leaves.
vec3 transmittance(uvec3 optical_depth);

}  // namespace sinew
