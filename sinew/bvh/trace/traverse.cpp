#include "sinew/bvh/trace/traverse.h"

#include <algorithm>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/bvh/trace/query_kernels.h"

namespace sinew {
namespace {

// Shorter spans hold few rays of a kind.
constexpr size_t kLeastSpan = 32;

// Rays that begin all over the scene have nothing in common but their directions.
constexpr float kFar = 1.0f / 16.0f;  // of the scene's size, from one ray's origin to the next
constexpr size_t kSampledRays = 32;

// The largest side of all there is, or infinity where that is not known yet.
float size_of(const SceneView& scene) {
  Box box;
  if (scene.top != nullptr) {
    box = node_box(scene.top[0]);
  } else if (scene.instance_count > 0 && scene.instances[0].in_place &&
             scene.instances[0].body == nullptr && is_inner_word(scene.instances[0].root)) {
    box = node_box(scene.instances[0].nodes[scene.instances[0].root]);
  }
  if (box.empty()) return std::numeric_limits<float>::infinity();
  const vec3 extent = box.extent();
  return std::max({extent.x, extent.y, extent.z});
}

bool begin_far_apart(const SceneView& scene, std::span<const Ray> rays) {
  const size_t step = std::max<size_t>(rays.size() / kSampledRays, 1);
  float sum = 0.0f;
  size_t count = 0;
  for (size_t i = 0; i + 1 < rays.size(); i += step, ++count) {
    const vec3 away = glm::abs(rays[i + 1].origin - rays[i].origin);
    sum += std::max({away.x, away.y, away.z});
  }
  return sum > kFar * size_of(scene) * static_cast<float>(count);
}

bool is_grouped(const SceneView& scene, std::span<const Ray> rays, const QueryOptions& options) {
  return options.grouping == Grouping::automatic && rays.size() >= kLeastSpan &&
         !begin_far_apart(scene, rays);
}

}  // namespace

void closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                  const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hits.size());
  const auto trace = is_grouped(scene, rays, options) ? closest_hits_grouped : closest_hits_alone;
  trace(scene, rays, hits, options);
}

void any_hits(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
              const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hit.size());
  const auto trace = is_grouped(scene, rays, options) ? any_hits_grouped : any_hits_alone;
  trace(scene, rays, hit, options);
}

}  // namespace sinew
