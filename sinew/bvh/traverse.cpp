#include "sinew/bvh/traverse.h"

#include "sinew/base/check.h"
#include "sinew/bvh/query_kernels.h"

namespace sinew {
namespace {

// Shorter spans hold few rays of a kind.
constexpr size_t kLeastSpan = 32;

bool is_grouped(size_t rays, const QueryOptions& options) {
  return options.grouping == Grouping::automatic && rays >= kLeastSpan;
}

}  // namespace

void closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                  const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hits.size());
  const auto trace = is_grouped(rays.size(), options) ? closest_hits_grouped : closest_hits_alone;
  trace(scene, rays, hits, options);
}

void any_hits(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
              const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hit.size());
  const auto trace = is_grouped(rays.size(), options) ? any_hits_grouped : any_hits_alone;
  trace(scene, rays, hit, options);
}

}  // namespace sinew
