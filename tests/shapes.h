// Small meshes for tests.
#pragma once

#include <cmath>
#include <map>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/math/vec.h"

namespace sinew::test {

struct Shape {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
};

// Separate triangles scattered in the unit cube.
inline Shape random_triangles(size_t count, uint32_t seed, float size = 0.1f) {
  Shape shape;
  Random random(seed);
  for (size_t i = 0; i < count; ++i) {
    const vec3 center = random.uniform3(0.0f, 1.0f);
    const auto first = static_cast<uint32_t>(shape.positions.size());
    for (int k = 0; k < 3; ++k) {
      shape.positions.push_back(center + random.uniform3(-size, size));
    }
    shape.triangles.push_back({first, first + 1, first + 2});
  }
  return shape;
}

// Closed unit sphere: an octahedron whose triangles are split `levels` times.
inline Shape sphere(int levels) {
  Shape s;
  s.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  s.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto key = std::minmax(a, b);
      const auto [place, is_new] = middles.try_emplace(key, s.positions.size());
      if (is_new) s.positions.push_back(normalize(s.positions[a] + s.positions[b]));
      return place->second;
    };
    std::vector<uvec3> finer;
    for (const uvec3 t : s.triangles) {
      const uint32_t a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
      finer.insert(finer.end(), {{t.x, a, c}, {a, t.y, b}, {c, b, t.z}, {a, b, c}});
    }
    s.triangles = std::move(finer);
  }
  return s;
}

// Twists and bends around the z axis: neighbours stay neighbours, boxes do not.
inline std::vector<vec3> twisted(const std::vector<vec3>& positions, float amount) {
  std::vector<vec3> out = positions;
  for (vec3& p : out) {
    const float angle = amount * p.z, c = std::cos(angle), s = std::sin(angle);
    p = vec3(c * p.x - s * p.y + 0.3f * amount * p.z * p.z, s * p.x + c * p.y, p.z);
  }
  return out;
}

}  // namespace sinew::test
