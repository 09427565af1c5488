// Voxel objects of a scene as .vox files have them.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>

#include "sinew/io/vox/vox.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

bool only_moves(const Affine& placement) {
  constexpr float kTolerance = 1e-4f;
  const mat3 away = linear_part(placement) - mat3(1.0f);
  for (int c = 0; c < 3; ++c) {
    if (length(away[c]) > kTolerance) return false;
  }
  return true;
}

}  // namespace

std::vector<PlainVoxel> plain_voxels(const Svo& svo) {
  std::vector<PlainVoxel> voxels;
  voxels.reserve(svo.voxel_count());
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    const uvec3 base = kBlockSide * uvec3(block.x, block.y, block.z);
    VoxelIndex at{block.first_voxel, block.first_brick};
    for (uint32_t c = block.first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      const SvoCell& cell = svo.cells[c];
      const uvec3 corner =
          base + kCellSide * uvec3(cell.place & 7, cell.place >> 3 & 7, cell.place >> 6);
      for (uint32_t slots = cell.bricks; slots != 0; slots &= slots - 1, ++at.brick) {
        const auto slot = static_cast<uint32_t>(std::countr_zero(slots));
        for (uint64_t bits = svo.bricks[at.brick]; bits != 0; bits &= bits - 1, ++at.voxel) {
          const VoxelCode code = 64 * slot + static_cast<uint32_t>(std::countr_zero(bits));
          voxels.push_back({morton_of(corner + place_of(code).min), svo.normals[at.voxel],
                            pack_color(voxel_color(svo, at)), cell.material});
        }
      }
    }
  }
  std::ranges::stable_sort(voxels, {}, &PlainVoxel::voxel);
  const auto same_place = [](const PlainVoxel& a, const PlainVoxel& b) {
    return a.voxel == b.voxel;
  };
  voxels.erase(std::unique(voxels.begin(), voxels.end(), same_place), voxels.end());
  return voxels;
}

std::vector<VoxObject> vox_objects(const Scene& scene, std::vector<std::string>& warnings) {
  ScenePose pose;
  sample(scene, kRestPose, 0.0, pose);
  std::vector<VoxObject> objects;
  for (size_t i = 0; i < scene.voxels.size(); ++i) {
    if (!pose.voxels[i].present) continue;
    const Svo& svo = scene.octrees[scene.voxels[i].octree];
    // A skin's rest pose need not be where the octree was made: there the octree stays.
    const Affine placement =
        scene.voxels[i].skin >= 0 ? identity_affine() : pose.voxels[i].placement;
    VoxObject object;
    object.name = scene.nodes[scene.voxels[i].node].name;
    if (object.name.empty()) object.name = svo.name;
    object.grid = svo.grid;
    object.grid.origin += placement[3];
    object.frames.push_back(plain_voxels(svo));
    if (!only_moves(placement)) {
      warnings.push_back(
          fmt::format("object '{}': is rotated or scaled, which is left out", object.name));
    }
    objects.push_back(std::move(object));
  }
  if (!scene.clips.empty())
    warnings.push_back("the clips are left out: a voxel stays in its place");
  if (!scene.objects.empty()) warnings.push_back("triangle objects are left out");
  return objects;
}

}  // namespace sinew
