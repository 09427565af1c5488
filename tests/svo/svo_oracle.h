// What an octree holds, read back the slow way.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/svo/format.h"
#include "sinew/svo/make/fragments.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew::test {

// One voxel of one copy of a cell.
struct ReadVoxel {
  uvec3 voxel{0};
  uint32_t cell = 0;
  uint32_t block = 0;
  VoxelCode code = 0;
  uint16_t normal = 0, color = 0, material = 0;
};

inline uvec3 cell_min(const SvoBlock& block, const SvoCell& cell) {
  const uvec3 place(cell.place & 7, cell.place >> 3 & 7, cell.place >> 6);
  return kBlockSide * uvec3(block.x, block.y, block.z) + kCellSide * place;
}

inline std::vector<ReadVoxel> read_voxels(const Svo& svo) {
  std::vector<ReadVoxel> out;
  for (uint32_t b = 0; b < svo.block_count(); ++b) {
    const SvoBlock& block = svo.blocks[b];
    for (uint32_t c = block.first_cell; c < svo.blocks[b + 1].first_cell; ++c) {
      const SvoCell& cell = svo.cells[c];
      uint32_t brick = block.first_brick + cell.first_brick;
      for (uint32_t i = 0; i < 8; ++i) {
        if (!(cell.bricks >> i & 1)) continue;
        for (uint32_t bit = 0; bit < 64; ++bit) {
          if (!(svo.bricks[brick] >> bit & 1)) continue;
          const VoxelCode code = 64 * i + bit;
          const VoxelIndex at = voxel_index(svo, block, cell, code);
          out.push_back({cell_min(block, cell) + place_of(code).min, c, b, code,
                         svo.normals[at.voxel], pack_color(voxel_color(svo, at)), cell.material});
        }
        ++brick;
      }
    }
  }
  return out;
}

// Sorted, each place once: a rough ball shell and some single voxels.
inline std::vector<PlainVoxel> random_voxels(uint32_t resolution, size_t count, uint32_t materials,
                                             uint32_t seed) {
  Random random(seed);
  std::map<VoxelMorton, PlainVoxel> voxels;
  const float half = 0.5f * static_cast<float>(resolution);
  for (size_t i = 0; i < count; ++i) {
    const float radius = half * (i % 16 == 0 ? random.uniform(0.0f, 1.0f) : 0.8f);
    const vec3 direction = random.direction();
    const uvec3 v = glm::min(uvec3(vec3(half) + radius * direction), uvec3(resolution - 1));
    const auto color = static_cast<uint16_t>(random.next());
    const auto material = static_cast<uint16_t>(random.next() % materials);
    voxels[morton_of(v)] = {morton_of(v), pack_normal(direction), color, material};
  }
  std::vector<PlainVoxel> out;
  for (const auto& [morton, voxel] : voxels) out.push_back(voxel);
  return out;
}

}  // namespace sinew::test
