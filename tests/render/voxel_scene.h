// Scenes with balls of voxels.
#pragma once

#include <algorithm>
#include <cmath>

#include "render/test_scene.h"
#include "sinew/svo/make/make_svo.h"

namespace sinew::test {

inline constexpr uint32_t kSide = 96;  // voxels along the ball's diameter

// A hollow ball of radius 1 about the origin; its top is red.
inline Svo voxel_ball(uint32_t material) {
  const float radius = 0.5f * kSide - 1.0f;
  std::vector<PlainVoxel> voxels;
  for (uint32_t z = 0; z < kSide; ++z) {
    for (uint32_t y = 0; y < kSide; ++y) {
      for (uint32_t x = 0; x < kSide; ++x) {
        const vec3 p = vec3(x, y, z) + 0.5f - 0.5f * kSide;
        if (std::abs(length(p) - radius) > 0.8f) continue;
        const vec3 color = p.y > 0.0f ? vec3(0.9f, 0.2f, 0.1f) : vec3(0.2f, 0.4f, 0.9f);
        voxels.push_back({morton_of(uvec3(x, y, z)), pack_normal(p), pack_color(color),
                          static_cast<uint16_t>(material)});
      }
    }
  }
  std::sort(voxels.begin(), voxels.end(),
            [](const PlainVoxel& a, const PlainVoxel& b) { return a.voxel < b.voxel; });
  return *make_svo({vec3(-1.0f), 2.0f / kSide, uvec3(kSide)}, voxels);
}

struct VoxelScene : TestScene {
  VoxelScene() {
    camera = look_at(vec3(1.0f, 2.0f, 6.0f), vec3(0.0f), vec3(0, 1, 0), 0.6f);
    settings.width = settings.height = 128;
    settings.voxels.shadow_map = 256;
    scene.octrees.push_back(voxel_ball(add_material(vec3(1.0f), 0.4f)));
  }
  void place_ball(vec3 at, float scale = 1.0f) {
    Node node;
    node.octree = 0;
    node.translation = at;
    node.scale = vec3(scale);
    scene.nodes.push_back(node);
  }
  // Far behind the camera: nothing but a reason to trace rays.
  void add_unseen_triangle() {
    place(add_mesh({{{0, 0, 90}, {1, 0, 90}, {0, 1, 90}}, {{0, 1, 2}}}, 0));
  }
};

inline double mean_difference(const Image& a, const Image& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const vec4 d = abs(a.pixels[i] - b.pixels[i]);
    sum += d.x + d.y + d.z + d.w;
  }
  return sum / (4.0 * static_cast<double>(a.pixels.size()));
}

}  // namespace sinew::test
