// Brings the objects of a frame to their poses, each by its update mode, and builds the top tree.
#include <chrono>
#include <cstring>

#include "sinew/base/parallel.h"
#include "sinew/bvh/top.h"
#include "sinew/bvh/update/update.h"
#include "sinew/world/octrees.h"

namespace sinew {
namespace {

// Upper trees with more treelets are made by all threads in the update rather than by the first
// ray's thread.
constexpr size_t kEagerTreelets = 4096;

template <class T>
bool same_values(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

// Whether the pose gives the vertices that are there already.
bool same_shape(const Motion& motion, const PosedObject& posed, const Pose& pose) {
  if (!posed.shaped || std::holds_alternative<FreeMotion>(motion)) return false;
  return same_values<Affine>(posed.joints, pose.joints) &&
         same_values<float>(posed.weights, pose.weights) && posed.pose.key == pose.key &&
         posed.pose.key_fraction == pose.key_fraction;
}

// Whether only a part of the vertices is new. After a pose with vertices that were not finite they
// are all looked at again.
bool is_part(const Body& body, const PosedObject& posed, const Pose& pose) {
  return std::holds_alternative<FreeMotion>(body.motion) && posed.shaped && posed.finite &&
         pose.changed.count < tree_of(body, posed).layout.vertex_count;
}

// Puts the boxes of the other tree in place; those of this one are kept.
void change_tree(const Body& body, uint32_t tree, PosedObject& posed) {
  if (posed.tree == tree) return;
  posed.resting.resize(body.trees.size());
  std::swap(posed.bvh, posed.resting[posed.tree]);
  std::swap(posed.bvh, posed.resting[tree]);
  posed.tree = tree;
  posed.shaped = false;
  posed.way = {};
}

void copy_pose(const Motion& motion, const Pose& from, PosedObject& to) {
  to.joints.assign(from.joints.begin(), from.joints.end());
  to.weights.assign(from.weights.begin(), from.weights.end());
  to.pose = from;
  to.pose.joints = to.joints;
  to.pose.weights = to.weights;
  to.pose.positions = {};
  to.positions.clear();
  if (!std::holds_alternative<FreeMotion>(motion)) return;
  all_positions(motion, from, to.positions);
  to.pose.positions = to.positions;
}

// Widens a box by the rounding of rays that are carried into the object's space.
Box padded(const PosedObject& posed, const Box& box) {
  if (posed.in_place) return box;
  constexpr float kGamma = 16.0f * 5.97e-8f;
  const vec3 pad = kGamma * glm::max(glm::abs(box.min), glm::abs(box.max));
  return {box.min - pad, box.max + pad};
}

bool is_finite_pose(const Pose& pose) {
  float sum = 0.0f;  // of products that are 0, or NaN
  for (const Affine& joint : pose.joints) {
    for (int column = 0; column < 4; ++column) sum += dot(joint[column] * 0.0f, vec3(1.0f));
  }
  for (const float weight : pose.weights) sum += weight * 0.0f;
  return sum == 0.0f;
}

// The body's derived box; false if it would hide that something is not finite.
bool derive_box(const Body& body, PosedObject& posed) {
  if (!is_finite_pose(posed.pose)) return false;
  posed.local_box = derive_body_bounds(tree_of(body, posed).clusters, body.motion, posed.pose);
  return tree_of(body, posed).layout.treelets.empty() || is_finite(posed.local_box);
}

bool is_shown(const Object& object, const PosedObject& posed) {
  return object.alive && object.desc.visible && posed.present && posed.finite &&
         !posed.box.empty() && is_finite(posed.box);
}

Instance instance_of_octree(const Object& object, ObjectId id, const PosedObject& posed,
                            const PosedOctree& octree) {
  return {.boxes = &octree.leaves.body(),
          .to_object = posed.to_object,
          .object = id,
          .mask = object.desc.mask,
          .in_place = posed.in_place,
          .filtered = object.desc.filtered,
          .placement = posed.placement};
}

Instance instance_of(const Object& object, ObjectId id, const Body& body, PosedObject& posed) {
  Bvh8& bvh = body.deforms ? posed.bvh : const_cast<Bvh8&>(body.bvh);
  const bool visits = body.deforms && posed.mode != UpdateMode::full;
  const Bvh8Layout& layout = tree_of(body, posed).layout;
  return {.nodes = bvh.nodes.data(),
          .packets = visits ? nullptr : bvh.packets.data(),
          .corners = layout.packet_corners.data(),
          .vertices = bvh.vertices.data(),
          .primitives = layout.packet_primitives.data(),
          .root = bvh.root,
          .body = visits ? &posed.visited : nullptr,
          .to_object = posed.to_object,
          .object = id,
          .mask = object.desc.mask,
          .in_place = posed.in_place,
          .filtered = object.desc.filtered,
          .single_sided = object.desc.single_sided,
          .placement = posed.placement};
}

}  // namespace

// Derived boxes if `lazy`, else the vertices and what the mode makes of them.
void World::Impl::update_shape(const Body& body, PosedObject& posed) {
  const BodyTree& tree = tree_of(body, posed);
  VisitedBody& visited = posed.visited;
  visited.layout = &tree.layout;
  visited.bvh = &posed.bvh;
  visited.motion = &body.motion;
  visited.pose = &posed.pose;
  visited.clusters = &tree.clusters;
  visited.made.store(0, std::memory_order_relaxed);
  visited.upper_work.reset();
  visited.make_work.reset();
  posed.work.reset();
  visited.upper.store(kUnmade, std::memory_order_relaxed);
  posed.finite = true;
  posed.shaped = true;
  if (posed.mode == UpdateMode::lazy && derive_box(body, posed)) {
    visited.positions = nullptr;
    reserve(tree.layout, posed.bvh);
    const bool eager = tree.layout.treelets.size() > kEagerTreelets;
    if (eager || top_tree == TopTree::treelets) visit_upper(visited, Threads::all);
    return;
  }
  // Whether an object is there must not depend on the mode: only vertices say what is finite.
  if (posed.mode == UpdateMode::lazy) posed.mode = UpdateMode::hybrid;
  if (posed.positions.empty()) all_positions(body.motion, posed.pose, posed.positions, &posed.work);
  visited.positions = posed.positions.data();
  posed.finite = posed.mode == UpdateMode::full
                     ? update_full(tree.layout, posed.positions, posed.bvh, &posed.work)
                     : update_hybrid(tree.layout, posed.positions, posed.bvh, &posed.work);
  posed.local_box = posed.bvh.box;
  visited.upper.store(posed.bvh.root, std::memory_order_release);
}

// Of given vertices, those that differ from the pose before.
void World::Impl::update_part(const Body& body, const Pose& pose, PosedObject& posed) {
  const Bvh8Layout& layout = tree_of(body, posed).layout;
  const auto from = pose.positions.begin() + pose.changed.first;
  std::copy_n(from, pose.changed.count, posed.positions.begin() + pose.changed.first);
  if (posed.way.first.empty()) posed.way = find_way_up(layout);
  posed.finite &= update_local(layout, posed.positions, pose.changed, posed.way, posed.bvh);
  posed.local_box = posed.bvh.box;
  posed.pose.changed = pose.changed;
  posed.visited.made.store(0, std::memory_order_relaxed);
  posed.visited.make_work.reset();
  posed.visited.upper.store(posed.bvh.root, std::memory_order_release);
}

// What became of the object's last pose, if it had one that rays were traced in.
std::optional<UpdateOutcome> World::Impl::outcome(const Body& body, const PosedObject& last) const {
  const WorldFrame& frame = now();
  const uint64_t rays = frame.rays.load(std::memory_order_relaxed);
  UpdateOutcome out;
  out.mode = last.mode;
  out.treelets = static_cast<double>(tree_of(body, last).layout.treelets.size());
  out.made = last.visited.made.load(std::memory_order_relaxed);
  if (!last.shaped || (rays == 0 && out.made == 0.0)) return std::nullopt;
  out.rays = static_cast<double>(rays);
  out.ray_share = out.made / std::max(frame.reached, 1.0);  // as its treelets are of all reached
  out.update_ns = last.mode == UpdateMode::lazy ? last.visited.upper_work.ns() : last.work.ns();
  out.timed = timed_treelets(last.visited);
  out.make_ns = last.visited.make_work.ns();
  return out;
}

UpdateMode World::Impl::choose(ObjectId id) {
  Object& object = objects[id];
  const Body& body = bodies[object.body];
  const UpdateMode thrifty = body.derivable ? UpdateMode::lazy : UpdateMode::hybrid;
  if (mode != UpdateMode::automatic) return mode == UpdateMode::lazy ? thrifty : mode;
  return choose_mode(body.derivable, outcome(body, now().objects[id]), object.history);
}

// `other` is the frame that had the object's last pose, should the caller have forgotten it.
const Pose& World::Impl::next_pose(const WorldFrame& other, ObjectId id) const {
  return objects[id].fresh ? objects[id].pose : other.objects[id].pose;
}

void World::Impl::update_object(WorldFrame& frame, const WorldFrame& other, ObjectId id) {
  const Object& object = objects[id];
  const Body& body = bodies[object.body];
  PosedObject& posed = frame.objects[id];
  const Pose& pose = next_pose(other, id);
  const bool is_next = posed.version + 1 == object.version;
  posed.version = object.version;
  posed.placement = pose.placement;
  posed.present = pose.present && !is_singular(pose.placement);
  posed.box = Box();
  posed.changed = false;
  posed.pose.placement = pose.placement;
  posed.pose.present = pose.present;
  if (!posed.present) {
    posed.shaped = false;
    return;
  }
  posed.in_place = posed.placement == identity_affine();
  posed.to_object = posed.in_place ? identity_affine() : inverse_affine(posed.placement);
  if (body.octree) {  // pose_octrees() does the rest
    const Svo& svo = *body.octree->motion.svo;
    posed.finite = pose_fits(svo, pose);
    if (posed.finite) posed.pose_hash = pose_hash(svo, pose);
    return;
  }
  if (body.deforms) change_tree(body, object.tree, posed);
  posed.changed = body.deforms && !same_shape(body.motion, posed, pose);
  if (is_next && is_part(body, posed, pose)) {
    update_part(body, pose, posed);
  } else if (posed.changed) {
    posed.mode = choose(id);
    copy_pose(body.motion, pose, posed);
    update_shape(body, posed);
  }
  const Box& local = body.deforms ? posed.local_box : body.bvh.box;
  posed.box = posed.in_place ? local : transform_box(posed.placement, local);
}

void World::Impl::update(uint32_t index) {
  const auto start = std::chrono::steady_clock::now();
  WorldFrame& frame = frames[index];
  const WorldFrame& other = frames[1 - index];
  const UpdateGate::Update updating(frame.gate);
  frame.stats = {};
  frame.moved.clear();
  for (ObjectId id = 0; id < objects.size(); ++id) {
    if (!objects[id].alive || frame.objects[id].version == objects[id].version) continue;
    frame.moved.push_back(id);
  }
  if (mode == UpdateMode::automatic) count_reached(frames[shown]);
  parallel_for(frame.moved.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) update_object(frame, other, frame.moved[i]);
  });
  pose_octrees(frame, other);
  refresh_octrees(frame);
  count_updates(frame);
  build_top_tree(frame);
  for (Object& object : objects) object.fresh = false;
  frame.rays.store(0, std::memory_order_relaxed);
  frame.stats.update_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Of an object that was updated in full nothing newer is known than what rays reached before.
void World::Impl::count_reached(WorldFrame& frame) const {
  frame.reached = 0.0;
  for (const Instance& instance : frame.instances) {
    const PosedObject& posed = frame.objects[instance.object];
    if (!posed.shaped) continue;
    if (posed.mode != UpdateMode::full) {
      frame.reached += posed.visited.made.load(std::memory_order_relaxed);
      continue;
    }
    const Object& object = objects[instance.object];
    const size_t treelets = tree_of(bodies[object.body], posed).layout.treelets.size();
    frame.reached += double{object.history.choice.reached} * static_cast<double>(treelets);
  }
}

void World::Impl::count_updates(WorldFrame& frame) const {
  UpdateStats& stats = frame.stats;
  for (const ObjectId id : frame.moved) {
    const PosedObject& posed = frame.objects[id];
    const Body& body = bodies[objects[id].body];
    if (!posed.present || !body.deforms || body.octree) continue;
    if (!posed.changed) {
      ++stats.unchanged;
      continue;
    }
    ++(posed.mode == UpdateMode::full     ? stats.full
       : posed.mode == UpdateMode::hybrid ? stats.hybrid
                                          : stats.lazy);
    stats.triangles_updated += body.triangles.size();
  }
  stats.octrees_posed = static_cast<uint32_t>(frame.to_pose.size());
}

// Hangs the object's treelets in the top tree, each by itself.
void World::Impl::add_treelets(uint32_t instance, const Body& body, PosedObject& posed,
                               WorldFrame& frame) {
  // The top tree, or what is shown, may have changed since the pose came.
  if (posed.mode != UpdateMode::full) visit_upper(posed.visited, Threads::all);
  for (const Treelet& treelet : tree_of(body, posed).layout.treelets) {
    const Node8& parent = posed.bvh.nodes[treelet.parent_node];
    const Box local = lane_box(parent, treelet.parent_lane);
    if (local.empty()) continue;
    const Box box = posed.in_place ? local : transform_box(posed.placement, local);
    frame.boxes.push_back(padded(posed, box));
    frame.leaves.push_back({instance, parent.child[treelet.parent_lane]});
  }
}

void World::Impl::build_top_tree(WorldFrame& frame) {
  frame.instances.clear();
  frame.voxels.clear();
  frame.boxes.clear();
  frame.leaves.clear();
  frame.box = Box();
  for (ObjectId id = 0; id < objects.size(); ++id) {
    PosedObject& posed = frame.objects[id];
    const Object& object = objects[id];
    if (object.alive && posed.present && !posed.finite) ++frame.stats.objects_skipped;
    if (!is_shown(object, posed)) continue;
    const Body& body = bodies[object.body];
    const auto index = static_cast<uint32_t>(frame.instances.size());
    if (body.octree) {
      frame.voxels.push_back(id);
      frame.instances.push_back(instance_of_octree(object, id, posed, frame.octrees[posed.octree]));
    } else {
      frame.instances.push_back(instance_of(object, id, body, posed));
    }
    frame.box.extend(padded(posed, posed.box));
    const bool by_treelets = top_tree == TopTree::treelets && body.deforms && !body.octree &&
                             tree_of(body, posed).layout.upper_nodes > 0;
    if (by_treelets) {
      add_treelets(index, body, posed, frame);
    } else {
      frame.boxes.push_back(padded(posed, posed.box));
      frame.leaves.push_back({index});
    }
  }
  if (top_tree == TopTree::objects) frame.leaves.clear();  // leaf i is instance i
  build_top(frame.boxes, frame.top_scratch, frame.top);
  frame.stats.objects_present = static_cast<uint32_t>(frame.instances.size());
  frame.stats.voxel_objects = static_cast<uint32_t>(frame.voxels.size());
}

void World::commit() {
  impl_->update(impl_->shown);
}
void World::stage() {
  impl_->update(1 - impl_->shown);
  impl_->staged = true;
}
void World::flip() {
  const UpdateGate::Update updating(impl_->now().gate);
  if (!impl_->staged) return;
  impl_->shown = 1 - impl_->shown;
  impl_->staged = false;
  impl_->refresh_octrees(impl_->now());
}

}  // namespace sinew
