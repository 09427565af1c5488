// Triangles with joints and targets for tests of the skin lattice.
#pragma once

#include <string>
#include <vector>

#include "shapes.h"
#include "sinew/math/random.h"
#include "sinew/svo/make/make_svo.h"
#include "sinew/svo/make/voxelize.h"
#include "sinew/svo/posed.h"

namespace sinew::test {

inline uint16_t color_of_triangle(uint32_t triangle) {
  return static_cast<uint16_t>(hash_u32(triangle));
}

struct SkinnedShape {
  Shape shape;
  uint32_t joint_count = 2;
  uint32_t targets = 0;
  std::vector<uint16_t> joints;  // kSvoInfluences a vertex
  std::vector<float> weights;
  std::vector<vec3> deltas;         // target-major
  std::vector<uint16_t> materials;  // one a triangle

  // Every vertex follows one joint.
  void follow(uint32_t vertex, uint16_t joint) {
    joints.resize(kSvoInfluences * shape.positions.size(), 0);
    weights.resize(kSvoInfluences * shape.positions.size(), 0.0f);
    joints[kSvoInfluences * vertex] = joint;
    weights[kSvoInfluences * vertex] = 1.0f;
  }
  // Smooth weights of `count` joints along a direction.
  void follow_along(vec3 direction, uint32_t count) {
    joint_count = count;
    for (uint32_t v = 0; v < shape.positions.size(); ++v) {
      follow(v, 0);
      const float top = static_cast<float>(count - 1);
      const float at = std::clamp(0.5f + 0.5f * dot(direction, shape.positions[v]), 0.0f, 1.0f);
      const uint32_t low = std::min(static_cast<uint32_t>(at * top), count - 2);
      const float fraction = at * top - static_cast<float>(low);
      const size_t first = kSvoInfluences * v;
      joints[first] = static_cast<uint16_t>(low);
      joints[first + 1] = static_cast<uint16_t>(low + 1);
      weights[first] = 1.0f - fraction;
      weights[first + 1] = fraction;
    }
  }
  void add_target(const std::vector<vec3>& of_vertices) {
    deltas.insert(deltas.end(), of_vertices.begin(), of_vertices.end());
    ++targets;
  }

  SkinMotion skin() const {
    return {shape.positions, kSvoInfluences, joints, weights, joint_count};
  }
  Motion motion() const {
    if (targets > 0) return MorphMotion{shape.positions, deltas, skin()};
    return skin();
  }
  Result<VoxelSurface> voxelized(uint32_t resolution, const VoxelizeOptions& options = {}) const {
    const Box box = surface_box(shape.positions, shape.triangles);
    SINEW_TRY(const VoxelGrid grid, grid_of_resolution(box, resolution));
    const auto look = [&](const SurfaceBatch& batch) {
      const uvec3 t = shape.triangles[batch.triangle];
      const vec3 a = shape.positions[t.x];
      const vec3 normal = cross(shape.positions[t.y] - a, shape.positions[t.z] - a);
      std::ranges::fill(batch.normals, pack_normal(normal));
      std::ranges::fill(batch.colors, color_of_triangle(batch.triangle));
      std::ranges::fill(batch.present, uint8_t{1});
    };
    return voxelize(shape.positions, shape.triangles, grid, look, options);
  }
  SvoSource source() {
    materials.resize(shape.triangles.size(), 0);
    return {shape.triangles, materials, motion()};
  }
};

// A rectangle in the plane z = height, of `cells` x `cells` squares.
inline void add_plate(Shape& shape, vec2 low, vec2 high, float height, uint32_t cells) {
  const auto first = static_cast<uint32_t>(shape.positions.size());
  for (uint32_t y = 0; y <= cells; ++y) {
    for (uint32_t x = 0; x <= cells; ++x) {
      const vec2 at = low + (high - low) * vec2(x, y) / static_cast<float>(cells);
      shape.positions.push_back(vec3(at, height));
    }
  }
  for (uint32_t y = 0; y < cells; ++y) {
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = first + x + y * (cells + 1), b = a + cells + 1;
      shape.triangles.push_back({a, a + 1, b});
      shape.triangles.push_back({a + 1, b + 1, b});
    }
  }
}

inline std::vector<Affine> random_joints(uint32_t count, Random& random) {
  std::vector<Affine> joints(count);
  for (Affine& joint : joints) {
    const float angle = random.uniform() < 0.3f ? 3.14159265f : random.uniform(-4.0f, 4.0f);
    const vec3 axis = random.direction();
    const float size =
        random.uniform() < 0.3f ? std::pow(10.0f, random.uniform(-3.0f, 3.0f)) : 1.0f;
    const vec3 along = random.uniform3(0.5f, 1.5f);
    joint = trs(random.uniform3(-2.0f, 2.0f), glm::angleAxis(angle, axis), size * along);
  }
  return joints;
}

}  // namespace sinew::test
