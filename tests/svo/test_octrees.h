// Small octrees for the tests of files: plain ones, and a skinned and morphed one.
#pragma once

#include <vector>

#include "sinew/math/random.h"
#include "sinew/svo/corners.h"
#include "sinew/svo/levels.h"
#include "sinew/svo/make/make_svo.h"
#include "svo/svo_oracle.h"

namespace sinew::test {

inline Svo plain_octree(uint32_t resolution, size_t voxels, uint32_t materials, uint32_t seed) {
  const VoxelGrid grid{vec3(-1.0f, 0.5f, 2.0f), 0.125f, uvec3(resolution)};
  Svo svo = *make_svo(grid, random_voxels(resolution, voxels, materials, seed));
  svo.name = "plain";
  return svo;
}

// Two ends of colours a brick instead of one colour a voxel.
inline void set_color_ends(Svo& svo, uint32_t seed) {
  Random random(seed);
  svo.color_ends.resize(svo.bricks.size());
  svo.color_selectors.resize((svo.colors.size() + 15) / 16);
  for (SvoColorEnds& ends : svo.color_ends) {
    ends.a = static_cast<uint16_t>(random.next());
    ends.b = static_cast<uint16_t>(random.next());
  }
  for (size_t i = 0; i < svo.colors.size(); ++i) {
    svo.color_selectors[i / 16] |= random.next() % 4 << (2 * (i % 16));
  }
  svo.colors.clear();
  for (uint32_t block = 0; block < svo.block_count(); ++block) filter_levels(svo, block);
}

// The same with joints, two morph targets and ends of colours. Corners at one place move alike,
// whatever the block.
inline Svo moving_octree(uint32_t resolution, size_t voxels, uint32_t seed) {
  constexpr uint32_t kJoints = 5;
  Svo svo = plain_octree(resolution, voxels, 2, seed);
  svo.name = "moving";
  svo.joints = kJoints;
  svo.morph_targets = 2;
  svo.morph_weights = {0.25f, 0.0f};
  set_color_ends(svo, seed);
  svo.joint_palette.clear();
  svo.targets.clear();
  svo.deltas.clear();
  const float unit = 0.001f;
  for (uint32_t b = 0; b + 1 < svo.blocks.size(); ++b) {
    SvoBlock& block = svo.blocks[b];
    block.first_joint = static_cast<uint32_t>(svo.joint_palette.size());
    block.first_target = static_cast<uint32_t>(svo.targets.size());
    for (uint16_t joint = 0; joint < kJoints; ++joint) svo.joint_palette.push_back(joint);
    const uint32_t target = b % 2;
    svo.targets.push_back({target, unit, static_cast<uint32_t>(svo.deltas.size())});
    for (uint32_t i = block.first_corner; i < svo.blocks[b + 1].first_corner; ++i) {
      const vec3 p = corner_rest(svo.grid, block, svo.corner_places[i]);
      const uint32_t at = hash_u32(
          static_cast<uint32_t>(static_cast<int32_t>(16.0f * (p.x + 3.0f * p.y + 9.0f * p.z))));
      const auto first = static_cast<uint16_t>(30000 + at % 20000);
      const auto second = static_cast<uint16_t>((65535 - first) / 2);
      svo.corner_joints.push_back(
          {static_cast<uint8_t>(at % 2), static_cast<uint8_t>(2 + at % 3), 0, 0});
      svo.corner_joints.back()[2] = static_cast<uint8_t>(1 - at % 2);
      svo.corner_weights.push_back(
          {first, second, static_cast<uint16_t>(65535 - first - second), 0});
      svo.deltas.push_back({static_cast<int16_t>(at & 511),
                            static_cast<int16_t>(-static_cast<int>(at >> 9 & 511)), 7});
    }
  }
  svo.blocks.back().first_joint = static_cast<uint32_t>(svo.joint_palette.size());
  svo.blocks.back().first_target = static_cast<uint32_t>(svo.targets.size());
  return svo;
}

}  // namespace sinew::test
