#include "sinew/svo/voxel_at.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/svo/corners.h"

namespace sinew {
namespace {

// The middle of the voxel in its cell, 0 to 1 along each axis.
vec3 middle_in_cell(VoxelCode code) {
  const VoxelPlace place = place_of(code);
  return (vec3(place.min) + 0.5f * static_cast<float>(place.side)) / static_cast<float>(kCellSide);
}

void add(uint32_t joint, float weight, std::vector<JointWeight>& to) {
  const auto same = std::ranges::find(to, joint, &JointWeight::joint);
  if (same == to.end()) {
    to.push_back({joint, weight});
  } else {
    same->weight += weight;
  }
}

}  // namespace

uint32_t block_of(const Svo& svo, uint32_t cell) {
  SINEW_CHECK(cell < svo.cells.size());
  const auto after =
      std::upper_bound(svo.blocks.begin(), svo.blocks.end(), cell,
                       [](uint32_t c, const SvoBlock& block) { return c < block.first_cell; });
  return static_cast<uint32_t>(after - svo.blocks.begin()) - 1;
}

RestVoxel rest_voxel(const Svo& svo, uint32_t cell, VoxelCode code) {
  const SvoBlock& block = svo.blocks[block_of(svo, cell)];
  const uint32_t at = svo.cells[cell].place;
  const VoxelPlace place = place_of(code);
  RestVoxel out;
  out.place = kBlockSide * uvec3(block.x, block.y, block.z) +
              kCellSide * uvec3(at & 7, at >> 3 & 7, at >> 6) + place.min;
  out.side = place.side;
  out.middle =
      svo.grid.origin + svo.grid.voxel * (vec3(out.place) + 0.5f * static_cast<float>(place.side));
  return out;
}

std::vector<JointWeight> joint_weights(const Svo& svo, uint32_t cell, VoxelCode code) {
  std::vector<JointWeight> out;
  if (svo.joints == 0) return out;
  const SvoBlock& block = svo.blocks[block_of(svo, cell)];
  const vec3 local = middle_in_cell(code);
  for (uint32_t k = 0; k < 8; ++k) {
    const vec3 share((k & 1) != 0 ? local.x : 1.0f - local.x,
                     (k & 2) != 0 ? local.y : 1.0f - local.y,
                     (k & 4) != 0 ? local.z : 1.0f - local.z);
    const float corner_share = share.x * share.y * share.z;
    const size_t corner = block.first_corner + svo.cells[cell].corner[k];
    for (uint32_t i = 0; i < kSvoInfluences; ++i) {
      const float weight = corner_share * corner_weight(svo.corner_weights[corner][i]);
      if (!(weight > 0.0f)) continue;
      add(svo.joint_palette[block.first_joint + svo.corner_joints[corner][i]], weight, out);
    }
  }
  std::ranges::sort(out, [](const JointWeight& a, const JointWeight& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  return out;
}

}  // namespace sinew
