// study:herd: horses that run on the ground, each in its own way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "scene/study_helpers.h"
#include "scene/surface_checks.h"
#include "sinew/scene/procedural/herd.h"
#include "sinew/scene/procedural/terrain.h"
#include "sinew/scene/study.h"

namespace sinew {
namespace {

constexpr uint32_t kCount = 40;
constexpr double kSeconds = kHerdFrames / kHerdFps;

// Where a joint of a horse is in the world.
vec3 joint_at(const Gallop& gallop, double time, uint32_t joint) {
  const HorsePose pose = gallop_pose(gallop, time);
  std::array<JointFrame, kHorseJoints> frames;
  joint_frames(horse_skeleton(), pose.croup, pose.rotation, frames);
  const JointFrame body = gallop.way(time);
  return body.position + body.rotation * (gallop.scale * frames[joint].position);
}

TEST(StudyHerd, SharesMeshesAndHasASkinForEveryAnimal) {
  const Result<Scene> scene = make_study_scene("herd,count=9,triangles=10000,terrain=20000");
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->objects.size(), 10u);
  EXPECT_EQ(scene->skins.size(), 9u);
  EXPECT_EQ(scene->meshes.size(), 1u + kCoats);
  EXPECT_NEAR(static_cast<double>(count(*scene).triangles), 9 * 10000 + 20000, 0.08 * 110000);
  for (uint32_t coat = 0; coat < kCoats; ++coat) {
    const Mesh& horse = scene->meshes[1 + coat];
    EXPECT_EQ(why_not_manifold(horse.triangles, horse.positions.size()), "");
    EXPECT_EQ(count_components(horse.triangles, horse.positions.size()), 1u);
    EXPECT_GT(signed_volume6(horse.positions, horse.triangles), 0.0);
  }
}

TEST(StudyHerd, TerrainIsItsHeightfield) {
  const Mesh terrain = make_terrain(20000, 3.0f, 0);
  EXPECT_NEAR(static_cast<double>(terrain.triangles.size()), 20000.0, 300.0);
  for (const vec3 p : terrain.positions) ASSERT_EQ(p.y, terrain_height(p.x, p.z));
  for (const uvec3 t : terrain.triangles) {
    const auto& p = terrain.positions;
    ASSERT_GT(cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).y, 0.0f);
  }
  for (const vec3 n : terrain.normals) ASSERT_GT(n.y, 0.0f);
}

TEST(StudyHerd, StandingHoovesStayWhereTheyAre) {
  const float ball = horse_skeleton()[horse_leg(0)[kToes]].position.y;
  size_t stood = 0, slid = 0, flying = 0, times = 0;
  for (uint32_t i = 0; i < kCount; ++i) {
    const Gallop gallop = herd_gallop(i, kCount);
    for (double time = 0.0; time < kSeconds; time += 0.037) {
      int standing = 0;
      for (uint32_t leg = 0; leg < kHorseLegCount; ++leg) {
        const uint32_t joint = horse_leg(leg)[kToes];
        const vec3 at = joint_at(gallop, time, joint);
        const float above = at.y - terrain_height(at.x, at.z) - gallop.scale * ball;
        ASSERT_GT(above, -0.12f) << i << " at " << time;  // none goes deep into the ground
        if (!hoof_stands(gallop, leg, time)) continue;
        ++standing;
        if (!hoof_stands(gallop, leg, time + 0.01)) continue;
        ++stood;
        const vec3 later = joint_at(gallop, time + 0.01, joint);
        slid += length(later - at) > 0.02f || std::abs(above) > 0.05f;
      }
      flying += standing == 0;
      ++times;
    }
  }
  EXPECT_GT(stood, 4000u);
  EXPECT_LT(slid, stood / 20);    // where a leg does not reach
  EXPECT_GT(flying, times / 10);  // a gallop has a moment of suspension
  EXPECT_LT(flying, times / 2);
}

TEST(StudyHerd, SkinStaysAboveTheGround) {
  const Result<Scene> scene = make_study_scene("herd,count=4,triangles=4000,terrain=2000");
  ASSERT_TRUE(scene);
  for (uint32_t object = 1; object < scene->objects.size(); ++object) {
    for (const double time : {0.0, 0.3, 1.11, 2.75, 4.0}) {
      float lowest = 1e9f, highest = -1e9f;
      for (const vec3 p : positions_at(*scene, 0, time, object)) {
        lowest = std::min(lowest, p.y - terrain_height(p.x, p.z));
        highest = std::max(highest, p.y - terrain_height(p.x, p.z));
      }
      EXPECT_GT(lowest, -0.12f) << object << " at " << time;
      EXPECT_LT(lowest, 0.45f);
      EXPECT_GT(highest, 1.0f);
      EXPECT_LT(highest, 2.6f);
    }
  }
}

TEST(StudyHerd, AnimalsRunApartAndOutOfStep) {
  std::vector<Gallop> gallops;
  std::set<float> phases;
  for (uint32_t i = 0; i < kCount; ++i) {
    gallops.push_back(herd_gallop(i, kCount));
    phases.insert(std::round(20.0f * gallops[i].phase));
  }
  EXPECT_GT(phases.size(), 12u);
  for (const double time : {0.0, 1.0, 2.0, 3.0, 4.0}) {
    for (uint32_t i = 0; i < kCount; ++i) {
      const vec3 a = gallops[i].way(time).position;
      EXPECT_LT(std::abs(a.x - valley_middle(a.z)), 0.25f * kTerrainWidth);
      for (uint32_t j = 0; j < i; ++j) {
        const vec3 d = a - gallops[j].way(time).position;
        // Beside each other, or one behind the other.
        EXPECT_TRUE(std::abs(d.x) > 0.9f || std::abs(d.z) > 2.0f) << i << ", " << j << ": " << time;
      }
    }
  }
  const vec3 way = gallops[0].way(kSeconds).position - gallops[0].way(0.0).position;
  EXPECT_NEAR(way.z, 34.0f, 2.0f);
}

}  // namespace
}  // namespace sinew
