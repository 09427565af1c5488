// Ray queries of a World, cut into chunks for all threads.
#include "sinew/base/parallel.h"
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

// Few rays may make many treelets, so they are spread over more tasks.
constexpr size_t kFewRays = 256;
size_t rays_per_task(size_t count) {
  return count <= kFewRays ? 32 : count <= 4 * kFewRays ? kFewRays : 1024;
}

// Calls trace(first, count, options for them) for chunks of `count` rays.
template <class Trace>
void for_each_chunk(const WorldFrame& frame, size_t count, const QueryOptions& options,
                    const Trace& trace) {
  const UpdateGate::Query running(frame.gate);
  if (count > 1) frame.rays.fetch_add(count, std::memory_order_relaxed);
  parallel_for(count, rays_per_task(count), [&](size_t begin, size_t end) {
    QueryOptions part = options;
    part.first_ray += static_cast<uint32_t>(begin);
    trace(begin, end - begin, part);
  });
}

PickedVoxel voxel_of(const Svo& svo, uint32_t primitive) {
  PickedVoxel out;
  out.cell = primitive >> 10;
  out.code = primitive & 1023;
  out.level = level_of(out.code);
  out.material = svo.cells[out.cell].material;
  out.rest = rest_voxel(svo, out.cell, out.code);
  return out;
}

SceneView view_of(const WorldFrame& frame) {
  // A lone object needs no top tree.
  const bool lone = frame.instances.size() <= 1 && frame.leaves.empty();
  return {lone ? nullptr : frame.top.data(), frame.instances.data(),
          static_cast<uint32_t>(frame.instances.size()),
          frame.leaves.empty() ? nullptr : frame.leaves.data()};
}

}  // namespace

std::optional<Hit> World::closest_hit(const Ray& ray) const {
  Hit hit;
  closest_hits({&ray, 1}, {&hit, 1});
  if (!hit) return std::nullopt;
  return hit;
}

bool World::any_hit(const Ray& ray) const {
  uint8_t hit = 0;
  any_hits({&ray, 1}, {&hit, 1});
  return hit != 0;
}

void World::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                         const QueryOptions& options) const {
  SINEW_CHECK(rays.size() == hits.size());
  const SceneView view = view_of(impl_->now());
  for_each_chunk(impl_->now(), rays.size(), options,
                 [&](size_t first, size_t count, const QueryOptions& part) {
                   sinew::closest_hits(view, rays.subspan(first, count), hits.subspan(first, count),
                                       part);
                 });
}

void World::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit,
                     const QueryOptions& options) const {
  SINEW_CHECK(rays.size() == hit.size());
  const SceneView view = view_of(impl_->now());
  for_each_chunk(impl_->now(), rays.size(), options,
                 [&](size_t first, size_t count, const QueryOptions& part) {
                   sinew::any_hits(view, rays.subspan(first, count), hit.subspan(first, count),
                                   part);
                 });
}

void World::count_closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                               std::span<TraversalCounts> counts,
                               const QueryOptions& options) const {
  SINEW_CHECK(rays.size() == hits.size() && rays.size() == counts.size());
  const SceneView view = view_of(impl_->now());
  for_each_chunk(impl_->now(), rays.size(), options,
                 [&](size_t first, size_t count, const QueryOptions& part) {
                   sinew::count_closest_hits(view, rays.subspan(first, count),
                                             hits.subspan(first, count),
                                             counts.subspan(first, count), part);
                 });
}

void World::all_hits(const Ray& ray, std::vector<Hit>& out, const QueryOptions& options) const {
  const UpdateGate::Query running(impl_->now().gate);
  sinew::all_hits(view_of(impl_->now()), ray, out, options);
}

std::optional<Pick> World::pick(const Ray& ray, const QueryOptions& options) const {
  Pick pick;
  closest_hits({&ray, 1}, {&pick.hit, 1}, options);
  if (!pick.hit) return std::nullopt;
  const Body& body = impl_->body_of(pick.hit.object);
  pick.point = ray.origin + pick.hit.t * ray.direction;
  if (body.octree) {
    const Svo& svo = *body.octree->motion.svo;
    pick.voxel = voxel_of(svo, pick.hit.primitive);
    pick.joints = joint_weights(svo, pick.voxel->cell, pick.voxel->code);
    return pick;
  }
  pick.vertices = body.triangles[pick.hit.primitive];
  pick.barycentrics = vec3(1.0f - pick.hit.u - pick.hit.v, pick.hit.u, pick.hit.v);
  pick.joints = joint_weights(body.motion, pick.vertices, pick.barycentrics);
  return pick;
}

std::optional<NearestPoint> World::nearest_point(vec3 from, float max_distance,
                                                 uint32_t mask) const {
  const UpdateGate::Query running(impl_->now().gate);
  return sinew::nearest_point(view_of(impl_->now()), from, max_distance, mask);
}

void World::triangles_in_box(const Box& box, std::vector<TriangleId>& out, uint32_t mask) const {
  const UpdateGate::Query running(impl_->now().gate);
  sinew::triangles_in_box(view_of(impl_->now()), box, out, mask);
}

}  // namespace sinew
