#include "sinew/scene/procedural/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318530718f;
constexpr float kIcosahedronArc = 1.10714871779f;  // angle between neighbouring corners: atan 2

constexpr std::array<std::array<uint32_t, 3>, 20> kFaces{{
    {0, 1, 2},  {0, 2, 3},  {0, 3, 4},  {0, 4, 5},  {0, 5, 1},   {1, 6, 2},   {2, 6, 7},
    {2, 7, 3},  {3, 7, 8},  {3, 8, 4},  {4, 8, 9},  {4, 9, 5},   {5, 9, 10},  {5, 10, 1},
    {1, 10, 6}, {11, 7, 6}, {11, 8, 7}, {11, 9, 8}, {11, 10, 9}, {11, 6, 10},
}};

std::array<vec3, 12> icosahedron_corners() {
  std::array<vec3, 12> corners;
  corners[0] = vec3(0.0f, 1.0f, 0.0f);
  corners[11] = -corners[0];
  const float height = 1.0f / std::sqrt(5.0f), radius = 2.0f / std::sqrt(5.0f);
  for (uint32_t i = 0; i < 5; ++i) {
    const float upper = kTwoPi * static_cast<float>(i) / 5.0f, lower = upper + kTwoPi / 10.0f;
    corners[1 + i] = vec3(radius * std::sin(upper), height, radius * std::cos(upper));
    corners[6 + i] = vec3(radius * std::sin(lower), -height, radius * std::cos(lower));
  }
  return corners;
}

// Numbers the vertices of the divided icosahedron: first the corners, then the inner vertices of
// the 30 edges, then those of the 20 faces.
class GeodesicIndex {
 public:
  explicit GeodesicIndex(uint32_t frequency) : frequency_(frequency) {
    uint32_t edges = 0;
    for (auto& row : edge_) row.fill(0);
    for (const auto& face : kFaces) {
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = face[k], b = face[(k + 1) % 3];
        if (a < b) edge_[a][b] = edges++;
      }
    }
    SINEW_DCHECK(edges == 30);
  }

  // The vertex of face `face` at i steps towards its second and j steps towards its third corner.
  uint32_t operator()(uint32_t face, uint32_t i, uint32_t j) const {
    const uint32_t k = frequency_ - i - j;
    const auto& corner = kFaces[face];
    if (j == 0) return on_edge(corner[0], corner[1], i);
    if (i == 0) return on_edge(corner[0], corner[2], j);
    if (k == 0) return on_edge(corner[1], corner[2], j);
    const uint32_t inner = (frequency_ - 1) * (frequency_ - 2) / 2;
    // Inner vertices row by row of j: row j holds frequency - 1 - j of them.
    const uint32_t before = (j - 1) * (frequency_ - 1) - (j - 1) * j / 2;
    return 12 + 30 * (frequency_ - 1) + face * inner + before + (i - 1);
  }

 private:
  uint32_t on_edge(uint32_t a, uint32_t b, uint32_t step) const {
    if (step == 0) return a;
    if (step == frequency_) return b;
    if (a > b) return on_edge(b, a, frequency_ - step);
    return 12 + edge_[a][b] * (frequency_ - 1) + step - 1;
  }

  uint32_t frequency_;
  std::array<std::array<uint32_t, 12>, 12> edge_;
};

}  // namespace

TriangleSurface geodesic_sphere(uint32_t frequency) {
  SINEW_CHECK(frequency >= 1 && frequency <= 4096);
  const uint32_t f = frequency;
  TriangleSurface sphere;
  sphere.positions.resize(size_t{10} * f * f + 2);
  sphere.triangles.resize(size_t{20} * f * f);
  const std::array<vec3, 12> corners = icosahedron_corners();
  const GeodesicIndex index(f);
  parallel_for(20, 1, [&](size_t face_begin, size_t) {
    const uint32_t face = static_cast<uint32_t>(face_begin);
    size_t next = size_t{face} * f * f;
    for (uint32_t j = 0; j < f; ++j) {
      for (uint32_t i = 0; i + j < f; ++i) {
        sphere.triangles[next++] = {index(face, i, j), index(face, i + 1, j),
                                    index(face, i, j + 1)};
        if (i + j + 1 < f) {
          sphere.triangles[next++] = {index(face, i + 1, j), index(face, i + 1, j + 1),
                                      index(face, i, j + 1)};
        }
      }
    }
  });
  std::vector<float> weight(f + 1);
  for (uint32_t i = 0; i <= f; ++i) {
    weight[i] = std::sin(kIcosahedronArc * static_cast<float>(i) / static_cast<float>(f));
  }
  for (uint32_t face = 0; face < 20; ++face) {
    for (uint32_t j = 0; j <= f; ++j) {
      for (uint32_t i = 0; i + j <= f; ++i) {
        const auto& corner = kFaces[face];
        sphere.positions[index(face, i, j)] =
            normalize(weight[f - i - j] * corners[corner[0]] + weight[i] * corners[corner[1]] +
                      weight[j] * corners[corner[2]]);
      }
    }
  }
  return sphere;
}

TriangleSurface closed_tube(uint32_t around, uint32_t rows,
                            const std::function<vec3(float u, float v)>& point) {
  SINEW_CHECK(around >= 3 && rows >= 1);
  TriangleSurface tube;
  const uint32_t first_pole = around * rows, last_pole = first_pole + 1;
  tube.positions.resize(last_pole + 1);
  tube.positions[first_pole] = point(0.0f, 0.0f);
  tube.positions[last_pole] = point(0.0f, 1.0f);
  parallel_for(rows, 8, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      const float v = static_cast<float>(row + 1) / static_cast<float>(rows + 1);
      for (uint32_t i = 0; i < around; ++i) {
        tube.positions[row * around + i] =
            point(static_cast<float>(i) / static_cast<float>(around), v);
      }
    }
  });
  tube.triangles.reserve(size_t{2} * around * rows);
  for (uint32_t i = 0; i < around; ++i) {
    const uint32_t j = (i + 1) % around;
    tube.triangles.push_back({first_pole, j, i});
    for (uint32_t row = 0; row + 1 < rows; ++row) {
      const uint32_t a = row * around, b = a + around;
      tube.triangles.push_back({a + i, a + j, b + j});
      tube.triangles.push_back({a + i, b + j, b + i});
    }
    const uint32_t a = (rows - 1) * around;
    tube.triangles.push_back({a + i, a + j, last_pole});
  }
  return tube;
}

Mesh make_disc(const DiscConfig& config, uint32_t material) {
  Mesh mesh;
  const uint32_t columns = config.sectors + 1;  // the seam of the texture is doubled
  const auto add_ring = [&](float radius, float height, vec3 (*normal)(float, float), float v) {
    for (uint32_t s = 0; s < columns; ++s) {
      const float turn = static_cast<float>(s) / static_cast<float>(config.sectors);
      const float angle = s == config.sectors ? 0.0f : kTwoPi * turn;
      const float x = std::cos(angle), z = -std::sin(angle);
      mesh.positions.push_back({radius * x, height, radius * z});
      mesh.normals.push_back(normal(x, z));
      mesh.texcoords[0].push_back({config.turns * turn, v});
    }
  };
  const auto upwards = [](float, float) { return vec3(0.0f, 1.0f, 0.0f); };
  const auto outwards = [](float x, float z) { return vec3(x, 0.0f, z); };
  for (uint32_t r = 0; r <= config.rings; ++r) {
    const float radius = config.radius * static_cast<float>(r) / static_cast<float>(config.rings);
    add_ring(radius, 0.0f, upwards, radius / config.ring_height);
  }
  add_ring(config.radius, 0.0f, outwards, config.radius / config.ring_height);
  add_ring(config.radius, -config.rim, outwards, (config.radius + config.rim) / config.ring_height);
  for (uint32_t r = 0; r < config.rings + 2; ++r) {
    if (r == config.rings) continue;  // from the top to the doubled ring of the rim
    for (uint32_t s = 0; s < config.sectors; ++s) {
      const uint32_t a = r * columns + s, b = a + columns;
      if (r > 0) mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  mesh.parts.push_back({material, false});
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

Mesh make_box(vec3 low, vec3 high, bool inward, uint32_t material) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      const uint32_t first = static_cast<uint32_t>(mesh.positions.size());
      vec3 normal(0.0f);
      normal[axis] = (side == 1) != inward ? 1.0f : -1.0f;
      for (int k = 0; k < 4; ++k) {
        vec3 p;
        p[axis] = side == 1 ? high[axis] : low[axis];
        p[b] = k == 1 || k == 2 ? high[b] : low[b];
        p[c] = k >= 2 ? high[c] : low[c];
        mesh.positions.push_back(p);
        mesh.normals.push_back(normal);
        // Metres, so that patterns keep their size; vertical sides run upwards.
        mesh.texcoords[0].push_back(axis == 1 ? vec2(p.x, p.z) : vec2(p[axis == 0 ? 2 : 0], -p.y));
      }
      const bool forward = (side == 1) != inward;
      const uvec3 even = forward ? uvec3(0, 1, 2) : uvec3(0, 2, 1);
      const uvec3 odd = forward ? uvec3(0, 2, 3) : uvec3(0, 3, 2);
      mesh.triangles.push_back(first + even);
      mesh.triangles.push_back(first + odd);
    }
  }
  mesh.parts.push_back({material, false});
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

std::vector<vec3> vertex_normals(std::span<const vec3> positions,
                                 std::span<const uvec3> triangles) {
  std::vector<vec3> normals(positions.size(), vec3(0.0f));
  for (const uvec3 t : triangles) {
    const vec3 n = cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
    normals[t.x] += n;
    normals[t.y] += n;
    normals[t.z] += n;
  }
  for (vec3& n : normals) {
    const float length_squared = dot(n, n);
    n = length_squared > 0.0f ? n / std::sqrt(length_squared) : vec3(0.0f, 1.0f, 0.0f);
  }
  return normals;
}

std::vector<uint32_t> opposite_half_edges(std::span<const uvec3> triangles) {
  struct Entry {
    uint64_t edge;  // the lesser and the greater vertex
    uint32_t half_edge;
  };
  std::vector<Entry> entries(3 * triangles.size());
  const auto from = [&](uint32_t h) { return triangles[h / 3][static_cast<int>(h % 3)]; };
  const auto to = [&](uint32_t h) { return triangles[h / 3][static_cast<int>((h + 1) % 3)]; };
  for (uint32_t h = 0; h < entries.size(); ++h) {
    const uint64_t a = std::min(from(h), to(h)), b = std::max(from(h), to(h));
    entries[h] = {a << 32 | b, h};
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.half_edge < b.half_edge;
  });
  std::vector<uint32_t> opposite(entries.size(), kNoHalfEdge);
  for (size_t i = 0; i < entries.size();) {
    size_t end = i + 1;
    while (end < entries.size() && entries[end].edge == entries[i].edge) ++end;
    const uint32_t a = entries[i].half_edge, b = entries[end - 1].half_edge;
    if (end - i == 2 && from(a) == to(b)) {
      opposite[a] = b;
      opposite[b] = a;
    }
    i = end;
  }
  return opposite;
}

Mesh single_part_mesh(TriangleSurface surface, uint32_t material) {
  Mesh mesh;
  mesh.positions = std::move(surface.positions);
  mesh.triangles = std::move(surface.triangles);
  mesh.parts.push_back({material, false});
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace sinew
