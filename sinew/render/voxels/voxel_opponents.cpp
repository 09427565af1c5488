#include "sinew/render/voxels/voxel_opponents.h"

namespace sinew {

uint64_t VoxelOpponents::draw(VoxelSkinning how, std::span<const VoxelInstance> instances,
                              const RasterView& view, float lod, Visibility& out) {
  how_ = how;
  thesis_instances_.clear();
  corner_instances_.clear();
  uint32_t first_unit = 0;
  for (const VoxelInstance& instance : instances) {
    const Svo& svo = instance.posed->svo();
    const std::span<const Affine> joints = instance.posed->pose().joints;
    if (how == VoxelSkinning::thesis) {
      auto found = octrees_.find(&svo);
      if (found == octrees_.end()) {
        const std::vector<ThesisVoxel> voxels = make_thesis_voxels(svo);
        found = octrees_.emplace(&svo, make_thesis_octree(svo.grid, voxels, svo.joints)).first;
      }
      thesis_instances_.push_back({&found->second, joints, instance.placement, first_unit});
      first_unit += unit_count(found->second);
    } else {
      auto found = corners_.find(&svo);
      if (found == corners_.end()) {
        found =
            corners_
                .emplace(&svo, make_corner_voxels(svo.grid, make_thesis_voxels(svo), svo.joints))
                .first;
      }
      corner_instances_.push_back({&found->second, joints, instance.placement, first_unit});
      first_unit += unit_count(found->second);
    }
  }
  if (how == VoxelSkinning::corners) {
    return rasterize_corners(corner_instances_, view, corner_scratch_, out);
  }
  const ThesisSettings settings{.pixel = lod, .lod = lod > 0.0f};
  return rasterize_thesis(thesis_instances_, view, settings, thesis_scratch_, out).drawn;
}

VoxelSample VoxelOpponents::sample(VisibilityKey key) const {
  return how_ == VoxelSkinning::corners ? sample_corners(corner_instances_, key)
                                        : sample_thesis(thesis_instances_, key);
}

}  // namespace sinew
