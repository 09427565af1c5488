#include "sinew/scene/procedural/creature_parts.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sinew/scene/procedural/creature_skeleton.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318531f;

constexpr vec3 kHornRoot(0.23f, 0.13f, 0.06f), kHornTip(0.86f, 0.74f, 0.52f);
constexpr vec3 kPlateRoot(0.30f, 0.055f, 0.015f), kPlateTip(0.95f, 0.42f, 0.07f);

// A piece that grows from its root along a parabola, its width shrinking to a point.
struct Growth {
  vec3 root{0.0f};
  vec3 along{0.0f};                     // first direction times length
  vec3 bend{0.0f};                      // how far the tip strays from the straight line
  vec3 wide{1.0f, 0.0f, 0.0f};          // unit; the widest direction of the cross section
  float width = 0.03f;                  // half, at the widest place
  float thickness = 0.03f;              // half, across
  std::function<float(float)> profile;  // share of the width at v in [0, 1]
};

TriangleSurface grow(const Growth& g, uint32_t around, uint32_t rows) {
  return closed_tube(around, rows, [&](float u, float v) {
    const vec3 middle = g.root + v * g.along + v * v * g.bend;
    const vec3 forward = normalize(g.along + 2.0f * v * g.bend);
    const vec3 thin = normalize(cross(forward, g.wide));
    const vec3 wide = cross(thin, forward);
    const float share = v <= 0.0f || v >= 1.0f ? 0.0f : g.profile(v);
    const float angle = kTwoPi * u;
    return middle +
           share * (g.width * std::cos(angle) * wide + g.thickness * std::sin(angle) * thin);
  });
}

// Around and rows of a tube of about `triangles` = 2 around rows, `slender` times as many rows.
struct TubeSize {
  uint32_t around, rows;
  TubeSize(float triangles, float slender)
      : around(std::max(6u, static_cast<uint32_t>(std::sqrt(0.5f * triangles / slender)))),
        rows(std::max(5u, static_cast<uint32_t>(0.5f * triangles / static_cast<float>(around)))) {}
};

// Adds a shape with one set of weights for all its vertices, coloured from root to tip.
void wear(Mesh& mesh, const TriangleSurface& surface, TubeSize size, uint32_t part,
          const SkinWeights& weights, vec3 root_color, vec3 tip_color) {
  const uint32_t first = static_cast<uint32_t>(mesh.positions.size());
  for (const uvec3 t : surface.triangles) mesh.triangles.push_back(t + first);
  mesh.triangle_part.resize(mesh.triangles.size(), part);
  mesh.positions.insert(mesh.positions.end(), surface.positions.begin(), surface.positions.end());
  for (uint32_t i = 0; i < surface.positions.size(); ++i) {
    const uint32_t row = std::min(i / size.around, size.rows);  // the poles come last
    const bool first_pole = i == size.around * size.rows;
    const float v = first_pole ? 0.0f : static_cast<float>(row) / static_cast<float>(size.rows);
    const float rings = 1.0f + 0.10f * std::sin(60.0f * v);
    mesh.colors.push_back(vec4(glm::mix(root_color, tip_color, v) * rings, 1.0f));
    mesh.joints.insert(mesh.joints.end(), weights.joints.begin(), weights.joints.end());
    mesh.weights.insert(mesh.weights.end(), weights.weights.begin(), weights.weights.end());
  }
}

SkinWeights bound_to(uint32_t joint) {
  SkinWeights weights;
  weights.joints.fill(static_cast<uint16_t>(joint));
  weights.weights = {1.0f, 0.0f, 0.0f, 0.0f};
  return weights;
}

float horn_profile(float v) {
  return std::sqrt(std::min(1.0f, 12.0f * v)) * std::pow(1.0f - v, 0.8f);
}
float plate_profile(float v) {
  return std::sqrt(std::min(1.0f, 6.0f * v)) * (0.80f + 0.9f * v) * std::pow(1.0f - v, 0.75f);
}

void add_horns(Mesh& mesh, const CreatureBody& body, float triangles) {
  struct Horn {
    vec3 direction;  // from the middle of the skull to where it grows
    vec3 along, bend;
    float width;
    float share;  // of the triangles
  };
  constexpr vec3 kSkull(0.0f, 0.99f, 0.74f);
  constexpr Horn kHorns[] = {
      {{0.55f, 0.80f, -0.25f}, {0.11f, 0.17f, -0.05f}, {-0.03f, -0.01f, -0.17f}, 0.046f, 0.32f},
      {{0.90f, 0.30f, -0.50f}, {0.11f, 0.01f, -0.07f}, {-0.01f, 0.05f, -0.07f}, 0.034f, 0.16f},
  };
  for (const Horn& horn : kHorns) {
    for (const float side : {1.0f, -1.0f}) {
      const vec3 mirror(side, 1.0f, 1.0f);
      const vec3 direction = normalize(horn.direction * mirror);
      Growth growth;
      growth.root = body.leave(kSkull, direction) - 0.02f * direction;
      growth.along = horn.along * mirror;
      growth.bend = horn.bend * mirror;
      growth.wide = normalize(cross(growth.along, vec3(0.0f, 1.0f, 0.2f)));
      growth.width = growth.thickness = horn.width;
      growth.profile = horn_profile;
      const TubeSize size(0.5f * horn.share * triangles, 1.6f);
      wear(mesh, grow(growth, size.around, size.rows), size, 0, bound_to(kHead), kHornRoot,
           kHornTip);
    }
  }
  // One on the nose.
  Growth nose;
  nose.root = body.leave({0.0f, 0.93f, 1.03f}, {0.0f, 1.0f, 0.0f}) - vec3(0.0f, 0.012f, 0.0f);
  nose.along = {0.0f, 0.075f, 0.01f};
  nose.bend = {0.0f, 0.0f, -0.03f};
  nose.width = 0.022f;
  nose.thickness = 0.026f;
  nose.profile = horn_profile;
  const TubeSize size(0.10f * triangles, 1.3f);
  wear(mesh, grow(nose, size.around, size.rows), size, 0, bound_to(kHead), kHornRoot, kHornTip);
}

void add_claws(Mesh& mesh, float triangles) {
  const CreatureSkeleton skeleton = creature_skeleton();
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    const vec3 ball = skeleton[leg_joint(leg, kToes)].position;
    for (int toe = -1; toe <= 1; ++toe) {
      const float x = static_cast<float>(toe);
      Growth claw;
      claw.root = ball + vec3(0.070f * x, -0.015f, toe == 0 ? 0.112f : 0.092f);
      claw.along = {0.012f * x, 0.006f, 0.062f};
      claw.bend = {0.0f, -0.026f, -0.004f};
      claw.width = 0.019f;
      claw.thickness = 0.017f;
      claw.profile = horn_profile;
      const TubeSize size(triangles / 12.0f, 1.0f);
      wear(mesh, grow(claw, size.around, size.rows), size, 0, bound_to(leg_joint(leg, kToes)),
           kHornRoot, 0.8f * kHornTip);
    }
  }
}

// Across the bones, leaning to the vertical where the neck is steep.
vec3 plate_direction(vec3 back) {
  const vec3 across = normalize(vec3(0.0f, 1.0f, 0.0f) - back.y * back);
  return normalize(across + vec3(0.0f, 0.7f, 0.0f));
}

// Plates stand on the back from the nape to the tail, in pairs of unlike size.
void add_plates(Mesh& mesh, const CreatureBody& body, float triangles) {
  constexpr uint32_t kPlates = 19;
  const CreatureSkeleton skeleton = creature_skeleton();
  constexpr uint32_t kLine[] = {kHead,     kNeckHigh, kNeckLow,  kChest,    kSpine,
                                kPelvis,   kTail,     kTail + 1, kTail + 2, kTail + 3,
                                kTail + 4, kTail + 5, kTail + 6, kTail + 7};
  constexpr float kSteps = static_cast<float>(std::size(kLine) - 1);
  for (uint32_t i = 0; i < kPlates; ++i) {
    const float t = static_cast<float>(i) / (kPlates - 1);
    const float s = kSteps * (0.035f + 0.955f * t);
    const uint32_t k = std::min(static_cast<uint32_t>(s), static_cast<uint32_t>(kSteps) - 1);
    const vec3 a = skeleton[kLine[k]].position, b = skeleton[kLine[k + 1]].position;
    const vec3 back = normalize(b - a);
    const vec3 up = plate_direction(back);
    const vec3 surface = body.leave(glm::mix(a, b, s - static_cast<float>(k)), up);
    const float swell = std::sin(0.5f * kTwoPi * std::pow(0.06f + 0.90f * t, 0.75f));
    const float height = (0.035f + 0.135f * swell) * (i % 2 == 0 ? 1.0f : 0.72f);
    Growth plate;
    plate.root = surface - 0.025f * up;
    plate.along = (height + 0.025f) * up;
    plate.bend = 0.40f * height * back;
    plate.wide = normalize(back - dot(back, up) * up);
    plate.width = 0.46f * height + 0.006f;
    plate.thickness = 0.010f + 0.05f * height;
    plate.profile = plate_profile;
    const TubeSize size(triangles / kPlates, 1.0f);
    wear(mesh, grow(plate, size.around, size.rows), size, 1, body.skin_weights(surface), kPlateRoot,
         kPlateTip);
  }
}

}  // namespace

Mesh make_creature_armour(const CreatureBody& body, uint32_t triangles, uint32_t horn,
                          uint32_t plate) {
  Mesh mesh;
  mesh.name = "armour";
  mesh.parts = {{horn, false}, {plate, false}};
  mesh.influences = SkinWeights::kInfluences;
  const float count = static_cast<float>(triangles);
  add_horns(mesh, body, 0.30f * count);
  add_claws(mesh, 0.25f * count);
  add_plates(mesh, body, 0.45f * count);
  mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  return mesh;
}

Mesh make_creature_eyes(uint32_t triangles, uint32_t material) {
  Mesh mesh;
  mesh.name = "eyes";
  mesh.parts = {{material, false}};
  mesh.influences = 1;
  const uint32_t frequency =
      std::max(4u, static_cast<uint32_t>(std::sqrt(static_cast<float>(triangles) / 40.0f)));
  const TriangleSurface ball = geodesic_sphere(frequency);
  for (const float side : {1.0f, -1.0f}) {
    const uint32_t first = static_cast<uint32_t>(mesh.positions.size());
    const vec3 gaze = normalize(vec3(0.78f * side, 0.06f, 0.62f));
    const vec3 right = normalize(cross(vec3(0.0f, 1.0f, 0.0f), gaze)), up = cross(gaze, right);
    for (const uvec3 t : ball.triangles) mesh.triangles.push_back(t + first);
    for (const vec3 n : ball.positions) {
      mesh.positions.push_back(kEyeCenter * vec3(side, 1.0f, 1.0f) + kEyeRadius * n);
      mesh.normals.push_back(n);
      const bool back = dot(n, gaze) < 0.0f;
      const vec2 flat(dot(n, right), -dot(n, up));
      const float reach = length(flat);
      // The far half shows the rim of the texture.
      mesh.texcoords[0].push_back(0.5f + 0.5f * (back && reach > 0.0f ? flat / reach : flat));
      mesh.joints.push_back(static_cast<uint16_t>(side > 0.0f ? kEyeLeft : kEyeRight));
      mesh.weights.push_back(1.0f);
    }
  }
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace sinew
