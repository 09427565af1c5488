#include "sinew/scene/procedural/implicit_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr int kBlock = 4;  // cubes along the edge of a block, the unit of skipping

using ivec3 = glm::ivec3;

// Lattice points have integer coordinates in half cells: all even at the corners of cubes, all odd
// at their centres.
struct Lattice {
  vec3 origin{0.0f};
  float half_cell = 0.5f;
  ivec3 blocks{0};

  vec3 position(ivec3 point) const { return origin + half_cell * vec3(point); }
};

struct LatticePoint {
  ivec3 at{0};
  float value = 0.0f;
};

// A crossing of the surface with a lattice edge; the key is the sum of the edge's end points, which
// no two edges share.
struct Crossing {
  uint64_t key = 0;
  vec3 position{0.0f};
};

Crossing crossing(const Lattice& lattice, const LatticePoint& a, const LatticePoint& b) {
  const ivec3 sum = a.at + b.at;
  const uint64_t key = static_cast<uint64_t>(sum.x) << 42 | static_cast<uint64_t>(sum.y) << 21 |
                       static_cast<uint64_t>(sum.z);
  const bool forward = a.value < b.value;  // the same order from every tetrahedron
  const LatticePoint& in = forward ? a : b;
  const LatticePoint& out = forward ? b : a;
  const float t = std::clamp(in.value / (in.value - out.value), 0.3f, 0.7f);
  const vec3 p = lattice.position(in.at);
  return {key, p + t * (lattice.position(out.at) - p)};
}

// Appends the triangles of one positively oriented tetrahedron, three crossings each.
void march(const Lattice& lattice, const std::array<LatticePoint, 4>& v,
           std::vector<Crossing>& out) {
  // Even permutations that bring the vertices in question to the front.
  constexpr int kFirst[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
  constexpr int kPair[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                               {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};
  int inside = 0;
  for (int i = 0; i < 4; ++i) inside |= (v[i].value < 0.0f) << i;
  if (inside == 0 || inside == 15) return;
  const auto cut = [&](int a, int b) { return crossing(lattice, v[a], v[b]); };
  for (int i = 0; i < 4; ++i) {
    const auto& k = kFirst[i];
    if (inside == 1 << i) {
      out.insert(out.end(), {cut(k[0], k[1]), cut(k[0], k[2]), cut(k[0], k[3])});
    } else if (inside == (15 & ~(1 << i))) {
      out.insert(out.end(), {cut(k[0], k[1]), cut(k[0], k[3]), cut(k[0], k[2])});
    }
  }
  for (const auto& k : kPair) {
    if (inside != (1 << k[0] | 1 << k[1])) continue;
    const Crossing ac = cut(k[0], k[2]), ad = cut(k[0], k[3]);
    const Crossing bd = cut(k[1], k[3]), bc = cut(k[1], k[2]);
    out.insert(out.end(), {ac, ad, bd, ac, bd, bc});
  }
}

// Marches the tetrahedra of one block: four around every edge between the centres of neighbouring
// cubes, owned by the lesser cube.
void march_block(const Field& field, const Lattice& lattice, ivec3 block,
                 std::vector<Crossing>& out) {
  constexpr int kSide = kBlock + 1;
  const ivec3 base = 2 * kBlock * block;
  std::array<LatticePoint, kSide * kSide * kSide> corners, centers;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const ivec3 cell(i % kSide, i / kSide % kSide, i / kSide / kSide);
    const ivec3 at = base + 2 * cell;
    corners[i] = {at, field(lattice.position(at))};
    centers[i] = {at + 1, field(lattice.position(at + 1))};
  }
  const auto index = [](ivec3 c) { return c.x + kSide * (c.y + kSide * c.z); };
  for (int i = 0; i < kBlock * kBlock * kBlock; ++i) {
    const ivec3 cell(i % kBlock, i / kBlock % kBlock, i / kBlock / kBlock);
    for (int axis = 0; axis < 3; ++axis) {
      ivec3 d(0), e(0), f(0);
      d[axis] = 1;
      e[(axis + 1) % 3] = 1;
      f[(axis + 2) % 3] = 1;
      const ivec3 face = cell + d;
      const std::array<ivec3, 4> ring{face, face + e, face + e + f, face + f};
      for (int k = 0; k < 4; ++k) {
        march(lattice,
              {centers[index(cell)], centers[index(face)], corners[index(ring[k])],
               corners[index(ring[(k + 1) % 4])]},
              out);
      }
    }
  }
}

Lattice make_lattice(const ImplicitMeshConfig& config) {
  const float block = static_cast<float>(kBlock) * config.cell;
  const vec3 size = config.box.extent() + 2.0f * config.cell;
  return {config.box.min - config.cell, 0.5f * config.cell, ivec3(glm::ceil(size / block))};
}

// All crossings, three a triangle, in the order of the blocks.
std::vector<Crossing> find_crossings(const Field& field, const ImplicitMeshConfig& config) {
  const Lattice lattice = make_lattice(config);
  const size_t count = size_t{1} * lattice.blocks.x * lattice.blocks.y * lattice.blocks.z;
  constexpr size_t kGrain = 64;
  std::vector<std::vector<Crossing>> chunks((count + kGrain - 1) / kGrain);
  parallel_for(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const int n = static_cast<int>(i), nx = lattice.blocks.x, ny = lattice.blocks.y;
      const ivec3 block(n % nx, n / nx % ny, n / nx / ny);
      // A block reaches half a cell beyond its cubes. The field is nearly a distance: 1.3 is slack.
      const vec3 middle = lattice.position(2 * kBlock * block) +
                          (static_cast<float>(kBlock) + 0.5f) * lattice.half_cell;
      const float radius = 1.7320508f * (static_cast<float>(kBlock) + 0.5f) * lattice.half_cell;
      if (std::abs(field(middle)) > 1.3f * radius) continue;
      march_block(field, lattice, block, chunks[begin / kGrain]);
    }
  });
  std::vector<Crossing> all;
  for (const std::vector<Crossing>& chunk : chunks)
    all.insert(all.end(), chunk.begin(), chunk.end());
  return all;
}

// Crossings of the same edge become one vertex; vertices are ordered by key.
TriangleSurface weld(const std::vector<Crossing>& crossings) {
  std::vector<uint32_t> order(crossings.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const uint64_t ka = crossings[a].key, kb = crossings[b].key;
    return ka != kb ? ka < kb : a < b;
  });
  TriangleSurface surface;
  surface.triangles.resize(crossings.size() / 3);
  for (size_t i = 0; i < order.size(); ++i) {
    const Crossing& c = crossings[order[i]];
    if (i == 0 || c.key != crossings[order[i - 1]].key) surface.positions.push_back(c.position);
    surface.triangles[order[i] / 3][static_cast<int>(order[i] % 3)] =
        static_cast<uint32_t>(surface.positions.size() - 1);
  }
  return surface;
}

// Central over the corners of a tetrahedron: four evaluations.
vec3 gradient(const Field& field, vec3 p, float step) {
  const vec3 a(1.0f, -1.0f, -1.0f), b(-1.0f, -1.0f, 1.0f), c(-1.0f, 1.0f, -1.0f), d(1.0f);
  return (a * field(p + step * a) + b * field(p + step * b) + c * field(p + step * c) +
          d * field(p + step * d)) /
         (4.0f * step);
}

// Moves each vertex towards the middle of its neighbours, along the surface.
void spread(TriangleSurface& surface, const std::vector<vec3>& normals) {
  std::vector<vec4> sums(surface.positions.size(), vec4(0.0f));  // w counts
  for (const uvec3 t : surface.triangles) {
    const vec3 sum = surface.positions[t.x] + surface.positions[t.y] + surface.positions[t.z];
    for (int k = 0; k < 3; ++k) sums[t[k]] += vec4(sum - surface.positions[t[k]], 2.0f);
  }
  for (size_t v = 0; v < sums.size(); ++v) {
    const vec3 shift = 0.6f * (vec3(sums[v]) / sums[v].w - surface.positions[v]);
    surface.positions[v] += shift - dot(shift, normals[v]) * normals[v];
  }
}

// One Newton step to the surface for every vertex; leaves the normals there.
void project(const Field& field, float cell, TriangleSurface& surface, std::vector<vec3>& normals) {
  parallel_for(surface.positions.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      vec3& p = surface.positions[v];
      const vec3 g = gradient(field, p, std::max(0.05f * cell, 4e-4f));
      const float squared = std::max(dot(g, g), 1e-6f);
      const float step = std::clamp(field(p) / std::sqrt(squared), -0.5f * cell, 0.5f * cell);
      normals[v] = g / std::sqrt(squared);
      p -= step * normals[v];
    }
  });
}

}  // namespace

ImplicitMesh mesh_implicit(const Field& field, const ImplicitMeshConfig& config) {
  SINEW_CHECK(config.cell > 0.0f && !config.box.empty());
  SINEW_CHECK(glm::all(glm::lessThan(config.box.extent() / config.cell, vec3(2e5f))));
  ImplicitMesh mesh;
  mesh.surface = weld(find_crossings(field, config));
  mesh.normals.resize(mesh.surface.positions.size());
  project(field, config.cell, mesh.surface, mesh.normals);
  for (uint32_t i = 0; i < config.smoothing; ++i) {
    spread(mesh.surface, mesh.normals);
    project(field, config.cell, mesh.surface, mesh.normals);
  }
  project(field, config.cell, mesh.surface, mesh.normals);
  return mesh;
}

float cell_for_triangles(const Field& field, const Box& box, uint32_t triangles) {
  const vec3 size = box.extent();
  const float trial = std::max({size.x, size.y, size.z}) / 64.0f;
  const size_t found = find_crossings(field, {box, trial, 0}).size() / 3;
  return trial * std::sqrt(static_cast<float>(found) / static_cast<float>(triangles));
}

}  // namespace sinew
