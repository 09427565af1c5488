// World: objects that move, a top tree over them, and ray queries. Built once; every frame
// set_time (or set_pose and commit) says where things are.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/frames/tree_file.h"
#include "sinew/bvh/trace/proximity.h"
#include "sinew/bvh/trace/traverse.h"
#include "sinew/bvh/update/choose.h"
#include "sinew/bvh/update/update.h"
#include "sinew/math/box.h"
#include "sinew/math/ray.h"
#include "sinew/motion/influences.h"
#include "sinew/motion/motion.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/voxel_at.h"

namespace sinew {

using BodyId = uint32_t;    // a shape with its motion and its tree, or an octree
using ObjectId = uint32_t;  // one appearance of a body; what Hit::object says

struct BodyDesc {
  std::span<const uvec3> triangles;
  Motion motion;        // views must outlive the world
  Pose build_pose;      // the pose for which the tree is built; if it is not present, at rest
  BuildConfig build{};  // of the tree, where none is given
  std::span<const TimedTree> trees{};  // instead of one that is built; by rising times
};

// An octree as a body: its objects are hit where the boxes of their voxels are (svo/leaves.h).
struct OctreeDesc {
  const Svo* svo = nullptr;          // must outlive the world; valid, see validate()
  std::optional<Pose> build_pose{};  // for World::size(); none: at rest
};

struct ObjectDesc {
  uint32_t mask = 0xffffffffu;
  bool visible = true;
  bool filtered = false;      // its hits go through the query's filter
  bool single_sided = false;  // see Facing; voxels have no sides
};

// What commit() did, and what rays have made since.
struct UpdateStats {
  double update_ms = 0.0;  // of the last commit
  uint32_t objects_present = 0;
  uint32_t objects_skipped = 0;  // left out of this frame: a vertex of theirs is not finite
  // Deforming objects by what was done to them:
  uint32_t unchanged = 0, full = 0, hybrid = 0, lazy = 0;
  uint64_t triangles_updated = 0;  // of the objects that are not unchanged
  uint64_t treelets = 0;           // of present deforming objects
  uint64_t treelets_made = 0;      // of these, for the last pose, by the update or by rays
  // Of present voxel objects; objects in the same pose share all of it:
  uint32_t voxel_objects = 0;
  uint32_t octrees_posed = 0;  // new poses in the last commit
  uint64_t blocks = 0;
  uint64_t blocks_made = 0;  // for the last pose, by rays or by who drew them
  uint64_t cells_made = 0;   // by rays; each level of detail of a cell counts
};

// What hangs below the top tree: whole objects, or the treelets of all deforming objects and whole
// rigid ones ("one tree"), which pays where deforming objects overlap. Treelets need their boxes in
// every frame, so objects that no ray reaches cost a little more. Voxel objects hang as wholes.
enum class TopTree : uint8_t { objects, treelets };

// The voxel that a pick has met.
struct PickedVoxel {
  uint32_t cell = 0;      // of the octree's
  VoxelCode code = 0;     // in the cell
  uint32_t level = 0;     // 0 to 3
  uint32_t material = 0;  // index into the scene's materials
  RestVoxel rest;         // which place in the grid it is
};

struct Pick {
  Hit hit;
  vec3 point{0.0f};                  // in the world
  uvec3 vertices{0};                 // of the triangle
  vec3 barycentrics{0.0f};           // their shares of the point
  std::optional<PickedVoxel> voxel;  // of an octree, instead of a triangle
  std::vector<JointWeight> joints;   // of the body's skin, the heaviest first; empty without one
};

// A box of the hierarchy.
struct TreeBox {
  Box box;                      // in the object's space, or the world's
  uint32_t object = kNoObject;  // kNoObject: it belongs to the top tree
};

class World {
 public:
  World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  // Objects of one rigid body share its tree and boxes; objects of a deforming body share the tree.
  Result<BodyId> add_body(const BodyDesc& body);
  // Objects of one octree that are in the same pose share it, whatever their placements.
  Result<BodyId> add_octree(const OctreeDesc& octree);
  Result<ObjectId> add_object(BodyId body, const ObjectDesc& desc = {});
  // These count from the next commit. The id of a removed object is not given again.
  void remove_object(ObjectId object);
  void set_visible(ObjectId object, bool visible);
  void set_mask(ObjectId object, uint32_t mask);

  // `automatic` unless said otherwise. All modes give the same hits.
  void set_update_mode(UpdateMode mode);
  void set_top_tree(TopTree top);

  // The pose counts from the next commit; its spans must live until then. An error if it does not
  // fit the body's motion.
  Result<void> set_pose(ObjectId object, const Pose& pose);

  // Which of its body's trees the object is traced by, from its next pose on: 0 unless said. Worlds
  // made by prepare() choose by time.
  Result<void> use_tree(ObjectId object, uint32_t tree);

  // Brings every object to its pose, then the top tree. Must not overlap queries.
  void commit();

  // The same without touching what queries see, so that one frame can be posed while another is
  // traced; flip() then shows it, and does nothing if nothing is staged. Only flip() must not
  // overlap queries. Takes twice the memory.
  void stage();
  void flip();

  // For worlds made by prepare(): samples the clip and commits, or stages. The world keeps the
  // pose.
  Result<void> set_time(double seconds);
  Result<void> stage_time(double seconds);
  const ScenePose& pose() const;

  std::optional<Hit> closest_hit(const Ray& ray) const;
  bool any_hit(const Ray& ray) const;
  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                    const QueryOptions& options = {}) const;
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit,
                const QueryOptions& options = {}) const;
  // closest_hits that also counts what each ray cost.
  void count_closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                          std::span<TraversalCounts> counts,
                          const QueryOptions& options = {}) const;

  // Every hit along the ray, sorted by (t, object, primitive).
  void all_hits(const Ray& ray, std::vector<Hit>& out, const QueryOptions& options = {}) const;
  // The closest hit, and what of the character it is.
  std::optional<Pick> pick(const Ray& ray, const QueryOptions& options = {}) const;
  // These two look at triangles only.
  std::optional<NearestPoint> nearest_point(
      vec3 from, float max_distance = std::numeric_limits<float>::infinity(),
      uint32_t mask = 0xffffffffu) const;
  // The triangles that meet the box, sorted.
  void triangles_in_box(const Box& box, std::vector<TriangleId>& out,
                        uint32_t mask = 0xffffffffu) const;

  // The boxes of the hierarchy `level` steps below the root, which is level 0, and those of leaves
  // that end sooner: together they hold every present object. An object's whole box counts as one
  // box, at the level where it hangs in the top tree.
  std::vector<TreeBox> boxes(uint32_t level) const;

  // Of all present objects, world space. Of lazy and of voxel objects the box is derived, a little
  // larger than that of their vertices or voxels.
  Box box() const;
  // The diagonal of all present objects as they were built: the same in every update mode.
  float size() const;

  // Vertices of an object, in its own space. known_positions() is one a vertex where the update
  // computed them all, and empty for lazy objects; the others always answer: of an object that is
  // not present, how it was last, or at rest (0 where the caller gives the vertices).
  std::span<const vec3> known_positions(ObjectId object) const;
  void positions(ObjectId object, std::span<vec3> out) const;  // one a vertex
  vec3 position(ObjectId object, uint32_t vertex) const;
  std::array<vec3, 3> triangle(ObjectId object, uint32_t primitive) const;

  // Whether the object is of an octree. It has no vertices then.
  bool has_voxels(ObjectId object) const;
  // Those with voxels in the frame that queries see, rising.
  std::span<const ObjectId> voxel_objects() const;
  // How the octree stands in the frame that queries see, for who draws it: blocks that are made
  // there are not made again by rays, and the other way round. Making blocks must not overlap
  // queries. None if the object is not one of these. Valid until the next commit or flip.
  std::optional<VoxelInstance> voxel_instance(ObjectId object) const;
  // Octrees larger than memory (svo/file/stream.h): to be called when details have come or gone
  // since the last commit or flip, which do it too. Must not overlap queries. Rays ask for what
  // they would have met finer; it comes when somebody calls begin_paging() or settle_paging(), as
  // pictures do, and then this. What a hit names may be gone then.
  void refresh_octrees() const;
  // What a ray has met, looked up. The hit must be a voxel's, of this frame.
  VoxelSample sample_voxel(const Hit& hit) const;

  Affine placement(ObjectId object) const;  // object -> world
  bool mirrored(ObjectId object) const;     // its placement turns triangles inside out
  UpdateStats stats() const;                // must not overlap queries if there are voxel objects
  UpdateChoice choice(ObjectId object) const;
  std::string validate() const;  // empty text if every invariant holds

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  friend Result<World> prepare(const Scene&, const struct PrepareOptions&);
};

struct PrepareOptions {
  std::string clip{};  // name or index; empty: the first clip if there is one; "rest": none
  BuildConfig build{};
  UpdateMode update = UpdateMode::automatic;
  TopTree top_tree = TopTree::objects;
  bool over_clip = true;            // else every tree is built for the clip's middle alone
  const TreeFile* trees = nullptr;  // from optimize_trees(); else one is built for every body
};

// Builds a world with one object a Scene::objects, in that order, then one a Scene::voxels, and
// sets the clip's first time.
// Trees that are not given are built for the middle of the clip, or over five of its frames where
// that one would get much dearer. The scene must outlive the world;
// `trees` need not. Errors also: trees that do not fit (check_trees()).
Result<World> prepare(const Scene& scene, const PrepareOptions& options = {});

// Index of the clip that `name` (a name, or an index) means, or kRestPose. A usage error that lists
// the clips if there is none such.
Result<int> find_clip(const Scene& scene, const std::string& name);

}  // namespace sinew
