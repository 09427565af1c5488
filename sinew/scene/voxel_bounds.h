// Where voxel objects are over an animation.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/scene/sample.h"
#include "sinew/svo/posed.h"

namespace sinew {

class VoxelBounds {
 public:
  explicit VoxelBounds(const Scene& scene);

  // The box of all voxels of present objects, as the lattice moves them: that of the eight corners
  // of what is occupied in each cell. Where voxels come and go, their bricks stand for them.
  Box at(const ScenePose& pose);

 private:
  // What is occupied in a cell, in voxels.
  struct Extent {
    std::array<uint8_t, 3> low, high;  // high: one past
  };
  struct Octree {
    SvoMotion motion;
    PosedSvo posed;
    std::vector<Extent> extents;  // one a cell; empty: no object has the octree
  };
  static Extent extent_of(const Svo& svo, const SvoBlock& block, const SvoCell& cell);
  static Box box_of(const Octree& octree, uint32_t block, const Affine& placement);

  const Scene& scene_;
  std::vector<Octree> octrees_;
};

}  // namespace sinew
