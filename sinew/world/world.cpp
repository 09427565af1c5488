#include "sinew/world/world.h"

#include <chrono>
#include <vector>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/top.h"
#include "sinew/bvh/update.h"
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

constexpr size_t kVerticesPerTask = 4096;
constexpr size_t kRaysPerTask = 1024;

// Where the vertices rest, for bodies that are absent when their tree is built.
std::span<const vec3> rest_of(const Motion& motion) {
  if (const auto* rigid = std::get_if<RigidMotion>(&motion)) return rigid->rest;
  if (const auto* skin = std::get_if<SkinMotion>(&motion)) return skin->rest;
  if (const auto* morph = std::get_if<MorphMotion>(&motion)) return morph->rest;
  if (const auto* cache = std::get_if<KeyframeMotion>(&motion)) {
    return cache->keys.first(cache->vertex_count);
  }
  return {};
}

void all_positions(const Motion& motion, const Pose& pose, std::vector<vec3>& out) {
  out.resize(vertex_count(motion));
  parallel_for(out.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
    positions(motion, pose, static_cast<uint32_t>(begin), {out.data() + begin, end - begin});
  });
}

}  // namespace

std::span<const vec3> World::Impl::positions_of(const Object& object) const {
  const Body& body = bodies[object.body];
  if (const auto* rigid = std::get_if<RigidMotion>(&body.motion)) return rigid->rest;
  return object.positions;
}

void World::Impl::update_object(Object& object) {
  const Body& body = bodies[object.body];
  object.dirty = false;
  object.placement = object.pose.placement;
  object.present = object.pose.present && !is_singular(object.placement);
  object.box = Box();
  if (!object.present) return;
  object.in_place = object.placement == identity_affine();
  object.to_object = object.in_place ? identity_affine() : inverse_affine(object.placement);
  if (body.deforms) {
    all_positions(body.motion, object.pose, object.positions);
    update_full(body.layout, object.positions, object.bvh);
  }
  const Box& local = body.deforms ? object.bvh.box : body.bvh.box;
  object.box = object.in_place ? local : transform_box(object.placement, local);
}

// Widens a box by the rounding of rays that are carried into the object's space.
Box World::Impl::padded(const Object& object) const {
  const Box& exact = object.box;
  if (object.in_place) return exact;
  constexpr float kGamma = 16.0f * 5.97e-8f;
  const vec3 pad = kGamma * glm::max(glm::abs(exact.min), glm::abs(exact.max));
  return {exact.min - pad, exact.max + pad};
}

void World::Impl::build_instances() {
  instances.clear();
  boxes.clear();
  for (size_t id = 0; id < objects.size(); ++id) {
    const Object& object = objects[id];
    if (!object.alive || !object.present || !object.desc.visible) continue;
    if (object.box.empty() || !is_finite(object.box)) continue;
    const Body& body = bodies[object.body];
    const Bvh8& bvh = body.deforms ? object.bvh : body.bvh;
    instances.push_back({.nodes = bvh.nodes.data(),
                         .packets = bvh.packets.data(),
                         .primitives = body.layout.packet_primitives.data(),
                         .root = bvh.root,
                         .to_object = object.to_object,
                         .object = static_cast<uint32_t>(id),
                         .mask = object.desc.mask,
                         .in_place = object.in_place,
                         .filtered = object.desc.filtered,
                         .single_sided = object.desc.single_sided});
    boxes.push_back(padded(object));
  }
  build_top(boxes, top);
  box = Box();
  for (const Box& b : boxes) box.extend(b);
}

SceneView World::Impl::view() const {
  // A lone object needs no top tree.
  return {instances.size() > 1 ? top.data() : nullptr, instances.data(),
          static_cast<uint32_t>(instances.size())};
}

World::World() : impl_(std::make_unique<Impl>()) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

Result<BodyId> World::add_body(const BodyDesc& desc) {
  if (const std::string problem = sinew::validate(desc.motion); !problem.empty()) {
    return fail({ErrorKind::bad_input, "", "motion", problem, "repair the body's data"});
  }
  const bool at_rest = !desc.build_pose.present;
  if (at_rest ? rest_of(desc.motion).size() != vertex_count(desc.motion)
              : !pose_fits(desc.motion, desc.build_pose)) {
    return fail({ErrorKind::usage, "", "build pose", "it does not fit the body's motion",
                 "give as many joints, weights or positions as the motion needs"});
  }
  Body body{desc.triangles, desc.motion, {}, {}, deforms(desc.motion)};
  std::vector<vec3> at;
  if (at_rest) {
    const std::span<const vec3> rest = rest_of(desc.motion);
    at.assign(rest.begin(), rest.end());
  } else {
    all_positions(desc.motion, desc.build_pose, at);
  }
  SINEW_TRY(body.layout, build_layout(at, desc.triangles, desc.build));
  if (!body.deforms) update_full(body.layout, at, body.bvh);
  impl_->bodies.push_back(std::move(body));
  return static_cast<BodyId>(impl_->bodies.size() - 1);
}

Result<ObjectId> World::add_object(BodyId body, const ObjectDesc& desc) {
  if (body >= impl_->bodies.size()) {
    return fail({ErrorKind::usage, "", "body " + std::to_string(body), "there is no such body",
                 "use an id that add_body returned"});
  }
  Object object;
  object.body = body;
  object.desc = desc;
  object.dirty = !impl_->bodies[body].deforms;  // a deforming one waits for its first pose
  impl_->objects.push_back(std::move(object));
  return static_cast<ObjectId>(impl_->objects.size() - 1);
}

Object& World::Impl::object(ObjectId id) {
  SINEW_CHECK(id < objects.size() && objects[id].alive);
  return objects[id];
}

void World::remove_object(ObjectId object) {
  Object& removed = impl_->object(object);
  removed = Object();
  removed.alive = false;
}
void World::set_visible(ObjectId object, bool visible) {
  impl_->object(object).desc.visible = visible;
}
void World::set_mask(ObjectId object, uint32_t mask) {
  impl_->object(object).desc.mask = mask;
}

Result<void> World::set_pose(ObjectId id, const Pose& pose) {
  Object& object = impl_->object(id);
  if (pose.present && !pose_fits(impl_->bodies[object.body].motion, pose)) {
    return fail({ErrorKind::usage, "", "object " + std::to_string(id),
                 "the pose does not fit the motion of its body",
                 "give as many joints, weights or positions as the motion needs"});
  }
  object.pose = pose;
  object.dirty = true;
  return {};
}

void World::commit() {
  const auto start = std::chrono::steady_clock::now();
  Impl& w = *impl_;
  w.stats = {};
  w.moved.clear();
  for (size_t i = 0; i < w.objects.size(); ++i) {
    if (w.objects[i].alive && w.objects[i].dirty) w.moved.push_back(static_cast<ObjectId>(i));
  }
  parallel_for(w.moved.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) w.update_object(w.objects[w.moved[i]]);
  });
  for (const ObjectId id : w.moved) {
    const Object& object = w.objects[id];
    const Body& body = w.bodies[object.body];
    if (object.present && body.deforms) w.stats.triangles_updated += body.triangles.size();
  }
  w.build_instances();
  w.stats.objects_present = static_cast<uint32_t>(w.instances.size());
  w.stats.update_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

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
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    QueryOptions part = options;
    part.first_ray += static_cast<uint32_t>(begin);
    sinew::closest_hits(impl_->view(), rays.subspan(begin, end - begin),
                        hits.subspan(begin, end - begin), part);
  });
}

void World::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit,
                     const QueryOptions& options) const {
  SINEW_CHECK(rays.size() == hit.size());
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    QueryOptions part = options;
    part.first_ray += static_cast<uint32_t>(begin);
    sinew::any_hits(impl_->view(), rays.subspan(begin, end - begin),
                    hit.subspan(begin, end - begin), part);
  });
}

void World::count_closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                               std::span<TraversalCounts> counts,
                               const QueryOptions& options) const {
  SINEW_CHECK(rays.size() == hits.size() && rays.size() == counts.size());
  parallel_for(rays.size(), kRaysPerTask, [&](size_t begin, size_t end) {
    QueryOptions part = options;
    part.first_ray += static_cast<uint32_t>(begin);
    sinew::count_closest_hits(impl_->view(), rays.subspan(begin, end - begin),
                              hits.subspan(begin, end - begin), counts.subspan(begin, end - begin),
                              part);
  });
}

Box World::box() const {
  return impl_->box;
}
std::span<const vec3> World::positions(ObjectId object) const {
  return impl_->positions_of(impl_->object(object));
}
Affine World::placement(ObjectId object) const {
  return impl_->object(object).placement;
}
bool World::mirrored(ObjectId object) const {
  return glm::determinant(linear_part(placement(object))) < 0.0f;
}
UpdateStats World::stats() const {
  return impl_->stats;
}

std::string World::validate() const {
  for (size_t id = 0; id < impl_->objects.size(); ++id) {
    const Object& object = impl_->objects[id];
    if (!object.alive || !object.present || object.dirty) continue;
    const Body& body = impl_->bodies[object.body];
    const std::string problem = sinew::validate(body.layout, body.deforms ? object.bvh : body.bvh,
                                                impl_->positions_of(object), body.triangles);
    if (!problem.empty()) return "object " + std::to_string(id) + ": " + problem;
  }
  return {};
}

}  // namespace sinew
