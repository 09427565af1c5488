#include "sinew/world/voxel_bodies.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr size_t kMostBoxes = 8192;  // beyond it one an instance

}  // namespace

void VoxelBodies::bind(const Scene& scene) {
  motions_.clear();
  posed_ = std::vector<PosedSvo>(scene.voxels.size());
  leader_.assign(scene.voxels.size(), 0);
  leaders_.clear();
  leaders_.reserve(scene.voxels.size());
  instances_.clear();
  instances_.reserve(scene.voxels.size());
  objects_.clear();
  objects_.reserve(scene.voxels.size());
  boxes_.clear();
}

// The object of this pose that looks the same but for its placement; the object itself if none
// does.
uint32_t VoxelBodies::posed_as(const Scene& scene, const ScenePose& pose, uint32_t object) const {
  const SceneVoxels& what = scene.voxels[object];
  const Pose& wanted = pose.voxels[object];
  const auto found = std::ranges::find_if(leaders_, [&](uint32_t other) {
    return scene.voxels[other].octree == what.octree && scene.voxels[other].skin == what.skin &&
           std::ranges::equal(pose.voxels[other].weights, wanted.weights);
  });
  return found == leaders_.end() ? object : *found;
}

void VoxelBodies::set_pose(const Scene& scene, const ScenePose& pose) {
  instances_.clear();
  objects_.clear();
  leaders_.clear();
  for (size_t i = motions_.size(); i < scene.octrees.size(); ++i) {
    motions_.push_back(make_svo_motion(scene.octrees[i]));
  }
  uint64_t units = 0;
  for (uint32_t i = 0; i < scene.voxels.size(); ++i) {
    const uint32_t octree = scene.voxels[i].octree;
    const Svo& svo = scene.octrees[octree];
    const bool fits = units + unit_count(svo) <= kMostUnits && pose_fits(svo, pose.voxels[i]);
    if (!pose.voxels[i].present || svo.blocks.empty() || !fits) continue;
    leader_[i] = posed_as(scene, pose, i);
    if (leader_[i] == i) {
      posed_[i].set_pose(motions_[octree], pose.voxels[i]);
      leaders_.push_back(i);
    }
    instances_.push_back(
        {&posed_[leader_[i]], pose.voxels[i].placement, static_cast<uint32_t>(units)});
    objects_.push_back(i);
    units += unit_count(svo);
  }
  list_boxes();
}

void VoxelBodies::take(const World& world) {
  instances_.clear();
  objects_.clear();
  boxes_.clear();
  box_ = {};
  uint64_t units = 0;
  for (const ObjectId object : world.voxel_objects()) {
    VoxelInstance instance = *world.voxel_instance(object);
    const uint32_t own = unit_count(instance.posed->svo());
    if (units + own > kMostUnits) continue;
    instance.first_unit = static_cast<uint32_t>(units);
    instances_.push_back(instance);
    objects_.push_back(object);
    units += own;
  }
}

void VoxelBodies::list_boxes() {
  size_t blocks = 0;
  for (const VoxelInstance& instance : instances_) blocks += instance.posed->svo().block_count();
  boxes_.clear();
  box_ = {};
  for (const VoxelInstance& instance : instances_) {
    const Svo& svo = instance.posed->svo();
    const bool whole = blocks > kMostBoxes;
    const uint32_t first = whole ? 0 : svo.first_block_node();
    for (uint32_t i = 0; i < (whole ? 1 : svo.block_count()); ++i) {
      boxes_.push_back(transform_box(instance.placement, instance.posed->bounds(first + i)));
      box_.extend(boxes_.back());
    }
  }
}

}  // namespace sinew
