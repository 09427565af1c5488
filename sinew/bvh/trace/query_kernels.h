// The kernels behind closest_hits() and any_hits() of traverse.h. Sizes agree.
#pragma once

#include <span>

#include "sinew/bvh/trace/traverse.h"

namespace sinew {

// Each ray for itself.
void closest_hits_alone(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                        const QueryOptions& options);
void any_hits_alone(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
                    const QueryOptions& options);

// Rays with like directions together.
void closest_hits_grouped(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                          const QueryOptions& options);
void any_hits_grouped(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
                      const QueryOptions& options);

}  // namespace sinew
