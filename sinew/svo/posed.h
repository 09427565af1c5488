// PosedSvo: one octree in one pose. Setting a pose moves nothing; boxes of nodes follow from the
// pose alone, and a block's corners are moved when somebody looks at it, once a pose.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/base/buffer.h"
#include "sinew/base/error.h"
#include "sinew/math/box.h"
#include "sinew/motion/clusters.h"
#include "sinew/motion/motion.h"
#include "sinew/svo/format.h"

namespace sinew {

// What is made of an octree once, so that its poses cost little: boxes of blocks and of the nodes
// above them as functions of the pose (see motion/clusters.h), by the nodes' order.
struct SvoMotion {
  const Svo* svo = nullptr;  // must outlive it
  uint32_t upper_nodes = 0;  // how many are of levels above kBlockLevel
  ClusterBounds upper;       // a cluster for each of these, not split: that takes long for so many
                             // corners
  ClusterBounds blocks;      // a cluster for each block
  std::vector<vec3> sizes;   // one a morph target: what shape() shows

  // A motion of the kind that `bounds` was made of, without its corners.
  Motion shape() const;
};
SvoMotion make_svo_motion(const Svo& svo);

// Whether the pose has the joints and morph weights that the octree needs, all finite.
bool pose_fits(const Svo& svo, const Pose& pose);

// Where a block's corners are in a pose. Spans have one entry a corner of the block.
struct PosedBlock {
  std::span<const vec3> positions;  // in the object's space (before placement)
  std::span<const mat3> cofactors;  // carry normals from rest to the pose; empty if nothing turns
};

class PosedSvo {
 public:
  // Starts a pose. `motion` must outlive the object, the pose's spans the pose. The pose must fit.
  // After the first call with a motion nothing is allocated.
  void set_pose(const SvoMotion& motion, const Pose& pose);

  const Svo& svo() const { return *motion_->svo; }
  const Pose& pose() const { return pose_; }

  // Contains every corner of every cell below the node, as make_block computes them, in the
  // object's space. The node must be of level kBlockLevel or above.
  Box bounds(uint32_t node) const;

  // Moves the corners of the block if that has not been done in this pose. Different blocks may be
  // made by different threads at the same time, one block only by one.
  void make_block(uint32_t block);
  bool is_made(uint32_t block) const { return made_[block] == epoch_; }
  // Of a block that is made.
  PosedBlock block(uint32_t block) const;

  uint32_t blocks_made() const;  // in this pose

 private:
  const SvoMotion* motion_ = nullptr;
  Pose pose_;
  uint32_t epoch_ = 0;
  std::vector<uint32_t> made_;  // epoch, one a block
  Buffer<vec3> positions_;      // memory is touched only for blocks that are made
  Buffer<mat3> cofactors_;
};

// The skin lattice as a map: where the point at `local` (0..1 along each axis of the cell) goes.
vec3 map_point(const SvoCell& cell, const PosedBlock& block, vec3 local);
// Trilinear mean of the corners' cofactors; identity if there are none.
mat3 map_normals(const SvoCell& cell, const PosedBlock& block, vec3 local);

}  // namespace sinew
