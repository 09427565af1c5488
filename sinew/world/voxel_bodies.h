// VoxelBodies: the voxel objects of a scene, posed: what a picture's rasteriser draws.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/posed.h"
#include "sinew/world/world.h"

namespace sinew {

class VoxelBodies {
 public:
  // Begins with another scene, which must outlive the object. Allocates.
  void bind(const Scene& scene);

  // Brings the voxel objects to the pose, which must outlive the frame: corners move when the
  // rasteriser asks for them. Absent objects are left out, and those beyond what a key can name.
  // The first pose of a scene makes the motions of its octrees, which may take a second; after it
  // nothing is allocated.
  void set_pose(const Scene& scene, const ScenePose& pose);

  // Or: takes views of the voxel objects that a world shows, until its next commit or flip. Those
  // beyond what a key can name are left out. objects() are the world's then, and boxes are there
  // once list_boxes() has been called.
  void take(const World& world);
  void list_boxes();

  // One for each object that is there, by rising first_unit.
  std::span<const VoxelInstance> instances() const { return instances_; }
  // Index in Scene::voxels of each instance.
  std::span<const uint32_t> objects() const { return objects_; }
  // Contains all instances; world space.
  Box box() const { return box_; }
  // Contains what blocks hold, or whole instances where there are very many; world space.
  std::span<const Box> boxes() const { return boxes_; }

 private:
  uint32_t posed_as(const Scene& scene, const ScenePose& pose, uint32_t object) const;

  std::vector<SvoMotion> motions_;  // one an octree, from the first pose on
  std::vector<PosedSvo> posed_;     // one an object; only leaders' are used
  std::vector<uint32_t> leader_;    // of each object: the first one with this octree and pose
  std::vector<uint32_t> leaders_;   // in this pose
  std::vector<VoxelInstance> instances_;
  std::vector<uint32_t> objects_;
  std::vector<Box> boxes_;
  Box box_;
};

}  // namespace sinew
