// Voxel objects drawn by the methods of the thesis instead of the skin lattice: `--skinning`.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "sinew/render/voxels/voxel_settings.h"
#include "sinew/svo/thesis/thesis.h"
#include "sinew/svo/thesis/thesis_corners.h"

namespace sinew {

// What it draws from is made of an octree when it is first seen, and kept: octrees must not change.
// Weights come from the skin lattice, see make_thesis_voxels().
class VoxelOpponents {
 public:
  // Draws by any method but the lattice. Returns how many voxels were drawn. Instances must stay as
  // they are while sample() is asked; keys mean nothing to sample_voxel().
  uint64_t draw(VoxelSkinning how, std::span<const VoxelInstance> instances, const RasterView& view,
                float lod, Visibility& out);
  VoxelSample sample(VisibilityKey key) const;

 private:
  VoxelSkinning how_ = VoxelSkinning::thesis;
  std::map<const Svo*, ThesisOctree> octrees_;
  std::map<const Svo*, CornerVoxels> corners_;
  std::vector<ThesisInstance> thesis_instances_;
  std::vector<CornerInstance> corner_instances_;
  ThesisScratch thesis_scratch_;
  CornerScratch corner_scratch_;
};

}  // namespace sinew
