// The creature of study:creature: its body, its skin, and how it puts its feet.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "scene/study_helpers.h"
#include "scene/surface_checks.h"
#include "sinew/scene/procedural/creature_body.h"
#include "sinew/scene/procedural/creature_skeleton.h"
#include "sinew/scene/procedural/creature_walk.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/study.h"

namespace sinew {
namespace {

const Scene& small_creature() {
  static const Scene scene = *make_study_scene("creature,triangles=24000,texture=256");
  return scene;
}

size_t creature_triangles(const Scene& scene) {
  size_t sum = 0;
  for (const Mesh& mesh : scene.meshes) sum += mesh.name == "ground" ? 0 : mesh.triangles.size();
  return sum;
}

TEST(Creature, HasJointsClipsAndAboutTheTrianglesAskedFor) {
  for (const uint32_t wanted : {8000u, 40000u, 150000u}) {
    const Scene scene =
        *make_study_scene("creature,texture=256,triangles=" + std::to_string(wanted));
    EXPECT_NEAR(static_cast<double>(creature_triangles(scene)), wanted, 0.08 * wanted);
    EXPECT_GE(scene.skins[0].joints.size(), 20u);
    EXPECT_EQ(scene.clips[0].name, "Walk");
    EXPECT_EQ(scene.clips[1].name, "Look");
  }
}

TEST(Creature, BodyAndPartsAreClosed) {
  const Scene& scene = small_creature();
  for (const char* name : {"body", "armour", "eyes"}) {
    const Mesh& mesh = scene.meshes[scene.objects[object_of(scene, name)].mesh];
    EXPECT_EQ(why_not_manifold(mesh.triangles, mesh.positions.size()), "") << name;
    EXPECT_GT(signed_volume6(mesh.positions, mesh.triangles), 0.0) << name;
  }
  const Mesh& body = scene.meshes[scene.objects[object_of(scene, "body")].mesh];
  EXPECT_EQ(count_components(body.triangles, body.positions.size()), 1u);
}

TEST(Creature, BodyLiesOnItsFieldWithRoundTriangles) {
  const Scene& scene = small_creature();
  const Mesh& mesh = scene.meshes[scene.objects[object_of(scene, "body")].mesh];
  const CreatureBody body;
  for (const vec3 p : mesh.positions) ASSERT_LT(std::abs(body.field(p)), 4e-3f);
  size_t slivers = 0;
  for (const uvec3 t : mesh.triangles) {
    const vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    const float longest = std::max({length(b - a), length(c - b), length(a - c)});
    // Height over longest side: 0.87 for an equilateral triangle.
    slivers += length(cross(b - a, c - a)) < 0.15f * longest * longest;
  }
  EXPECT_LT(slivers, mesh.triangles.size() / 100);
}

TEST(Creature, NoVertexFollowsTwoLegs) {
  const Scene& scene = small_creature();
  const Mesh& mesh = scene.meshes[scene.objects[object_of(scene, "body")].mesh];
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    std::set<uint32_t> legs;
    for (uint32_t k = 0; k < mesh.influences; ++k) {
      const uint32_t joint = mesh.joints[v * mesh.influences + k];
      if (mesh.weights[v * mesh.influences + k] > 0.0f && joint >= kLegs) {
        legs.insert((joint - kLegs) / kLegJoints);
      }
    }
    ASSERT_LE(legs.size(), 1u) << "vertex " << v;
  }
}

TEST(Creature, TextureCoordinatesDoNotOverlap) {
  const Scene& scene = small_creature();
  const Mesh& mesh = scene.meshes[scene.objects[object_of(scene, "body")].mesh];
  constexpr int kSide = 512;
  std::vector<uint8_t> covered(kSide * kSide, 0);
  int overlaps = 0, texels = 0;
  const auto side_of_line = [](vec2 a, vec2 b, vec2 p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
  };
  for (const uvec3 c : mesh.corners) {
    vec2 q[3];
    for (int k = 0; k < 3; ++k) {
      q[k] = mesh.texcoords[0][c[k]] * static_cast<float>(kSide);
      ASSERT_TRUE(q[k].x >= 0.0f && q[k].y >= 0.0f && q[k].x <= kSide && q[k].y <= kSide);
    }
    const vec2 low = glm::min(q[0], glm::min(q[1], q[2])),
               high = glm::max(q[0], glm::max(q[1], q[2]));
    for (int y = static_cast<int>(low.y); y < static_cast<int>(high.y) + 1 && y < kSide; ++y) {
      for (int x = static_cast<int>(low.x); x < static_cast<int>(high.x) + 1 && x < kSide; ++x) {
        const vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        float least = 1e9f, most = -1e9f;
        for (int k = 0; k < 3; ++k) {
          const float s = side_of_line(q[k], q[(k + 1) % 3], p);
          least = std::min(least, s);
          most = std::max(most, s);
        }
        if (least < 1e-3f && most > -1e-3f) continue;  // outside, or on an edge
        overlaps += covered[y * kSide + x]++ > 0;
        ++texels;
      }
    }
  }
  EXPECT_GT(texels, kSide * kSide / 5);  // the atlas is well used
  EXPECT_LT(overlaps, texels / 500);     // folds in a chart are rare
}

// A standing foot's sole, seen from the turning disc, stays where it is.
TEST(Creature, StandingFeetDoNotSlide) {
  const Scene& scene = small_creature();
  const uint32_t object = object_of(scene, "body");
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  const Treadmill treadmill;
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    std::vector<uint32_t> sole;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
      if (mesh.joints[v * mesh.influences] == leg_joint(leg, kToes) &&
          mesh.weights[v * mesh.influences] > 0.98f && mesh.positions[v].y < 0.04f) {
        sole.push_back(v);
      }
    }
    ASSERT_GE(sole.size(), 4u);
    std::vector<vec3> planted;
    float slide = 0.0f;
    // From just after the touch-down to the end of the stance, in steps that miss the keys.
    for (double phase = 0.15 * kDutyFactor; phase < kDutyFactor; phase += 0.0137) {
      const double u = std::fmod((phase + touch_down(leg)) / kWalkStrides, 1.0);
      const std::vector<vec3> now = positions_at(scene, 0, u * kWalkSeconds, object);
      const float strides_since = static_cast<float>(phase / kWalkStrides);
      const quat back =
          glm::angleAxis(-disc_turn(treadmill, strides_since), vec3(0.0f, 1.0f, 0.0f));
      for (size_t i = 0; i < sole.size(); ++i) {
        const vec3 on_disc = back * (now[sole[i]] - treadmill.center);
        if (planted.size() < sole.size()) planted.push_back(on_disc);
        slide = std::max(slide, length(on_disc - planted[i]));
      }
    }
    EXPECT_LT(slide, 0.008f) << "leg " << leg;
  }
}

TEST(Creature, StaysAboveTheGroundAndMovesAllLegs) {
  const Scene& scene = small_creature();
  const uint32_t object = object_of(scene, "body");
  const Mesh& mesh = scene.meshes[scene.objects[object].mesh];
  for (int clip = 0; clip < 2; ++clip) {
    float lowest = 1.0f;
    for (int step = 0; step < 24; ++step) {
      const double time = scene.clips[clip].end * step / 24.0;
      for (const vec3 p : positions_at(scene, clip, time, object)) lowest = std::min(lowest, p.y);
    }
    EXPECT_GT(lowest, -0.012f) << clip;
    EXPECT_LT(lowest, 0.02f) << clip;
  }
  for (uint32_t leg = 0; leg < kCreatureLegs; ++leg) {
    float low = 1.0f, high = 0.0f;
    for (int step = 0; step < 48; ++step) {
      const CreatureFrames frames = joint_frames(walk_pose({}, static_cast<float>(step) / 48.0f));
      const float y = frames[leg_joint(leg, kToes)].position.y;
      low = std::min(low, y);
      high = std::max(high, y);
    }
    EXPECT_NEAR(low, 0.05f, 0.002f);
    EXPECT_GT(high, 0.10f);
  }
  EXPECT_EQ(mesh.influences, 4u);
}

TEST(Creature, WalkLoopsWithoutAJump) {
  const Scene& scene = small_creature();
  const uint32_t object = object_of(scene, "body");
  const std::vector<vec3> first = positions_at(scene, 0, 0.0, object);
  const std::vector<vec3> last = positions_at(scene, 0, kWalkSeconds, object);
  for (size_t v = 0; v < first.size(); ++v) ASSERT_LT(length(first[v] - last[v]), 1e-6f);
  // No vertex moves faster than a foot in its swing would.
  std::vector<vec3> before = first;
  for (int step = 1; step <= 96; ++step) {
    std::vector<vec3> now = positions_at(scene, 0, kWalkSeconds * step / 96.0, object);
    for (size_t v = 0; v < now.size(); ++v) ASSERT_LT(length(now[v] - before[v]), 0.07f);
    before = std::move(now);
  }
}

}  // namespace
}  // namespace sinew
