// All hits along a ray: a closest-hit query whose filter writes down every hit and takes none.
#include <algorithm>
#include <tuple>

#include "sinew/bvh/trace/traverse.h"

namespace sinew {
namespace {

struct Collector {
  const QueryOptions& options;
  std::vector<Hit>& hits;
  const SceneView& scene;
};

bool is_filtered(const SceneView& scene, uint32_t object) {
  const auto end = scene.instances + scene.instance_count;
  return std::any_of(scene.instances, end, [&](const Instance& instance) {
    return instance.object == object && instance.filtered;
  });
}

bool collect(const void* context, uint32_t ray, const Hit& hit) {
  const auto& to = *static_cast<const Collector*>(context);
  const HitFilter& filter = to.options.filter;
  const bool asked =
      filter.accept != nullptr && (filter.of_all || is_filtered(to.scene, hit.object));
  if (!asked || filter.accept(filter.context, ray, hit)) to.hits.push_back(hit);
  return false;
}

}  // namespace

void all_hits(const SceneView& scene, const Ray& ray, std::vector<Hit>& out,
              const QueryOptions& options) {
  out.clear();
  const Collector collector{options, out, scene};
  QueryOptions all = options;
  all.filter = {collect, &collector, true};
  Hit none;
  closest_hits(scene, {&ray, 1}, {&none, 1}, all);
  std::sort(out.begin(), out.end(), [](const Hit& a, const Hit& b) {
    return std::tie(a.t, a.object, a.primitive) < std::tie(b.t, b.object, b.primitive);
  });
}

}  // namespace sinew
