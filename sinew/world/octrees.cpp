// Voxel objects of a World: octrees as bodies, and the posed octrees that objects share.
#include "sinew/world/octrees.h"

#include <algorithm>
#include <bit>
#include <cstring>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "sinew/base/parallel.h"
#include "sinew/svo/corners.h"
#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

// What makes two objects of a frame look the same but for where they stand.
struct Look {
  BodyId body;
  uint64_t hash;
  std::span<const Affine> joints;
  std::span<const float> weights;
};

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool looks_like(const PosedOctree& octree, const Look& look) {
  return octree.hash == look.hash && octree.body == look.body &&
         same_bytes<Affine>(octree.joints, look.joints) &&
         same_bytes<float>(octree.weights, look.weights);
}

// The table's place for the look: that of an octree in this pose, or a free one.
uint32_t& place_of(OctreeTable& table, const std::deque<PosedOctree>& octrees, const Look& look) {
  const size_t mask = table.slots.size() - 1;
  size_t at = (look.hash ^ look.body) & mask;
  while (table.slots[at] != kNoOctree && !looks_like(octrees[table.slots[at]], look)) {
    at = (at + 1) & mask;
  }
  return table.slots[at];
}

// Lists all octrees; there is room for `more`.
void fill_table(const std::deque<PosedOctree>& octrees, size_t more, OctreeTable& table) {
  table.slots.assign(std::bit_ceil(2 * (octrees.size() + more)), kNoOctree);
  for (uint32_t i = 0; i < octrees.size(); ++i) {
    const PosedOctree& o = octrees[i];
    place_of(table, octrees, {o.body, o.hash, o.joints, o.weights}) = i;
  }
}

void release(PosedObject& posed, std::deque<PosedOctree>& octrees) {
  if (posed.octree == kNoOctree) return;
  --octrees[posed.octree].users;
  posed.octree = kNoOctree;
  posed.pose.joints = {};
  posed.pose.weights = {};
}

void show(uint32_t index, PosedObject& posed, PosedOctree& octree) {
  ++octree.users;
  posed.octree = index;
  posed.pose.joints = octree.joints;
  posed.pose.weights = octree.weights;
}

// One that no object shows: the object's last one if it can be, whose memory has been touched where
// the object was seen; else any, else a new one. None before `first_free` is free.
uint32_t take_free(BodyId body, uint32_t last, std::deque<PosedOctree>& octrees,
                   uint32_t& first_free) {
  const auto is_free = [&](uint32_t i) { return octrees[i].users == 0; };
  if (last != kNoOctree && octrees[last].body == body && is_free(last)) return last;
  while (first_free < octrees.size() && !is_free(first_free)) ++first_free;
  for (uint32_t i = first_free; i < octrees.size(); ++i) {
    if (octrees[i].body == body && is_free(i)) return i;
  }
  octrees.emplace_back().body = body;
  return static_cast<uint32_t>(octrees.size() - 1);
}

// Says which blocks' details rays may look at, and drops what rays have made.
void start_leaves(const OctreeBody& body, PosedOctree& octree) {
  const Svo& svo = *body.motion.svo;
  std::span<const uint8_t> resident;
  if (svo.paging) {
    resident = svo.paging->resident();
    octree.paging_epoch = svo.paging->epoch();
  }
  octree.leaves.set_pose(body.layout, octree.svo, resident);
}

Box rest_box(const Svo& svo) {
  Box box;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const uint32_t end = svo.blocks[b + 1].first_corner;
    for (uint32_t c = svo.blocks[b].first_corner; c < end; ++c) {
      box.extend(corner_rest(svo.grid, svo.blocks[b], svo.corner_places[c]));
    }
  }
  return box;
}

Box built_box(const OctreeBody& octree, const std::optional<Pose>& pose) {
  const Svo& svo = *octree.motion.svo;
  if (svo.blocks.empty() || !pose || !pose->present) return rest_box(svo);
  PosedSvo posed;
  posed.set_pose(octree.motion, *pose);
  return posed.bounds(0);
}

}  // namespace

bool counts_fit(const Svo& svo, const Pose& pose) {
  return pose.joints.size() >= svo.joints && pose.weights.size() == svo.morph_targets;
}

uint64_t pose_hash(const Svo& svo, const Pose& pose) {
  const std::span<const Affine> joints = pose.joints.first(svo.joints);
  uint64_t hash = 0;
  if (!joints.empty()) hash = XXH3_64bits(joints.data(), joints.size_bytes());
  if (pose.weights.empty()) return hash;
  return XXH3_64bits_withSeed(pose.weights.data(), pose.weights.size_bytes(), hash);
}

Result<BodyId> World::add_octree(const OctreeDesc& desc) {
  if (desc.svo == nullptr) {
    return fail(
        {ErrorKind::usage, "", "octree", "there is none", "give one that outlives the world"});
  }
  const Svo& svo = *desc.svo;
  if (desc.build_pose && desc.build_pose->present && !pose_fits(svo, *desc.build_pose)) {
    return fail({ErrorKind::usage, "", "build pose", "it does not fit the octree",
                 "give as many joints and weights as the octree needs, all finite"});
  }
  Body body;
  body.octree = std::make_unique<OctreeBody>();
  body.octree->motion = make_svo_motion(svo);
  SINEW_TRY(body.octree->layout, make_leaf_layout(svo));
  body.deforms = svo.joints > 0 || svo.morph_targets > 0;
  body.built_box = built_box(*body.octree, desc.build_pose);
  impl_->bodies.push_back(std::move(body));
  return static_cast<BodyId>(impl_->bodies.size() - 1);
}

// Finds the octrees of the frame's objects that have moved. What is posed already is found before
// anything of it is posed anew.
void World::Impl::find_octrees(WorldFrame& frame, const WorldFrame& other) {
  for (ObjectId id = 0; id < objects.size(); ++id) {
    if (!objects[id].alive) release(frame.objects[id], frame.octrees);
  }
  frame.unposed.clear();
  frame.to_pose.clear();
  for (const ObjectId id : frame.moved) {
    if (!bodies[objects[id].body].octree) continue;
    PosedObject& posed = frame.objects[id];
    posed.last_octree = posed.octree;
    release(posed, frame.octrees);
    if (posed.present && posed.finite) frame.unposed.push_back(id);
  }
  if (frame.unposed.empty()) return;
  fill_table(frame.octrees, frame.unposed.size(), frame.octree_table);
  const auto look_of = [&](ObjectId id) {
    const Pose& pose = next_pose(other, id);
    const Svo& svo = *bodies[objects[id].body].octree->motion.svo;
    return Look{objects[id].body, frame.objects[id].pose_hash, pose.joints.first(svo.joints),
                pose.weights};
  };
  const auto is_posed = [&](ObjectId id) {
    const uint32_t found = place_of(frame.octree_table, frame.octrees, look_of(id));
    if (found != kNoOctree) show(found, frame.objects[id], frame.octrees[found]);
    return found != kNoOctree;
  };
  std::erase_if(frame.unposed, is_posed);
  uint32_t first_free = 0;
  for (const ObjectId id : frame.unposed) {
    if (is_posed(id)) continue;  // since an object before it
    const Look look = look_of(id);
    PosedObject& posed = frame.objects[id];
    const uint32_t index = take_free(look.body, posed.last_octree, frame.octrees, first_free);
    PosedOctree& octree = frame.octrees[index];
    octree.hash = look.hash;
    octree.joints.assign(look.joints.begin(), look.joints.end());
    octree.weights.assign(look.weights.begin(), look.weights.end());
    place_of(frame.octree_table, frame.octrees, look) = index;
    show(index, posed, octree);
    frame.to_pose.push_back(index);
  }
}

void World::Impl::pose_octrees(WorldFrame& frame, const WorldFrame& other) {
  find_octrees(frame, other);
  parallel_for(frame.to_pose.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      PosedOctree& octree = frame.octrees[frame.to_pose[i]];
      const OctreeBody& body = *bodies[octree.body].octree;
      octree.pose.joints = octree.joints;
      octree.pose.weights = octree.weights;
      octree.svo.set_pose(body.motion, octree.pose);
      start_leaves(body, octree);
    }
  });
  for (const ObjectId id : frame.moved) {
    PosedObject& posed = frame.objects[id];
    if (posed.octree == kNoOctree) continue;
    posed.local_box = frame.octrees[posed.octree].leaves.bounds();
    posed.box = posed.in_place ? posed.local_box : transform_box(posed.placement, posed.local_box);
  }
}

// Poses that were made when other details were there.
void World::Impl::refresh_octrees(WorldFrame& frame) {
  for (PosedOctree& octree : frame.octrees) {
    const OctreeBody& body = *bodies[octree.body].octree;
    const PagedSvoPtr& paging = body.motion.svo->paging;
    if (octree.users == 0 || !paging || paging->epoch() == octree.paging_epoch) continue;
    start_leaves(body, octree);
  }
}

void World::refresh_octrees() const {
  const UpdateGate::Update updating(impl_->now().gate);
  impl_->refresh_octrees(impl_->now());
}

void count_octrees(const WorldFrame& frame, UpdateStats& stats) {
  std::vector<uint8_t> counted(frame.octrees.size(), 0);
  for (const ObjectId id : frame.voxels) {
    const uint32_t index = frame.objects[id].octree;
    if (counted[index] != 0) continue;
    counted[index] = 1;
    const PosedOctree& octree = frame.octrees[index];
    stats.blocks += octree.svo.svo().block_count();
    stats.blocks_made += octree.svo.blocks_made();
    const SvoLeaves::Counts made = octree.leaves.made();
    for (const uint32_t cells : made.cells) stats.cells_made += cells;
  }
}

std::string validate_octree(const WorldFrame& frame, ObjectId id) {
  const PosedObject& posed = frame.objects[id];
  if (posed.octree >= frame.octrees.size()) return "it has no octree";
  const PosedOctree& octree = frame.octrees[posed.octree];
  const auto shows = [&](const PosedObject& o) { return o.octree == posed.octree; };
  if (std::ranges::count_if(frame.objects, shows) != octree.users) return "users are miscounted";
  const Box box = octree.leaves.bounds();
  for (uint32_t b = 0; b < octree.svo.svo().block_count(); ++b) {
    if (!octree.svo.is_made(b)) continue;
    for (const vec3 p : octree.svo.block(b).positions) {
      if (!box.contains(p)) return "a corner of block " + std::to_string(b) + " is not in its box";
    }
  }
  return {};
}

std::span<const ObjectId> World::voxel_objects() const {
  return impl_->now().voxels;
}

bool World::has_voxels(ObjectId object) const {
  return impl_->body_of(object).octree != nullptr;
}

std::optional<VoxelInstance> World::voxel_instance(ObjectId object) const {
  WorldFrame& frame = impl_->now();
  if (!std::ranges::binary_search(frame.voxels, object)) return std::nullopt;
  const PosedObject& posed = frame.objects[object];
  return VoxelInstance{&frame.octrees[posed.octree].svo, posed.placement, 0};
}

VoxelSample World::sample_voxel(const Hit& hit) const {
  const std::optional<VoxelInstance> instance = voxel_instance(hit.object);
  SINEW_CHECK(instance.has_value());
  return sample_voxel_hit(*instance, hit.primitive);
}

}  // namespace sinew
