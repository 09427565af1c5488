#include "sinew/world/world.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/bvh/update/update.h"
#include "sinew/world/octrees.h"

namespace sinew {
namespace {

constexpr size_t kVerticesPerTask = 4096;

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

// Whether the numbers that make vertices are finite, all of them. If not, derived boxes do not tell
// which vertices are.
bool is_finite_body(const Motion& motion) {
  const auto finite = [](std::span<const vec3> values) {
    vec3 sum(0.0f);  // of products that are 0, or NaN
    for (const vec3 value : values) sum += value * 0.0f;
    return sum == vec3(0.0f);
  };
  const auto finite_weights = [](const SkinMotion& skin) {
    return std::ranges::all_of(skin.weights, [](float w) { return std::isfinite(w); });
  };
  if (const auto* skin = std::get_if<SkinMotion>(&motion)) {
    return finite(skin->rest) && finite_weights(*skin);
  }
  if (const auto* morph = std::get_if<MorphMotion>(&motion)) {
    return finite(morph->rest) && finite(morph->deltas) && finite_weights(morph->skin);
  }
  if (const auto* cache = std::get_if<KeyframeMotion>(&motion)) return finite(cache->keys);
  return true;
}

// One cluster a treelet.
ClusterBounds clusters_of(const Motion& motion, const Bvh8Layout& layout) {
  std::vector<uint32_t> first;
  first.reserve(layout.treelets.size() + 1);
  for (const Treelet& treelet : layout.treelets) first.push_back(treelet.first_vertex);
  first.push_back(static_cast<uint32_t>(layout.vertices.size()));
  return make_cluster_bounds(motion, {first, layout.vertices});
}

Result<BodyTree> given_tree(const BodyDesc& desc, const TimedTree& given, uint32_t vertices) {
  const auto count = static_cast<uint32_t>(desc.triangles.size());
  std::string problem = validate(given.tree, count);
  if (given.areas.size() != given.tree.nodes.size()) problem = "it has not one area a node";
  if (!problem.empty()) {
    return fail({ErrorKind::bad_input, "", "tree", problem, "build it for this body's triangles"});
  }
  BodyTree tree{.begin = given.begin, .layout = {}, .clusters = {}};
  SINEW_TRY(tree.layout, make_layout(given.tree, given.areas, desc.triangles, vertices));
  return tree;
}

// Those that are given, or one that is built for the positions.
Result<std::vector<BodyTree>> trees_of(const BodyDesc& desc, std::span<const vec3> positions) {
  const auto vertices = static_cast<uint32_t>(positions.size());
  SINEW_CHECKED(check_triangles(desc.triangles, vertices));
  std::vector<BodyTree> trees;
  for (const TimedTree& given : desc.trees) {
    if (!trees.empty() && !(given.begin > trees.back().begin)) {
      return fail({ErrorKind::usage, "", "trees", "their times do not rise", "sort them"});
    }
    SINEW_TRY(trees.emplace_back(), given_tree(desc, given, vertices));
  }
  if (trees.empty()) {
    SINEW_TRY(trees.emplace_back().layout, build_layout(positions, desc.triangles, desc.build));
  }
  return trees;
}

}  // namespace

void all_positions(const Motion& motion, const Pose& pose, std::vector<vec3>& out, WorkTime* work) {
  out.resize(vertex_count(motion));
  parallel_for(out.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
    std::optional<WorkTime::Part> timed;
    if (work != nullptr) timed.emplace(*work);
    positions(motion, pose, static_cast<uint32_t>(begin), {out.data() + begin, end - begin});
  });
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
  Body body;
  body.triangles = desc.triangles;
  body.motion = desc.motion;
  body.deforms = deforms(desc.motion);
  body.derivable = body.deforms && derivable(desc.motion) && is_finite_body(desc.motion);
  std::vector<vec3> at;
  if (at_rest) {
    const std::span<const vec3> rest = rest_of(desc.motion);
    at.assign(rest.begin(), rest.end());
  } else {
    all_positions(desc.motion, desc.build_pose, at);
  }
  for (const vec3 p : at) body.built_box.extend(p);
  SINEW_TRY(body.trees, trees_of(desc, at));
  if (!body.deforms) update_full(body.trees.front().layout, at, body.bvh);
  for (BodyTree& tree : body.trees) {
    if (body.derivable) tree.clusters = clusters_of(body.motion, tree.layout);
  }
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
  if (!impl_->bodies[body].deforms) {  // a deforming one waits for its first pose
    object.fresh = true;
    object.version = 1;
  }
  impl_->objects.push_back(std::move(object));
  for (WorldFrame& frame : impl_->frames) frame.objects.emplace_back();
  return static_cast<ObjectId>(impl_->objects.size() - 1);
}

Object& World::Impl::object(ObjectId id) {
  SINEW_CHECK(id < objects.size() && objects[id].alive);
  return objects[id];
}

// Rays meet a removed object until the next commit, so it still answers.
const PosedObject& World::Impl::posed(ObjectId id) const {
  SINEW_CHECK(id < objects.size());
  return now().objects[id];
}

const Bvh8& World::Impl::bvh_of(ObjectId id) const {
  const Body& body = body_of(id);
  return body.deforms ? now().objects[id].bvh : body.bvh;
}

void World::remove_object(ObjectId object) {
  impl_->object(object).alive = false;
}
void World::set_visible(ObjectId object, bool visible) {
  impl_->object(object).desc.visible = visible;
}
void World::set_mask(ObjectId object, uint32_t mask) {
  impl_->object(object).desc.mask = mask;
}
void World::set_update_mode(UpdateMode mode) {
  impl_->mode = mode;
}
void World::set_top_tree(TopTree top) {
  impl_->top_tree = top;
}

Result<void> World::set_pose(ObjectId id, const Pose& pose) {
  Object& object = impl_->object(id);
  const Body& body = impl_->bodies[object.body];
  const bool fits =
      body.octree ? counts_fit(*body.octree->motion.svo, pose) : pose_fits(body.motion, pose);
  if (pose.present && !fits) {
    return fail({ErrorKind::usage, "", "object " + std::to_string(id),
                 "the pose does not fit the motion of its body",
                 "give as many joints, weights or positions as the motion needs"});
  }
  object.pose = pose;
  object.fresh = true;
  ++object.version;
  return {};
}

Result<void> World::use_tree(ObjectId id, uint32_t tree) {
  Object& object = impl_->object(id);
  const size_t count = impl_->bodies[object.body].trees.size();
  if (tree >= count) {
    return fail({ErrorKind::usage, "", "object " + std::to_string(id),
                 "its body has no tree " + std::to_string(tree),
                 "it has " + std::to_string(count) + ", counted from 0"});
  }
  object.tree = tree;
  return {};
}

Box World::box() const {
  return impl_->now().box;
}
float World::size() const {
  Box box;
  for (const Instance& instance : impl_->now().instances) {
    box.extend(transform_box(instance.placement, impl_->body_of(instance.object).built_box));
  }
  return box.empty() ? 0.0f : length(box.extent());
}
std::span<const vec3> World::Impl::known_positions(ObjectId id) const {
  const Motion& motion = body_of(id).motion;
  if (const auto* rigid = std::get_if<RigidMotion>(&motion)) return rigid->rest;
  return now().objects[id].positions;
}

// Of the vertices [first, first + out.size()).
void World::Impl::positions(ObjectId id, uint32_t first, std::span<vec3> out) const {
  const Motion& motion = body_of(id).motion;
  const Pose& pose = now().objects[id].pose;
  const std::span<const vec3> known = known_positions(id), rest = rest_of(motion);
  if (known.empty() && pose_fits(motion, pose)) {
    sinew::positions(motion, pose, first, out);
  } else if (!known.empty() || !rest.empty()) {
    std::ranges::copy((known.empty() ? rest : known).subspan(first, out.size()), out.begin());
  } else {
    std::ranges::fill(out, vec3(0.0f));
  }
}

std::span<const vec3> World::known_positions(ObjectId object) const {
  return impl_->known_positions(object);
}
void World::positions(ObjectId object, std::span<vec3> out) const {
  SINEW_CHECK(out.size() == vertex_count(impl_->body_of(object).motion));
  parallel_for(out.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
    impl_->positions(object, static_cast<uint32_t>(begin), out.subspan(begin, end - begin));
  });
}
vec3 World::position(ObjectId object, uint32_t vertex) const {
  vec3 at;
  impl_->positions(object, vertex, {&at, 1});
  return at;
}
std::array<vec3, 3> World::triangle(ObjectId object, uint32_t primitive) const {
  const Body& body = impl_->body_of(object);
  SINEW_CHECK(primitive < body.triangles.size());
  const uvec3 t = body.triangles[primitive];
  return {position(object, t.x), position(object, t.y), position(object, t.z)};
}

Affine World::placement(ObjectId object) const {
  return impl_->posed(object).placement;
}
bool World::mirrored(ObjectId object) const {
  return glm::determinant(linear_part(placement(object))) < 0.0f;
}

UpdateStats World::stats() const {
  const WorldFrame& frame = impl_->now();
  UpdateStats stats = frame.stats;
  for (const Instance& instance : frame.instances) {
    const Body& body = impl_->body_of(instance.object);
    if (!body.deforms || body.octree) continue;
    const PosedObject& posed = frame.objects[instance.object];
    const size_t treelets = tree_of(body, posed).layout.treelets.size();
    stats.treelets += treelets;
    stats.treelets_made += posed.mode == UpdateMode::full
                               ? treelets
                               : posed.visited.made.load(std::memory_order_relaxed);
  }
  count_octrees(frame, stats);
  return stats;
}

UpdateChoice World::choice(ObjectId object) const {
  return impl_->object(object).history.choice;
}

std::string World::validate() const {
  for (const Instance& instance : impl_->now().instances) {
    const ObjectId id = instance.object;
    const Body& body = impl_->body_of(id);
    if (body.octree) {
      const std::string problem = validate_octree(impl_->now(), id);
      if (!problem.empty()) return "object " + std::to_string(id) + ": " + problem;
      continue;
    }
    if (instance.body != nullptr && !is_ready(*instance.body)) continue;
    std::vector<vec3> at(vertex_count(body.motion));
    impl_->positions(id, 0, at);
    const Bvh8Layout& layout = tree_of(body, impl_->posed(id)).layout;
    const std::string problem = sinew::validate(layout, impl_->bvh_of(id), at, body.triangles);
    if (!problem.empty()) return "object " + std::to_string(id) + ": " + problem;
  }
  return {};
}

}  // namespace sinew
