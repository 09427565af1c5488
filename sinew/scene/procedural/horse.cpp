#include "sinew/scene/procedural/horse.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/flesh.h"
#include "sinew/scene/procedural/implicit_mesh.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/shapes.h"

namespace sinew {
namespace {

// What a piece of flesh looks like.
enum class Cover : uint8_t { hide, muzzle, hair, shank, hoof };

struct Anatomy {
  std::vector<Flesh> flesh;
  std::vector<Cover> covers;  // one a piece

  void add(uint32_t joint, Cover cover, RoundCone shape, float blend) {
    flesh.push_back({joint, shape, blend});
    covers.push_back(cover);
  }
};

vec3 mirrored(vec3 p, float side) {
  return vec3(side * p.x, p.y, p.z);
}

vec3 rest(uint32_t joint) {
  return horse_skeleton()[joint].position;
}

void add_trunk(Anatomy& a) {
  const Cover hide = Cover::hide;
  a.add(kCroup, hide, {{0.0f, 1.24f, -0.62f}, 0.27f, {0.0f, 1.23f, -0.38f}, 0.29f}, 0.0f);
  a.add(kLoin, hide, {{0.0f, 1.18f, -0.34f}, 0.29f, {0.0f, 1.15f, 0.00f}, 0.31f}, 0.10f);
  a.add(kWithers, hide, {{0.0f, 1.14f, 0.06f}, 0.31f, {0.0f, 1.17f, 0.36f}, 0.28f}, 0.10f);
  a.add(kWithers, hide, {{0.0f, 1.40f, 0.05f}, 0.12f, {0.0f, 1.43f, 0.28f}, 0.12f}, 0.16f);
  a.add(kWithers, hide, {{0.0f, 1.08f, 0.46f}, 0.20f, {0.0f, 1.15f, 0.50f}, 0.18f}, 0.10f);
  a.add(kNeck, hide, {{0.0f, 1.27f, 0.46f}, 0.225f, {0.0f, 1.54f, 0.72f}, 0.155f}, 0.12f);
  a.add(kNape, hide, {{0.0f, 1.56f, 0.73f}, 0.150f, {0.0f, 1.78f, 0.92f}, 0.112f}, 0.08f);
  // The mane lies on the crest, the tail hangs in a tuft.
  a.add(kNeck, Cover::hair, {{0.0f, 1.46f, 0.36f}, 0.045f, {0.0f, 1.70f, 0.66f}, 0.055f}, 0.03f);
  a.add(kNape, Cover::hair, {{0.0f, 1.70f, 0.66f}, 0.055f, {0.0f, 1.93f, 0.92f}, 0.042f}, 0.02f);
  a.add(kSkull, Cover::hair, {{0.0f, 1.96f, 0.97f}, 0.040f, {0.0f, 1.90f, 1.09f}, 0.022f}, 0.02f);
  constexpr std::array<float, kHorseTail + 1> kTuft{0.055f, 0.075f, 0.088f, 0.080f, 0.022f};
  for (uint32_t i = 0; i < kHorseTail; ++i) {
    const vec3 end = i + 1 < kHorseTail ? rest(kDock + i + 1) : vec3(0.0f, 0.62f, -1.22f);
    a.add(kDock + i, Cover::hair, {rest(kDock + i), kTuft[i], end, kTuft[i + 1]},
          i == 0 ? 0.04f : 0.02f);
  }
}

void add_head(Anatomy& a) {
  a.add(kSkull, Cover::hide, {{0.0f, 1.83f, 0.98f}, 0.125f, {0.0f, 1.77f, 1.10f}, 0.112f}, 0.07f);
  a.add(kSkull, Cover::hide, {{0.0f, 1.74f, 1.12f}, 0.104f, {0.0f, 1.56f, 1.33f}, 0.068f}, 0.06f);
  a.add(kSkull, Cover::muzzle, {{0.0f, 1.55f, 1.34f}, 0.070f, {0.0f, 1.52f, 1.38f}, 0.066f}, 0.04f);
  for (const float side : {1.0f, -1.0f}) {
    a.add(kSkull, Cover::hide,
          {mirrored({0.045f, 1.74f, 0.98f}, side), 0.085f, mirrored({0.040f, 1.68f, 1.06f}, side),
           0.070f},
          0.05f);
    a.add(kSkull, Cover::hide,
          {mirrored({0.062f, 1.92f, 0.96f}, side), 0.036f, mirrored({0.088f, 2.05f, 0.98f}, side),
           0.020f},
          0.03f);
  }
}

void add_leg(Anatomy& a, uint32_t leg) {
  const LegJoints j = horse_leg(leg);
  const bool fore = leg < 2;
  const float side = leg % 2 == 0 ? 1.0f : -1.0f;
  const vec3 shoulder =
      mirrored(fore ? vec3(0.14f, 1.16f, 0.34f) : vec3(0.13f, 1.16f, -0.60f), side);
  a.add(j[kUpper], Cover::hide,
        {shoulder, fore ? 0.155f : 0.205f, rest(j[kLower]), fore ? 0.105f : 0.135f}, 0.09f);
  a.add(j[kLower], Cover::hide,
        {rest(j[kLower]), fore ? 0.100f : 0.128f, rest(j[kFoot]), fore ? 0.056f : 0.060f}, 0.06f);
  a.add(j[kFoot], Cover::shank, {rest(j[kFoot]), fore ? 0.054f : 0.060f, rest(j[kToes]), 0.040f},
        0.03f);
  const vec3 fetlock = rest(j[kToes]);
  const vec3 coronet = fetlock + vec3(0.0f, -0.085f, 0.055f);
  a.add(j[kToes], Cover::shank, {fetlock, 0.044f, coronet, 0.042f}, 0.02f);
  a.add(j[kToes], Cover::hoof, {coronet, 0.050f, coronet + vec3(0.0f, -0.055f, 0.022f), 0.062f},
        0.012f);
}

Anatomy make_anatomy() {
  Anatomy anatomy;
  add_trunk(anatomy);
  add_head(anatomy);
  for (uint32_t leg = 0; leg < kHorseLegCount; ++leg) add_leg(anatomy, leg);
  return anatomy;
}

struct Coat {
  const char* name;
  vec3 hide, hair, shank, muzzle;
};
constexpr std::array<Coat, kCoats> kCoatColors{{
    {"bay",
     {0.23f, 0.085f, 0.030f},
     {0.012f, 0.010f, 0.009f},
     {0.020f, 0.014f, 0.011f},
     {0.035f, 0.024f, 0.020f}},
    {"chestnut",
     {0.36f, 0.135f, 0.045f},
     {0.30f, 0.125f, 0.050f},
     {0.27f, 0.10f, 0.035f},
     {0.13f, 0.058f, 0.032f}},
    {"black",
     {0.022f, 0.018f, 0.017f},
     {0.010f, 0.009f, 0.009f},
     {0.016f, 0.013f, 0.012f},
     {0.030f, 0.024f, 0.022f}},
    {"grey",
     {0.46f, 0.45f, 0.43f},
     {0.30f, 0.29f, 0.285f},
     {0.115f, 0.110f, 0.108f},
     {0.085f, 0.075f, 0.072f}},
    {"dun",
     {0.42f, 0.275f, 0.125f},
     {0.028f, 0.020f, 0.015f},
     {0.045f, 0.030f, 0.020f},
     {0.075f, 0.050f, 0.035f}},
}};

vec3 coat_color(const Coat& coat, Cover cover, vec3 p) {
  constexpr vec3 kHoof(0.075f, 0.062f, 0.050f), kEye(0.006f);
  const vec3 eye(0.094f, 1.815f, 1.075f);
  if (length(vec3(std::abs(p.x), p.y, p.z) - eye) < 0.030f) return kEye;
  const float mottle = 1.0f + 0.28f * fractal_noise(7.0f * p, 3, 91);
  if (cover == Cover::hoof) return kHoof * mottle;
  if (cover == Cover::hair)
    return coat.hair * (1.0f + 0.5f * gradient_noise(vec3(30.0f, 6.0f, 6.0f) * p, 5));
  if (cover == Cover::muzzle) return coat.muzzle;
  // From the shanks upwards, and along the belly, the hide changes gradually.
  const float down = glm::smoothstep(0.80f, 0.42f, p.y);
  const float belly = glm::smoothstep(1.02f, 0.84f, p.y) * (1.0f - down);
  const float face = glm::smoothstep(1.24f, 1.36f, p.z) * glm::smoothstep(1.64f, 1.56f, p.y);
  vec3 color = glm::mix(coat.hide, coat.shank, down);
  color = glm::mix(color, 1.25f * coat.hide, 0.5f * belly);
  return glm::mix(color, coat.muzzle, face) * mottle;
}

}  // namespace

const HorseSkeleton& horse_skeleton() {
  static const HorseSkeleton skeleton = [] {
    HorseSkeleton joints;
    joints[kCroup] = {"croup", -1, {0.0f, 1.26f, -0.46f}};
    joints[kLoin] = {"loin", kCroup, {0.0f, 1.28f, -0.20f}};
    joints[kWithers] = {"withers", kLoin, {0.0f, 1.28f, 0.14f}};
    joints[kNeck] = {"neck", kWithers, {0.0f, 1.32f, 0.44f}};
    joints[kNape] = {"nape", kNeck, {0.0f, 1.56f, 0.72f}};
    joints[kSkull] = {"skull", kNape, {0.0f, 1.82f, 0.94f}};
    constexpr std::array<vec3, kHorseTail> tail{
        vec3(0.0f, 1.38f, -0.84f), vec3(0.0f, 1.29f, -1.00f), vec3(0.0f, 1.10f, -1.10f),
        vec3(0.0f, 0.86f, -1.17f)};
    for (uint32_t i = 0; i < kHorseTail; ++i) {
      joints[kDock + i] = {"tail " + std::to_string(i + 1),
                           static_cast<int32_t>(i == 0 ? uint32_t{kCroup} : kDock + i - 1),
                           tail[i]};
    }
    constexpr std::array<vec3, kLegJoints> fore{
        vec3(0.15f, 1.30f, 0.32f), vec3(0.17f, 0.94f, 0.27f), vec3(0.155f, 0.52f, 0.35f),
        vec3(0.155f, 0.155f, 0.33f)};
    constexpr std::array<vec3, kLegJoints> hind{
        vec3(0.14f, 1.22f, -0.58f), vec3(0.175f, 0.90f, -0.42f), vec3(0.155f, 0.56f, -0.78f),
        vec3(0.155f, 0.155f, -0.69f)};
    constexpr std::array<const char*, kHorseLegCount> leg_names{"left fore", "right fore",
                                                                "left hind", "right hind"};
    constexpr std::array<const char*, kLegJoints> joint_names{"upper", "lower", "cannon",
                                                              "pastern"};
    for (uint32_t leg = 0; leg < kHorseLegCount; ++leg) {
      const LegJoints leg_joints = horse_leg(leg);
      for (uint32_t i = 0; i < kLegJoints; ++i) {
        const uint32_t trunk = leg < 2 ? kWithers : kCroup;
        joints[leg_joints[i]] = {std::string(leg_names[leg]) + " " + joint_names[i],
                                 static_cast<int32_t>(i > 0 ? leg_joints[i - 1] : trunk),
                                 mirrored((leg < 2 ? fore : hind)[i], leg % 2 == 0 ? 1.0f : -1.0f)};
      }
    }
    return joints;
  }();
  return skeleton;
}

std::vector<Mesh> make_horses(uint32_t triangles, uint32_t material) {
  const Anatomy anatomy = make_anatomy();
  std::vector<int8_t> limbs(kHorseJoints, FleshBody::kTrunk);
  for (uint32_t j = kHorseLegs; j < kHorseJoints; ++j) {
    limbs[j] = static_cast<int8_t>((j - kHorseLegs) / kLegJoints);
  }
  // Long muscles: the skin of the flanks gives way gradually.
  const FleshBody body(anatomy.flesh, std::move(limbs), {0.55f, 0.22f, 0.07f});
  // Flat soles.
  const Field field = [&](vec3 p) { return smooth_max(body.field(p), 0.004f - p.y, 0.012f); };
  ImplicitMeshConfig config;
  config.box = body.box();
  config.cell = cell_for_triangles(field, config.box, triangles);
  ImplicitMesh shape = mesh_implicit(field, config);

  const size_t count = shape.normals.size();
  std::vector<SkinWeights> weights(count);
  std::vector<Cover> covers(count);
  parallel_for(count, 512, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      weights[v] = body.skin_weights(shape.surface.positions[v]);
      covers[v] = anatomy.covers[body.nearest(shape.surface.positions[v])];
    }
  });
  Mesh first = single_part_mesh(std::move(shape.surface), material);
  first.normals = std::move(shape.normals);
  first.influences = SkinWeights::kInfluences;
  for (const SkinWeights& w : weights) {
    first.joints.insert(first.joints.end(), w.joints.begin(), w.joints.end());
    first.weights.insert(first.weights.end(), w.weights.begin(), w.weights.end());
  }
  std::vector<Mesh> horses(kCoats, first);
  for (uint32_t coat = 0; coat < kCoats; ++coat) {
    horses[coat].name = std::string(kCoatColors[coat].name) + " horse";
    horses[coat].colors.resize(count);
    parallel_for(count, 1024, [&](size_t begin, size_t end) {
      for (size_t v = begin; v < end; ++v) {
        horses[coat].colors[v] =
            vec4(coat_color(kCoatColors[coat], covers[v], first.positions[v]), 1.0f);
      }
    });
  }
  return horses;
}

}  // namespace sinew
