#include "sinew/scene/voxel_bounds.h"

#include <algorithm>
#include <bit>

#include "sinew/base/parallel.h"

namespace sinew {

VoxelBounds::VoxelBounds(const Scene& scene) : scene_(scene), octrees_(scene.octrees.size()) {
  for (const SceneVoxels& object : scene.voxels) {
    const Svo& svo = scene.octrees[object.octree];
    Octree& octree = octrees_[object.octree];
    if (!octree.extents.empty() || svo.block_count() == 0) continue;
    octree.motion = make_svo_motion(svo);
    octree.extents.resize(svo.cells.size());
    for (uint32_t b = 0; b < svo.block_count(); ++b) {
      for (uint32_t c = svo.blocks[b].first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
        octree.extents[c] = extent_of(svo, svo.blocks[b], svo.cells[c]);
      }
    }
  }
}

VoxelBounds::Extent VoxelBounds::extent_of(const Svo& svo, const SvoBlock& block,
                                           const SvoCell& cell) {
  Extent extent{{8, 8, 8}, {0, 0, 0}};
  const uint64_t* brick = &svo.bricks[block.first_brick + cell.first_brick];
  constexpr uint64_t kAll = ~uint64_t{0};
  for (uint32_t slots = cell.bricks; slots != 0; slots &= slots - 1) {
    const auto slot = static_cast<uint32_t>(std::countr_zero(slots));
    const uint64_t voxels = *brick++;
    for (uint64_t bits = svo.paging ? kAll : voxels; bits != 0; bits &= bits - 1) {
      const uvec3 at = place_of(64 * slot + static_cast<uint32_t>(std::countr_zero(bits))).min;
      for (int k = 0; k < 3; ++k) {
        uint8_t &low = extent.low[static_cast<size_t>(k)],
                &high = extent.high[static_cast<size_t>(k)];
        low = std::min(low, static_cast<uint8_t>(at[k]));
        high = std::max(high, static_cast<uint8_t>(at[k] + 1));
      }
    }
  }
  return extent;
}

Box VoxelBounds::box_of(const Octree& octree, uint32_t block, const Affine& placement) {
  const Svo& svo = octree.posed.svo();
  const PosedBlock posed = octree.posed.block(block);
  Box box;
  for (uint32_t c = svo.blocks[block].first_cell; c < svo.blocks[block + 1].first_cell; ++c) {
    const Extent& extent = octree.extents[c];
    for (uint32_t corner = 0; corner < 8; ++corner) {
      vec3 local;
      for (int k = 0; k < 3; ++k) {
        const auto& side = corner >> k & 1 ? extent.high : extent.low;
        local[k] = static_cast<float>(side[static_cast<size_t>(k)]) / kCellSide;
      }
      box.extend(transform_point(placement, map_point(svo.cells[c], posed, local)));
    }
  }
  return box;
}

Box VoxelBounds::at(const ScenePose& pose) {
  Box all;
  for (size_t i = 0; i < scene_.voxels.size(); ++i) {
    Octree& octree = octrees_[scene_.voxels[i].octree];
    const Pose& own = pose.voxels[i];
    if (octree.extents.empty() || !own.present || !pose_fits(*octree.motion.svo, own)) continue;
    octree.posed.set_pose(octree.motion, own);
    std::vector<Box> boxes(octree.posed.svo().block_count());
    parallel_for(boxes.size(), 1, [&](size_t begin, size_t end) {
      for (size_t b = begin; b < end; ++b) {
        octree.posed.make_block(static_cast<uint32_t>(b));
        boxes[b] = box_of(octree, static_cast<uint32_t>(b), own.placement);
      }
    });
    for (const Box& box : boxes) all.extend(box);
  }
  return all;
}

}  // namespace sinew
