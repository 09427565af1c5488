// study:cell24: the edges of a 24-cell that turns in four dimensions, seen in perspective.
// After: J. Bittner, D. Meister, "T-SAH", 2015, table 1, "24 Cell" (122.8k triangles, 128 key
// frames). Based on: H. S. M. Coxeter, "Regular Polytopes", 1973, section 8.2 (the 24-cell). The
// paper does not say how its cell turns or looks; that is our own.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/scenes.h"
#include "sinew/scene/procedural/shapes.h"
#include "sinew/scene/procedural/stage.h"

namespace sinew {
namespace {

constexpr uint32_t kFrames = 128;
constexpr double kFps = 25.0;
constexpr double kSeconds = kFrames / kFps;
constexpr uint32_t kCorners = 24, kEdges = 96;
constexpr float kTwoPi = 6.28318531f;
constexpr float kEyeDistance = 1.75f;  // from the middle along +W; the corners are at distance 1
constexpr float kReach = 1.5f;         // how far a corner gets from the middle in space, metres
constexpr vec3 kMiddle(0.0f, 1.75f, 0.0f);
constexpr float kTubeRadius = 0.040f, kCornerRadius = 0.075f;  // in four dimensions

constexpr StudyParameter kParameters[] = {
    {"triangles", "about how many triangles the cell has, 10000 to 4000000", "122880"},
    {"motion", "free: new vertices each frame; keys: a vertex cache of 129 keys (95 MB)", "free"},
};

// How finely tubes and corners are cut: `around` by `rings` for a tube, frequency of a sphere.
struct Fineness {
  uint32_t around, rings, sphere;

  // A sixteenth of the triangles are for the corners.
  explicit Fineness(uint32_t triangles) {
    const float count = static_cast<float>(triangles);
    const auto rounded = [](float x) { return static_cast<uint32_t>(std::lround(x)); };
    sphere = std::max(1u, rounded(std::sqrt(count / 16.0f / (20.0f * kCorners))));
    const float a_tube = (count - static_cast<float>(20 * kCorners * sphere * sphere)) / kEdges;
    around = std::max(5u, rounded(std::sqrt(0.48f * a_tube)));
    rings = std::max(2u, rounded(0.5f * a_tube / static_cast<float>(around)));
  }
};

struct Edge {
  uint32_t from, to;
};

// The 24-cell's corners, all permutations of (+-1, +-1, 0, 0) / sqrt(2), in three classes of eight:
// the corners of a class are those of a 16-cell, and every edge joins two classes.
struct Polytope {
  std::array<vec4, kCorners> corners;
  std::array<uint32_t, kCorners> corner_class;
  std::array<Edge, kEdges> edges;

  Polytope() {
    uint32_t corner = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        for (int signs = 0; signs < 4; ++signs) {
          vec4 p(0.0f);
          p[i] = signs & 1 ? -0.70710678f : 0.70710678f;
          p[j] = signs & 2 ? -0.70710678f : 0.70710678f;
          // Of the pairings {01, 23}, {02, 13}, {03, 12}, the one that the axes belong to.
          corner_class[corner] = static_cast<uint32_t>(i == 0 ? j - 1 : 5 - i - j);
          corners[corner++] = p;
        }
      }
    }
    uint32_t edge = 0;
    for (uint32_t a = 0; a < kCorners; ++a) {
      for (uint32_t b = a + 1; b < kCorners; ++b) {
        if (dot(corners[a], corners[b]) > 0.25f) edges[edge++] = {a, b};  // 60 degrees apart
      }
    }
  }

  // The class that an edge does not touch.
  uint32_t edge_class(const Edge& e) const { return 3 - corner_class[e.from] - corner_class[e.to]; }
};

// One turn in the plane of X and W and two in that of Y and Z, after a tilt that spares the viewer
// the symmetric views.
vec4 turned(vec4 p, double turns) {
  constexpr float kCos = 0.877582562f, kSin = 0.479425539f;  // of half a radian
  const vec4 q(kCos * p.x - kSin * p.y, kSin * p.x + kCos * p.y, kCos * p.z - kSin * p.w,
               kSin * p.z + kCos * p.w);
  const double angle = 6.283185307179586 * turns;
  const auto c1 = static_cast<float>(std::cos(angle)), s1 = static_cast<float>(std::sin(angle));
  const auto c2 = static_cast<float>(std::cos(2.0 * angle)),
             s2 = static_cast<float>(std::sin(2.0 * angle));
  return vec4(c1 * q.x - s1 * q.w, c2 * q.y - s2 * q.z, s2 * q.y + c2 * q.z, s1 * q.x + c1 * q.w);
}

// How large something at this point is seen: 1 / (distance along W), scaled so that the farthest
// that a point of the unit sphere is seen from the middle is kReach.
float magnification(vec4 p) {
  static const float scale = kReach * std::sqrt(kEyeDistance * kEyeDistance - 1.0f);
  return scale / (kEyeDistance - p.w);
}

vec3 projected(vec4 p) {
  return magnification(p) * vec3(p);
}

// For each edge, a direction that it never comes near during the whole turn. Rings start on its
// side of the tube, so they turn with the edge but never flip.
std::array<vec3, kEdges> quiet_directions(const Polytope& polytope) {
  constexpr uint32_t kCandidates = 64, kSteps = 256;
  std::array<std::array<vec3, kCorners>, kSteps> corners;
  for (uint32_t step = 0; step < kSteps; ++step) {
    for (uint32_t c = 0; c < kCorners; ++c) {
      corners[step][c] = projected(turned(polytope.corners[c], step / double{kSteps}));
    }
  }
  std::array<vec3, kEdges> result;
  parallel_for(kEdges, 8, [&](size_t begin, size_t end) {
    for (size_t e = begin; e < end; ++e) {
      float least_peak = 2.0f;
      for (uint32_t i = 0; i < kCandidates; ++i) {  // Fibonacci points on half a sphere
        const float y = (static_cast<float>(i) + 0.5f) / kCandidates;
        const float angle = 2.39996323f * static_cast<float>(i), r = std::sqrt(1.0f - y * y);
        const vec3 candidate(r * std::cos(angle), y, r * std::sin(angle));
        float peak = 0.0f;
        for (const auto& at : corners) {
          const vec3 along = normalize(at[polytope.edges[e].to] - at[polytope.edges[e].from]);
          peak = std::max(peak, std::abs(dot(along, candidate)));
        }
        if (peak < least_peak) {
          least_peak = peak;
          result[e] = candidate;
        }
      }
    }
  });
  return result;
}

// Writes the vertices at a time: tube after tube (its rings, then the middles of its two ends),
// then sphere after sphere.
struct TurningCell {
  Polytope polytope;
  std::array<vec3, kEdges> quiet;
  Fineness fineness;
  std::vector<vec3> sphere;

  explicit TurningCell(const Fineness& f)
      : quiet(quiet_directions(polytope)),
        fineness(f),
        sphere(geodesic_sphere(f.sphere).positions) {}

  size_t tube_vertices() const { return size_t{fineness.around} * fineness.rings + 2; }
  size_t vertices() const { return kEdges * tube_vertices() + kCorners * sphere.size(); }

  void operator()(double time, std::span<vec3> out) const {
    std::array<vec4, kCorners> corners;
    for (uint32_t c = 0; c < kCorners; ++c) {
      corners[c] = turned(polytope.corners[c], time / kSeconds);
    }
    parallel_for(kEdges, 4, [&](size_t begin, size_t end) {
      for (size_t e = begin; e < end; ++e) {
        write_tube(corners[polytope.edges[e].from], corners[polytope.edges[e].to], quiet[e],
                   out.subspan(e * tube_vertices(), tube_vertices()));
      }
    });
    vec3* next = &out[kEdges * tube_vertices()];
    for (const vec4 c : corners) {
      const vec3 middle = kMiddle + projected(c);
      const float radius = kCornerRadius * magnification(c);
      for (const vec3 p : sphere) *next++ = middle + radius * p;
    }
  }

 private:
  void write_tube(vec4 from, vec4 to, vec3 aside, std::span<vec3> out) const {
    const vec3 along = normalize(projected(to) - projected(from));
    const vec3 x = normalize(aside - dot(aside, along) * along), y = cross(along, x);
    vec3* next = out.data();
    for (uint32_t ring = 0; ring < fineness.rings; ++ring) {
      const float v = static_cast<float>(ring) / static_cast<float>(fineness.rings - 1);
      const vec4 at = (1.0f - v) * from + v * to;
      const vec3 middle = kMiddle + projected(at);
      const float radius = kTubeRadius * magnification(at);
      for (uint32_t i = 0; i < fineness.around; ++i) {
        const float angle = kTwoPi * static_cast<float>(i) / static_cast<float>(fineness.around);
        *next++ = middle + radius * (std::cos(angle) * x + std::sin(angle) * y);
      }
    }
    *next++ = kMiddle + projected(from);
    *next++ = kMiddle + projected(to);
  }
};

// Parts 0 to 2 are the classes of edges, part 3 the corners.
Mesh make_cell(const TurningCell& cell) {
  Mesh mesh;
  mesh.name = "cell";
  mesh.positions.resize(cell.vertices());
  cell(0.0, mesh.positions);
  const Fineness& f = cell.fineness;
  const TriangleSurface tube = closed_tube(f.around, f.rings, [](float, float) { return vec3(); });
  const TriangleSurface sphere = geodesic_sphere(f.sphere);
  const auto add = [&](const TriangleSurface& surface, size_t first, uint32_t part) {
    for (const uvec3 t : surface.triangles) {
      mesh.triangles.push_back(t + static_cast<uint32_t>(first));
    }
    mesh.triangle_part.resize(mesh.triangles.size(), part);
  };
  for (uint32_t e = 0; e < kEdges; ++e) {
    add(tube, e * cell.tube_vertices(), cell.polytope.edge_class(cell.polytope.edges[e]));
  }
  for (uint32_t c = 0; c < kCorners; ++c) {
    add(sphere, kEdges * cell.tube_vertices() + c * cell.sphere.size(), 3);
  }
  mesh.parts = {{0, false}, {1, false}, {2, false}, {3, false}};
  return mesh;
}

// The cell's vertices at every frame, and the first again at the end.
void add_keys(const TurningCell& cell, Mesh& mesh) {
  mesh.keys = kFrames + 1;
  mesh.key_positions.resize(mesh.keys * mesh.positions.size());
  for (uint32_t key = 0; key < mesh.keys; ++key) {
    cell((key % kFrames) / kFps,
         std::span(mesh.key_positions).subspan(key * mesh.positions.size(), mesh.positions.size()));
  }
}

void add_stage(Scene& scene) {
  scene.images.push_back(paint_image(256, 128, [](float u, float v) {
    const float cloud =
        fractal_noise(vec3(std::cos(kTwoPi * u), std::sin(kTwoPi * u), 4.0f * v), 4, 11);
    return vec3(0.050f, 0.055f, 0.070f) * (1.0f + 0.5f * cloud);
  }));
  Material floor = colored_material("floor", vec3(1.0f), 0.12f);
  floor.base_color_texture.image = 0;
  floor.base_color_texture.wrap_t = Wrap::mirror;
  scene.materials.push_back(std::move(floor));
  DiscConfig disc;
  disc.radius = 3.4f;
  disc.rings = 6;
  disc.sectors = 96;
  disc.turns = 4.0f;
  disc.ring_height = 0.5f;
  Mesh mesh = make_disc(disc, 4);
  mesh.name = "floor";
  add_mesh_node(scene, std::move(mesh));
  add_sun(scene, "key", {{0.7f, 1.2f, 0.8f}, {1.0f, 0.92f, 0.80f}, 3.6f});
  add_sun(scene, "rim", {{-1.0f, 0.5f, -0.6f}, {0.62f, 0.78f, 1.0f}, 2.0f});
  add_camera(scene, "Front", {{1.25f, 2.6f, 6.6f}, {0.0f, 1.62f, 0.0f}, 0.53f});
  scene.environment = {{0.05f, 0.13f, 0.34f}, {0.50f, 0.55f, 0.62f}, {0.05f, 0.048f, 0.055f}};
}

}  // namespace

const StudyInfo cell24_info{
    "cell24", "a 24-cell of 122,880 triangles that turns in four dimensions, tubes along its edges",
    kParameters};

Result<Scene> make_cell24(const StudyArguments& arguments) {
  SINEW_TRY(const uint32_t triangles, arguments.integer("triangles", 10000, 4000000));
  SINEW_TRY(const uint32_t motion, arguments.choice("motion", {"free", "keys"}));
  Scene scene;
  scene.materials.push_back(colored_material("teal", vec3(0.05f, 0.42f, 0.46f), 0.22f, 0.35f));
  scene.materials.push_back(colored_material("coral", vec3(0.86f, 0.22f, 0.13f), 0.22f, 0.35f));
  scene.materials.push_back(colored_material("ivory", vec3(0.82f, 0.76f, 0.62f), 0.22f, 0.15f));
  scene.materials.push_back(colored_material("gold", vec3(0.98f, 0.72f, 0.28f), 0.12f, 0.8f));
  const TurningCell cell{Fineness(triangles)};
  Mesh mesh = make_cell(cell);
  Clip clip;
  clip.name = "Turn";
  clip.end = kSeconds;
  if (motion == 1)
    add_keys(cell, mesh);
  else
    mesh.vertex_program = cell;
  const uint32_t node = add_mesh_node(scene, std::move(mesh));
  if (motion == 1) {
    clip.channels.push_back(value_channel(node, ChannelPath::cache_key, 1,
                                          {0.0f, static_cast<float>(kSeconds)},
                                          {0.0f, static_cast<float>(kFrames)}));
  }
  scene.clips.push_back(std::move(clip));
  add_stage(scene);
  scene.default_frames = kFrames;
  scene.default_fps = kFps;
  return scene;
}

}  // namespace sinew
