// Cuts an egg-shaped shell into closed pieces: every triangle of a geodesic grid goes to the
// nearest of some scattered seeds (a Voronoi diagram on the sphere, its borders roughened by
// noise); a piece is its outer triangles, the inner ones beneath them, and walls between the two.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/scene/procedural/fracture.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew {
namespace {

constexpr float kThickness = 0.09f;  // of the shell, as a share of its size
constexpr float kEggRadius = 0.55f;  // metres

// The surface of the egg in direction d of the unit sphere; its lowest point is the origin.
vec3 egg_point(vec3 d, float scale) {
  const float taper = 1.0f - 0.16f * d.y - 0.05f * d.y * d.y;
  const vec3 p = kEggRadius * vec3(d.x * taper, 1.32f * d.y, d.z * taper);
  return scale * p + vec3(0.0f, 1.32f * kEggRadius, 0.0f);
}

// The undivided grid, with the piece of each triangle.
struct CutSphere {
  TriangleSurface sphere;
  std::vector<uint32_t> opposite;  // half-edges
  std::vector<uint32_t> piece;     // one a triangle
  uint32_t border_edges = 0;       // half-edges between different pieces

  bool is_border(uint32_t half_edge) const {
    return piece[half_edge / 3] != piece[opposite[half_edge] / 3];
  }
};

std::vector<vec3> scatter_seeds(uint32_t pieces) {
  Random random(2003);
  std::vector<vec3> seeds(pieces);
  const float stray = 0.9f / std::sqrt(static_cast<float>(pieces));
  for (uint32_t i = 0; i < pieces; ++i) {
    const float y = 1.0f - 2.0f * (static_cast<float>(i) + 0.5f) / static_cast<float>(pieces);
    const float r = std::sqrt(1.0f - y * y), angle = 2.39996323f * static_cast<float>(i);
    seeds[i] = normalize(vec3(r * std::cos(angle), y, r * std::sin(angle)) +
                         stray * random.uniform3(-1.0f, 1.0f));
  }
  return seeds;
}

// The connected triangles of one piece each.
std::vector<std::vector<uint32_t>> find_fragments(const CutSphere& cut) {
  std::vector<uint8_t> found(cut.piece.size(), 0);
  std::vector<std::vector<uint32_t>> fragments;
  for (uint32_t seed = 0; seed < found.size(); ++seed) {
    if (found[seed]) continue;
    std::vector<uint32_t> members{seed};
    found[seed] = 1;
    for (size_t i = 0; i < members.size(); ++i) {
      for (uint32_t h = 3 * members[i]; h < 3 * members[i] + 3; ++h) {
        const uint32_t neighbour = cut.opposite[h] / 3;
        if (cut.is_border(h) || found[neighbour]) continue;
        found[neighbour] = 1;
        members.push_back(neighbour);
      }
    }
    fragments.push_back(std::move(members));
  }
  return fragments;
}

// Gives every fragment of a piece but its largest to a piece beside it, until pieces are in one.
void join_fragments(CutSphere& cut, size_t pieces) {
  for (int pass = 0; pass < 8; ++pass) {
    const std::vector<std::vector<uint32_t>> fragments = find_fragments(cut);
    std::vector<size_t> largest(pieces, 0);  // triangles, by piece
    for (const std::vector<uint32_t>& f : fragments) {
      largest[cut.piece[f[0]]] = std::max(largest[cut.piece[f[0]]], f.size());
    }
    bool changed = false;
    for (const std::vector<uint32_t>& f : fragments) {
      const uint32_t piece = cut.piece[f[0]];
      if (f.size() == largest[piece]) {
        largest[piece] = cut.piece.size() + 1;  // of equals, the first stays
        continue;
      }
      uint32_t other = piece;
      for (size_t i = 0; i < f.size() && other == piece; ++i) {
        for (uint32_t h = 3 * f[i]; h < 3 * f[i] + 3; ++h) {
          if (cut.is_border(h)) other = cut.piece[cut.opposite[h] / 3];
        }
      }
      for (const uint32_t t : f) cut.piece[t] = other;
      changed = true;
    }
    if (!changed) return;
  }
}

CutSphere cut_sphere(uint32_t frequency, std::span<const vec3> seeds) {
  CutSphere cut;
  cut.sphere = geodesic_sphere(frequency);
  cut.opposite = opposite_half_edges(cut.sphere.triangles);
  cut.piece.resize(cut.sphere.triangles.size());
  const float roughness = 0.45f / std::sqrt(static_cast<float>(seeds.size()));
  const float frequency_of_noise = 1.2f / roughness;
  parallel_for(cut.piece.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const uvec3 v = cut.sphere.triangles[t];
      const auto& p = cut.sphere.positions;
      vec3 q = normalize(p[v.x] + p[v.y] + p[v.z]);
      const vec3 at = q * frequency_of_noise * 0.3f;
      q += roughness *
           vec3(fractal_noise(at, 3, 1), fractal_noise(at, 3, 11), fractal_noise(at, 3, 21));
      float best = std::numeric_limits<float>::infinity();
      for (uint32_t s = 0; s < seeds.size(); ++s) {
        const float d = dot(q - seeds[s], q - seeds[s]);
        if (d < best) {
          best = d;
          cut.piece[t] = s;
        }
      }
    }
  });
  join_fragments(cut, seeds.size());
  for (uint32_t h = 0; h < cut.opposite.size(); ++h) cut.border_edges += cut.is_border(h);
  return cut;
}

// Outer and inner triangles, and two layers of two triangles along each border.
uint32_t shell_triangles(const CutSphere& cut) {
  return 2 * static_cast<uint32_t>(cut.piece.size()) + 4 * cut.border_edges;
}

// The finest grid that does not exceed `triangles`.
CutSphere cut_for(uint32_t triangles, std::span<const vec3> seeds) {
  // Triangles are 40 f^2 + b f, with b for the borders; learn b from one cut.
  uint32_t f =
      std::max(2u, static_cast<uint32_t>(std::sqrt(static_cast<float>(triangles) / 60.0f)));
  CutSphere cut = cut_sphere(f, seeds);
  const float b = 4.0f * static_cast<float>(cut.border_edges) / static_cast<float>(f);
  const float t = static_cast<float>(triangles);
  f = static_cast<uint32_t>((std::sqrt(b * b + 160.0f * t) - b) / 80.0f);
  for (f = std::max(2u, f);; --f) {
    cut = cut_sphere(f, seeds);
    if (shell_triangles(cut) <= triangles || f == 2) return cut;
  }
}

// Draws each border vertex between two pieces towards its neighbours along the border, which takes
// the grid's zigzag out of the cracks.
void smooth_borders(CutSphere& cut) {
  std::vector<vec3>& p = cut.sphere.positions;
  std::vector<uint32_t> degree(p.size(), 0);
  std::vector<std::array<uint32_t, 2>> neighbours(p.size());
  for (uint32_t h = 0; h < cut.opposite.size(); ++h) {
    if (!cut.is_border(h)) continue;
    const uvec3 t = cut.sphere.triangles[h / 3];
    const uint32_t from = t[static_cast<int>(h % 3)], to = t[static_cast<int>((h + 1) % 3)];
    if (degree[from] < 2) neighbours[from][degree[from]] = to;
    ++degree[from];
  }
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<vec3> old = p;
    for (size_t v = 0; v < p.size(); ++v) {
      if (degree[v] != 2) continue;
      p[v] = normalize(2.0f * old[v] + old[neighbours[v][0]] + old[neighbours[v][1]]);
    }
  }
}

// The fan of each triangle corner: corners of one grid vertex belong together if the triangles
// between them are of one piece. A piece that touches itself in a point gets two vertices there.
std::vector<uint32_t> corner_fans(const CutSphere& cut, uint32_t& fans) {
  std::vector<uint32_t> root(cut.opposite.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](uint32_t corner) {
    while (root[corner] != corner) corner = root[corner] = root[root[corner]];
    return corner;
  };
  const auto next = [](uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; };
  for (uint32_t h = 0; h < cut.opposite.size(); ++h) {
    if (cut.is_border(h)) continue;
    const uint32_t a = find(h), b = find(next(cut.opposite[h]));
    root[std::max(a, b)] = std::min(a, b);
  }
  std::vector<uint32_t> fan(root.size());
  fans = 0;
  for (uint32_t corner = 0; corner < root.size(); ++corner) {
    const uint32_t first = find(corner);
    fan[corner] = first == corner ? fans++ : fan[first];
  }
  return fan;
}

// Speckled blue-green glaze.
vec3 glaze(vec3 d) {
  const float cloud = fractal_noise(3.0f * d, 4, 31);
  const vec3 base = glm::mix(vec3(0.05f, 0.30f, 0.38f), vec3(0.22f, 0.55f, 0.50f),
                             glm::clamp(0.5f + 0.9f * cloud - 0.25f * d.y, 0.0f, 1.0f));
  const Cells cells = cellular_noise(9.0f * d, 1.0f, 5);
  const float size = 0.10f + 0.28f * unit_float(hash_u32(cells.id));
  const float spot = glm::smoothstep(size, 0.6f * size, cells.nearest);
  return glm::mix(base, vec3(0.10f, 0.05f, 0.04f), 0.8f * spot);
}

// Builds the mesh of a cut sphere. Vertices: one a fan outside, one a fan inside, and one for each
// fan on a border in the rough middle of the wall.
class ShellBuilder {
 public:
  ShellBuilder(const CutSphere& cut, Mesh& mesh) : cut_(cut), mesh_(mesh) {
    uint32_t fans = 0;
    fan_ = corner_fans(cut, fans);
    first_corner_.assign(fans, kNoHalfEdge);
    middle_.assign(fans, kNoHalfEdge);
    for (uint32_t corner = 0; corner < fan_.size(); ++corner) {
      first_corner_[fan_[corner]] = std::min(first_corner_[fan_[corner]], corner);
      if (!cut.is_border(corner)) continue;
      const uint32_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
      middle_[fan_[corner]] = middle_[fan_[next]] = 0;
    }
    vertices_ = 2 * fans;
    for (uint32_t& m : middle_) {
      if (m == 0) m = vertices_++;
    }
  }

  void build() {
    mesh_.parts = {{kShellOutside, false}, {kShellInside, false}, {kShellBreak, true}};
    add_vertices();
    add_sides();
    add_walls();
  }

 private:
  uint32_t fans() const { return static_cast<uint32_t>(first_corner_.size()); }

  void add_vertices() {
    mesh_.positions.resize(vertices_);
    mesh_.normals.resize(vertices_);
    mesh_.colors.resize(vertices_);
    mesh_.influences = 1;
    mesh_.joints.resize(vertices_);
    mesh_.weights.assign(vertices_, 1.0f);
    const std::vector<vec3>& d = cut_.sphere.positions;
    std::vector<vec3> outer(d.size());
    std::ranges::transform(d, outer.begin(), [](vec3 p) { return egg_point(p, 1.0f); });
    const std::vector<vec3> normals = vertex_normals(outer, cut_.sphere.triangles);
    parallel_for(fans(), 2048, [&](size_t begin, size_t end) {
      for (uint32_t fan = static_cast<uint32_t>(begin); fan < end; ++fan) {
        const uint32_t corner = first_corner_[fan];
        const uint32_t v = cut_.sphere.triangles[corner / 3][static_cast<int>(corner % 3)];
        const uint16_t joint = static_cast<uint16_t>(cut_.piece[corner / 3] + 1);
        const vec3 yolk(0.95f, 0.66f, 0.28f), chalk(0.90f, 0.84f, 0.72f);
        set_vertex(fan, egg_point(d[v], 1.0f), normals[v], glaze(d[v]), joint);
        set_vertex(fans() + fan, egg_point(d[v], 1.0f - kThickness), -normals[v], yolk, joint);
        if (middle_[fan] == kNoHalfEdge) continue;
        const vec3 at = 30.0f * d[v];
        const vec3 rough =
            0.02f * vec3(gradient_noise(at, 41), gradient_noise(at, 42), gradient_noise(at, 43));
        set_vertex(middle_[fan], egg_point(normalize(d[v] + rough), 1.0f - 0.5f * kThickness),
                   normals[v], chalk, joint);
      }
    });
  }

  void set_vertex(uint32_t i, vec3 position, vec3 normal, vec3 color, uint16_t joint) {
    mesh_.positions[i] = position;
    mesh_.normals[i] = normal;
    mesh_.colors[i] = vec4(color, 1.0f);
    mesh_.joints[i] = joint;
  }

  void add_sides() {
    for (uint32_t t = 0; t < cut_.piece.size(); ++t) {
      const uvec3 f(fan_[3 * t], fan_[3 * t + 1], fan_[3 * t + 2]);
      mesh_.triangles.push_back(f);
      mesh_.triangle_part.push_back(kShellOutside);
      mesh_.triangles.push_back(uvec3(f.x, f.z, f.y) + fans());
      mesh_.triangle_part.push_back(kShellInside);
    }
  }

  void add_walls() {
    for (uint32_t h = 0; h < fan_.size(); ++h) {
      if (!cut_.is_border(h)) continue;
      const uint32_t a = fan_[h], b = fan_[h % 3 == 2 ? h - 2 : h + 1];
      const std::array<uint32_t, 3> a_down{a, middle_[a], fans() + a};
      const std::array<uint32_t, 3> b_down{b, middle_[b], fans() + b};
      for (int layer = 0; layer < 2; ++layer) {
        mesh_.triangles.push_back({b_down[layer], a_down[layer], a_down[layer + 1]});
        mesh_.triangles.push_back({b_down[layer], a_down[layer + 1], b_down[layer + 1]});
      }
    }
    mesh_.triangle_part.resize(mesh_.triangles.size(), kShellBreak);
  }

  const CutSphere& cut_;
  Mesh& mesh_;
  std::vector<uint32_t> fan_;           // one a corner
  std::vector<uint32_t> first_corner_;  // one a fan
  std::vector<uint32_t> middle_;        // one a fan: its vertex in the wall, if it is on a border
  uint32_t vertices_ = 0;
};

// Cuts inner triangles in three at their middles, evenly spread, until there are `triangles`.
void split_inner_triangles(Mesh& mesh, uint32_t triangles) {
  const uint32_t have = static_cast<uint32_t>(mesh.triangles.size());
  const uint32_t inner =
      static_cast<uint32_t>(std::ranges::count(mesh.triangle_part, uint32_t{kShellInside}));
  const uint32_t splits = triangles > have ? std::min((triangles - have) / 2, inner) : 0;
  uint32_t seen = 0;
  for (uint32_t t = 0; t < have; ++t) {
    if (mesh.triangle_part[t] != kShellInside) continue;
    const uint64_t before = uint64_t{seen} * splits / inner;
    const uint64_t after = uint64_t{++seen} * splits / inner;
    if (before == after) continue;
    const uvec3 v = mesh.triangles[t];
    const uint32_t middle = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.push_back((mesh.positions[v.x] + mesh.positions[v.y] + mesh.positions[v.z]) /
                             3.0f);
    mesh.normals.push_back(normalize(mesh.normals[v.x] + mesh.normals[v.y] + mesh.normals[v.z]));
    mesh.colors.push_back(mesh.colors[v.x]);
    mesh.joints.push_back(mesh.joints[v.x]);
    mesh.weights.push_back(1.0f);
    mesh.triangles[t] = {v.x, v.y, middle};
    mesh.triangles.push_back({v.y, v.z, middle});
    mesh.triangles.push_back({v.z, v.x, middle});
  }
  mesh.triangle_part.resize(mesh.triangles.size(), kShellInside);
}

}  // namespace

Mesh make_shell(uint32_t triangles, uint32_t pieces) {
  SINEW_CHECK(pieces >= 1 && triangles / 60 >= pieces);
  const std::vector<vec3> seeds = scatter_seeds(pieces);
  CutSphere cut = cut_for(triangles, seeds);
  smooth_borders(cut);
  Mesh mesh;
  mesh.name = "shell";
  ShellBuilder(cut, mesh).build();
  split_inner_triangles(mesh, triangles);
  return mesh;
}

}  // namespace sinew
