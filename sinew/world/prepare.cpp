// From a Scene to a World: one object a scene object, and the clip that moves them.
#include <algorithm>
#include <charconv>
#include <optional>

#include "sinew/world/animation_trees.h"
#include "sinew/world/body_animation.h"
#include "sinew/world/scene_bodies.h"
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

// What rays must know of the mesh's materials. A mesh that is partly single-sided is left to the
// query's filter, like one with holes.
ObjectDesc describe(const Scene& scene, const Mesh& mesh) {
  size_t single_sided = 0, lets_through = 0;
  for (const MeshPart& part : mesh.parts) {
    const Material& material = scene.materials[part.material];
    single_sided += !material.has_back();
    lets_through += material.alpha_mode != AlphaMode::opaque || material.transmission > 0.0f;
  }
  const bool all_single_sided = single_sided == mesh.parts.size();
  return {.filtered = lets_through > 0 || (single_sided > 0 && !all_single_sided),
          .single_sided = all_single_sided};
}

// A tree over some frames of the clip, if the tree that suits its middle gets much dearer in others
// and this one does not; else none.
std::optional<TimedTree> tree_over_clip(const Scene& scene, const SceneBody& body, int clip) {
  constexpr uint32_t kFrames = 5;
  constexpr double kMuchDearer = 1.3, kMuchCheaper = 0.8;
  const AnimatedBoxes animation = body_animation(scene, body, clip, kFrames);
  if (animation.frame_count() < kFrames) return std::nullopt;
  std::vector<std::vector<Box>> boxes(kFrames, std::vector<Box>(animation.primitive_count));
  for (uint32_t f = 0; f < kFrames; ++f) animation.boxes(f, boxes[f]);
  const FrameBoxes frames = make_frame_boxes(std::move(boxes));
  const Tree middle = build_binned(frames.frames[kFrames / 2]);
  const std::vector<double> costs = frame_costs(middle, frames);
  if (!(*std::ranges::max_element(costs) > kMuchDearer * costs[kFrames / 2])) return std::nullopt;
  TimedTree over_frames = traced_tree(build_over_frames(frames), frames, 0.0);
  const auto average = [&](std::span<const double> c) {
    return power_cost(c, frames.weights, 0.0);
  };
  if (average(frame_costs(over_frames.tree, frames)) > kMuchCheaper * average(costs)) {
    return std::nullopt;
  }
  return over_frames;
}

// Where the body is in the pose, by the first of its objects that is there; else at rest.
Pose build_pose(const Scene& scene, const SceneBody& body, const ScenePose& pose) {
  const int32_t object = object_in_frame(body, pose, 0);
  if (object >= 0) return pose.objects[static_cast<size_t>(object)];
  const Mesh& mesh = scene.meshes[body.mesh];
  Pose at_rest;
  at_rest.present = mesh.vertex_program != nullptr;  // its motion knows no rest of its own
  at_rest.positions = mesh.positions;
  return at_rest;
}

// One body an octree that objects have, and the objects.
Result<void> add_voxels(const Scene& scene, const ScenePose& pose, World& world) {
  std::vector<std::optional<BodyId>> body_of(scene.octrees.size());
  for (size_t i = 0; i < scene.voxels.size(); ++i) {
    const uint32_t octree = scene.voxels[i].octree;
    std::optional<BodyId>& body = body_of[octree];
    if (!body) {
      SINEW_TRY(body, world.add_octree({&scene.octrees[octree], pose.voxels[i]}));
    }
    SINEW_CHECKED(world.add_object(*body));
  }
  return {};
}

uint32_t tree_at(const Body& body, double seconds) {
  uint32_t tree = 0;
  while (tree + 1 < body.trees.size() && body.trees[tree + 1].begin <= seconds) ++tree;
  return tree;
}

}  // namespace

Result<int> find_clip(const Scene& scene, const std::string& name) {
  const int count = static_cast<int>(scene.clips.size());
  if (name.empty()) return count > 0 ? 0 : kRestPose;
  for (int i = 0; i < count; ++i) {
    if (scene.clips[i].name == name) return i;
  }
  if (name == "rest") return kRestPose;
  int index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (error == std::errc() && end == name.data() + name.size() && index >= 0 && index < count) {
    return index;
  }
  std::string list;
  for (int i = 0; i < count; ++i) {
    list += (i > 0 ? ", " : "") + std::to_string(i) + " \"" + scene.clips[i].name + "\"";
  }
  return fail({ErrorKind::usage, scene.name, "", "there is no clip \"" + name + "\"",
               count > 0 ? "it has " + list : "it has no clips; leave the option out"});
}

Result<World> prepare(const Scene& scene, const PrepareOptions& options) {
  World world;
  World::Impl& w = *world.impl_;
  w.scene = &scene;
  SINEW_TRY(w.clip, find_clip(scene, options.clip));
  if (options.trees != nullptr) SINEW_CHECKED(check_trees(*options.trees, scene, w.clip));
  const bool moves = w.clip != kRestPose;
  const double start = moves ? scene.clips[w.clip].start : 0.0;
  // One tree serves the whole clip, so it is built for the clip's middle: of what breaks apart, the
  // parts are separate there already.
  const double middle = moves ? 0.5 * (start + scene.clips[w.clip].end) : 0.0;
  ScenePose& pose = w.now().pose;
  sample(scene, w.clip, middle, pose);

  const std::vector<SceneBody> bodies = scene_bodies(scene);
  std::vector<BodyId> body_of(scene.objects.size());
  for (size_t b = 0; b < bodies.size(); ++b) {
    const SceneBody& body = bodies[b];
    const Mesh& mesh = scene.meshes[body.mesh];
    BodyDesc desc{.triangles = mesh.triangles,
                  .motion = motion_of(mesh, body.skinned),
                  .build_pose = build_pose(scene, body, pose),
                  .build = options.build};
    std::optional<TimedTree> over_clip;
    if (options.trees != nullptr) {
      desc.trees = options.trees->bodies[b];
    } else if (options.over_clip && moves && deforms(desc.motion)) {
      over_clip = tree_over_clip(scene, body, w.clip);
      if (over_clip) desc.trees = {&*over_clip, 1};
    }
    SINEW_TRY(const BodyId id, world.add_body(desc));
    for (const uint32_t object : body.objects) body_of[object] = id;
  }
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.objects[i].mesh];
    SINEW_CHECKED(world.add_object(body_of[i], describe(scene, mesh)));
  }
  SINEW_CHECKED(add_voxels(scene, pose, world));
  w.mode = options.update;
  w.top_tree = options.top_tree;
  SINEW_CHECKED(world.set_time(start));
  return world;
}

Result<void> World::Impl::pose_at(World& world, WorldFrame& frame, double seconds) {
  if (scene == nullptr) {
    return fail({ErrorKind::usage, "", "", "this world was not made by prepare()",
                 "use set_pose and commit"});
  }
  sample(*scene, clip, seconds, frame.pose);
  for (size_t i = 0; i < frame.pose.objects.size(); ++i) {
    if (!objects[i].alive) continue;
    objects[i].tree = tree_at(body_of(static_cast<ObjectId>(i)), seconds);
    SINEW_CHECKED(world.set_pose(static_cast<ObjectId>(i), frame.pose.objects[i]));
  }
  for (size_t i = 0; i < frame.pose.voxels.size(); ++i) {
    const size_t id = frame.pose.objects.size() + i;
    if (!objects[id].alive) continue;
    SINEW_CHECKED(world.set_pose(static_cast<ObjectId>(id), frame.pose.voxels[i]));
  }
  return {};
}

Result<void> World::set_time(double seconds) {
  SINEW_CHECKED(impl_->pose_at(*this, impl_->now(), seconds));
  commit();
  return {};
}

Result<void> World::stage_time(double seconds) {
  SINEW_CHECKED(impl_->pose_at(*this, impl_->frames[1 - impl_->shown], seconds));
  stage();
  return {};
}

const ScenePose& World::pose() const {
  return impl_->now().pose;
}

}  // namespace sinew
