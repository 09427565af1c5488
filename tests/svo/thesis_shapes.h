// Voxels, joints and views for the tests of the thesis's methods.
#pragma once

#include <algorithm>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/svo/draw/visibility.h"
#include "sinew/svo/thesis/thesis_voxels.h"

namespace sinew::test {

// Perspective, along -Z from (0, 0, distance), at the origin's unit cube.
inline RasterView make_view(float distance, float focal, uint32_t width, uint32_t height) {
  RasterView view;
  view.depth = vec4(0.0f, 0.0f, -1.0f, distance);
  view.w = view.depth;
  view.x = vec4(focal, 0.0f, 0.0f, 0.0f) + 0.5f * static_cast<float>(width) * view.w;
  view.y = vec4(0.0f, -focal, 0.0f, 0.0f) + 0.5f * static_cast<float>(height) * view.w;
  view.near = 0.01f;
  view.width = width;
  view.height = height;
  return view;
}

inline ThesisWeights random_weights(Random& random, uint32_t joints) {
  ThesisMix mix;
  mix.clear();
  const uint32_t count = 1 + random.next() % kSvoInfluences;
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t joint = random.next() % joints;
    const float weight = random.uniform(0.1f, 1.0f);
    mix.add(joint, weight);
  }
  return mix.mean();
}

// A grid over [-0.5, 0.5]^3 and random places in it, in Morton order, each once.
inline VoxelGrid unit_grid(uint32_t side) {
  return {vec3(-0.5f), 1.0f / static_cast<float>(side), uvec3(side)};
}
inline std::vector<ThesisVoxel> random_voxels(Random& random, uint32_t side, size_t count,
                                              uint32_t joints) {
  std::vector<VoxelMorton> places;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t x = random.next() % side, y = random.next() % side, z = random.next() % side;
    places.push_back(morton_of(uvec3(x, y, z)));
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  std::vector<ThesisVoxel> out;
  for (const VoxelMorton place : places) {
    ThesisVoxel& voxel = out.emplace_back();
    voxel.voxel = place;
    if (joints > 0) voxel.skin = random_weights(random, joints);
    voxel.normal = pack_normal(random.uniform3(-1.0f, 1.0f));
    voxel.color = pack_color(random.uniform3(0.0f, 1.0f));
    voxel.material = static_cast<uint16_t>(random.next() % 3);
  }
  return out;
}

inline std::vector<Affine> random_joints(Random& random, uint32_t count) {
  std::vector<Affine> out;
  for (uint32_t j = 0; j < count; ++j) {
    const vec3 axis = normalize(random.uniform3(-1.0f, 1.0f) + vec3(1e-3f));
    const float angle = random.uniform(-1.0f, 1.0f);
    const vec3 translation = random.uniform3(-0.2f, 0.2f);
    const vec3 scale = random.uniform3(0.7f, 1.5f);
    out.push_back(trs(translation, glm::angleAxis(angle, axis), scale));
  }
  return out;
}

}  // namespace sinew::test
