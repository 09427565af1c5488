// What a World holds. Internal to sinew/world.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <span>
#include <vector>

#include "sinew/base/check.h"
#include "sinew/base/update_gate.h"
#include "sinew/bvh/top.h"
#include "sinew/bvh/update/update_local.h"
#include "sinew/bvh/update/visit.h"
#include "sinew/bvh/wide.h"
#include "sinew/motion/clusters.h"
#include "sinew/svo/leaves.h"
#include "sinew/svo/posed.h"
#include "sinew/world/world.h"

namespace sinew {

// How a body is traced in a part of its animation.
struct BodyTree {
  double begin = 0.0;  // see TimedTree
  Bvh8Layout layout;
  ClusterBounds clusters;  // one a treelet, if boxes can be derived
};

// An octree as rays see it.
struct OctreeBody {
  SvoMotion motion;
  SvoLeafLayout layout;
};

// What stays the same while things move.
struct Body {
  std::unique_ptr<OctreeBody> octree;  // of octrees, instead of triangles, motion and trees
  std::span<const uvec3> triangles;
  Motion motion;
  std::vector<BodyTree> trees;  // at least one
  Bvh8 bvh;                     // of rigid bodies, shared by all their objects
  Box built_box;                // of the vertices that the tree was built for
  bool deforms = false;
  bool derivable = false;
};

// What the caller said of an object, and what is known of it from frame to frame.
struct Object {
  BodyId body = 0;
  ObjectDesc desc;
  bool alive = true;
  Pose pose;              // spans are valid only while fresh
  uint32_t tree = 0;      // of the body's, that counts from the next commit
  bool fresh = false;     // the pose counts from the next commit
  uint32_t version = 0;   // of the pose; 0: none yet
  UpdateHistory history;  // of mode `automatic`
};

// An octree in a pose: what the objects of a frame share that look the same but for where they
// stand. Memory is touched only where somebody looks.
struct PosedOctree {
  BodyId body = 0;
  uint32_t users = 0;  // objects; what has none is kept for the next pose
  uint64_t hash = 0;   // of the pose
  std::vector<Affine> joints;
  std::vector<float> weights;
  Pose pose;  // views of these
  PosedSvo svo;
  SvoLeaves leaves;
  uint64_t paging_epoch = 0;  // of the details that are there, if they come and go
};
inline constexpr uint32_t kNoOctree = 0xffffffffu;

// Which poses there are, by their hashes.
struct OctreeTable {
  std::vector<uint32_t> slots;  // indices of posed octrees, kNoOctree: free; a power of two of them
};

// An object in one frame.
struct PosedObject {
  uint32_t version = 0;  // of the object's pose that this shows
  bool present = false;
  bool in_place = true;  // placement is the identity
  Affine placement = identity_affine();
  Affine to_object = identity_affine();
  Box box;  // world space

  // Of deforming bodies:
  bool shaped = false;   // what follows belongs to a pose
  bool changed = false;  // by the last update
  bool finite = true;
  UpdateMode mode = UpdateMode::full;
  uint32_t tree = 0;  // of the body's, that `bvh` belongs to
  Box local_box;
  Pose pose;  // views of these copies:
  std::vector<Affine> joints;
  std::vector<float> weights;
  std::vector<vec3> positions;  // of all vertices; of lazy objects empty
  Bvh8 bvh;
  std::vector<Bvh8> resting;  // of the body's other trees, kept for when they come back
  VisitedBody visited;
  WorkTime work;  // of the update
  WayUp way;      // of objects that were updated in part

  // Of octrees:
  uint32_t octree = kNoOctree;       // of the frame's; none of what is absent
  uint32_t last_octree = kNoOctree;  // that it had before the update
  uint64_t pose_hash = 0;
};

inline const BodyTree& tree_of(const Body& body, const PosedObject& posed) {
  return body.trees[posed.tree];
}

// One state of the world. There are two, so that one can be posed while rays are traced through the
// other.
struct WorldFrame {
  std::deque<PosedObject> objects;  // does not move what is in it
  std::deque<PosedOctree> octrees;  // nor does this
  OctreeTable octree_table;
  std::vector<ObjectId> unposed;  // scratch: objects in poses that are new
  std::vector<uint32_t> to_pose;  // scratch: their octrees
  std::vector<Instance> instances;
  std::vector<ObjectId> voxels;  // that the instances show
  std::vector<Box> boxes;        // one a leaf of the top tree
  std::vector<TopLeaf> leaves;
  std::vector<Node8> top;
  TopScratch top_scratch;
  Box box;
  ScenePose pose;  // of prepared worlds
  UpdateStats stats;
  std::vector<ObjectId> moved;
  double reached = 0.0;  // treelets of all objects, by rays, when that was last counted
  mutable std::atomic<uint64_t> rays = 0;  // of spans, traced since the commit
  UpdateGate gate;
};

struct World::Impl {
  std::deque<Body> bodies;
  std::vector<Object> objects;
  std::array<WorldFrame, 2> frames;
  uint32_t shown = 0;   // the frame that queries see
  bool staged = false;  // the other is to be shown next
  UpdateMode mode = UpdateMode::automatic;
  TopTree top_tree = TopTree::objects;

  // Of prepared worlds:
  const Scene* scene = nullptr;
  int clip = kRestPose;

  WorldFrame& now() { return frames[shown]; }
  const WorldFrame& now() const { return frames[shown]; }

  Object& object(ObjectId id);
  const PosedObject& posed(ObjectId id) const;
  const Body& body_of(ObjectId id) const {
    SINEW_CHECK(id < objects.size());
    return bodies[objects[id].body];
  }
  const Bvh8& bvh_of(ObjectId id) const;
  std::span<const vec3> known_positions(ObjectId id) const;
  void positions(ObjectId id, uint32_t first, std::span<vec3> out) const;

  void update(uint32_t frame);
  void update_object(WorldFrame& frame, const WorldFrame& other, ObjectId id);
  const Pose& next_pose(const WorldFrame& other, ObjectId id) const;
  void find_octrees(WorldFrame& frame, const WorldFrame& other);
  void pose_octrees(WorldFrame& frame, const WorldFrame& other);
  void refresh_octrees(WorldFrame& frame);
  void update_shape(const Body& body, PosedObject& posed);
  void update_part(const Body& body, const Pose& pose, PosedObject& posed);
  std::optional<UpdateOutcome> outcome(const Body& body, const PosedObject& last) const;
  UpdateMode choose(ObjectId id);
  void count_reached(WorldFrame& frame) const;
  void count_updates(WorldFrame& frame) const;
  void build_top_tree(WorldFrame& frame);
  void add_treelets(uint32_t instance, const Body& body, PosedObject& posed, WorldFrame& frame);
  Result<void> pose_at(World& world, WorldFrame& frame, double seconds);
};

// All positions of a motion, in parallel.
void all_positions(const Motion& motion, const Pose& pose, std::vector<vec3>& out,
                   WorkTime* work = nullptr);

}  // namespace sinew
