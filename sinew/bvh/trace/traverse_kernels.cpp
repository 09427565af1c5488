// Queries that trace every ray for itself.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sinew/bvh/trace/traverse_kernels.cpp"
// clang-format off
#include "sinew/base/simd.h"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>
// clang-format on

#include "sinew/base/check.h"
#include "sinew/bvh/trace/query_kernels.h"
#include "sinew/bvh/trace/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sinew {
namespace HWY_NAMESPACE {

template <class Setup>
void closest_hits_of(const SceneView& scene, const Ray* rays, Hit* hits, size_t count,
                     const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    const uint32_t index = options.first_ray + static_cast<uint32_t>(i);
    hits[i] = Traversal<false, Setup>(scene, options, rays[i], index).run();
  }
}

template <class Setup>
void any_hits_of(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                 const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    const uint32_t index = options.first_ray + static_cast<uint32_t>(i);
    hit[i] = static_cast<bool>(Traversal<true, Setup>(scene, options, rays[i], index).run());
  }
}

void closest_hits_kernel(const SceneView& scene, const Ray* rays, Hit* hits, size_t count,
                         const QueryOptions& options) {
  const bool fast = options.precision == Precision::fast;
  const auto trace = fast ? closest_hits_of<FastSetup> : closest_hits_of<RaySetup>;
  trace(scene, rays, hits, count, options);
}

void any_hits_kernel(const SceneView& scene, const Ray* rays, uint8_t* hit, size_t count,
                     const QueryOptions& options) {
  const bool fast = options.precision == Precision::fast;
  const auto trace = fast ? any_hits_of<FastSetup> : any_hits_of<RaySetup>;
  trace(scene, rays, hit, count, options);
}

void count_closest_hits_kernel(const SceneView& scene, const Ray* rays, Hit* hits,
                               TraversalCounts* counts, size_t count, const QueryOptions& options) {
  for (size_t i = 0; i < count; ++i) {
    counts[i] = {};
    const uint32_t index = options.first_ray + static_cast<uint32_t>(i);
    hits[i] = Traversal<false, RaySetup, CountSteps>(scene, options, rays[i], index,
                                                     CountSteps{counts[i]})
                  .run();
  }
}

const char* target_name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace sinew
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sinew {

HWY_EXPORT(closest_hits_kernel);
HWY_EXPORT(count_closest_hits_kernel);
HWY_EXPORT(any_hits_kernel);
HWY_EXPORT(target_name);

void closest_hits_alone(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                        const QueryOptions& options) {
  HWY_DYNAMIC_DISPATCH(closest_hits_kernel)
  (scene, rays.data(), hits.data(), rays.size(), options);
}

void count_closest_hits(const SceneView& scene, std::span<const Ray> rays, std::span<Hit> hits,
                        std::span<TraversalCounts> counts, const QueryOptions& options) {
  SINEW_CHECK(rays.size() == hits.size() && rays.size() == counts.size());
  HWY_DYNAMIC_DISPATCH(count_closest_hits_kernel)
  (scene, rays.data(), hits.data(), counts.data(), rays.size(), options);
}

void any_hits_alone(const SceneView& scene, std::span<const Ray> rays, std::span<uint8_t> hit,
                    const QueryOptions& options) {
  HWY_DYNAMIC_DISPATCH(any_hits_kernel)(scene, rays.data(), hit.data(), rays.size(), options);
}

const char* kernel_target() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace sinew
#endif
