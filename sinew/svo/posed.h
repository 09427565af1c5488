// PosedSvo: one octree in one pose. Setting a pose moves nothing; boxes of nodes follow from the
// pose alone, and a block's corners are moved when somebody looks at it, once a pose.
#pragma once

#include <atomic>
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

// What is made of an octree once, so that its poses cost little: boxes of blocks, and of the whole,
// as functions of the pose (see motion/clusters.h).
struct SvoMotion {
  const Svo* svo = nullptr;     // must outlive it
  uint32_t first_block = 0;     // node of block 0: before it are those of levels above kBlockLevel
  ClusterBounds blocks;         // a cluster for each block
  std::vector<vec3> no_deltas;  // one a morph target: what shape() shows

  // A motion of the kind that `blocks` was made of, without its corners.
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
  // object's space. The node must be of level kBlockLevel or above. The root's box takes a
  // microsecond or two; the first one who asks for another in a pose makes them all, 0.2
  // microseconds a block. Any number of threads may ask.
  Box bounds(uint32_t node) const;

  // Moves the corners of the block if that has not been done in this pose. Different blocks may be
  // made by different threads at the same time, one block only by one.
  void make_block(uint32_t block);
  bool is_made(uint32_t block) const { return made_[block] == epoch_; }
  // Of a block that is made.
  PosedBlock block(uint32_t block) const;

  uint32_t blocks_made() const;  // in this pose

 private:
  Box root_bounds() const;
  Box block_bounds(uint32_t block) const;
  Box union_below(uint32_t node) const;
  void fill_boxes() const;

  const SvoMotion* motion_ = nullptr;
  Pose pose_;
  uint32_t epoch_ = 0;
  std::vector<uint32_t> made_;  // epoch, one a block
  Buffer<vec3> positions_;      // memory is touched only for blocks that are made
  Buffer<mat3> cofactors_;
  // Of the nodes of levels kBlockLevel and above, once `boxes_state_` is 2 * epoch + 1; while
  // somebody fills them, it is 2 * epoch.
  mutable Buffer<Box> boxes_;
  std::unique_ptr<std::atomic<uint64_t>> boxes_state_;
};

// The skin lattice as a map: where the point at `local` (0..1 along each axis of the cell) goes.
vec3 map_point(const SvoCell& cell, const PosedBlock& block, vec3 local);
// Trilinear mean of the corners' cofactors; identity if there are none.
mat3 map_normals(const SvoCell& cell, const PosedBlock& block, vec3 local);

}  // namespace sinew
