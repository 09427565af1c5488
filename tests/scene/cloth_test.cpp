// study:cloth and its simulation: what cloth does not do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "scene/study_helpers.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/cloth_simulation.h"
#include "sinew/scene/study.h"

namespace sinew {
namespace {

// 50 by 50 cells: small, and long enough to lie on the ground at the end.
const Scene& small_cloth() {
  static const Scene scene = [] {
    Result<Scene> made = make_study_scene("cloth,triangles=5000,frames=94");
    EXPECT_TRUE(made);
    return std::move(*made);
  }();
  return scene;
}

std::span<const vec3> key(const Mesh& mesh, uint32_t k) {
  return std::span(mesh.key_positions).subspan(k * mesh.positions.size(), mesh.positions.size());
}

// Distance from the surface of the ball, which stands on the ground.
float from_ball(vec3 p) {
  const ClothConfig config;
  return length(p - config.ball) - config.ball_radius;
}

TEST(StudyCloth, HasTheTrianglesAndFramesOfThePaper) {
  const Result<Scene> scene = make_study_scene("cloth,frames=2");
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->meshes[0].triangles.size(), 92450u);
  EXPECT_EQ(scene->meshes[0].keys, 3u);
  EXPECT_EQ(make_study_scene("cloth,triangles=200")->default_frames, 94);
  const Result<Scene> huge = make_study_scene("cloth,triangles=1000000,frames=1000");
  ASSERT_FALSE(huge);
  EXPECT_EQ(huge.error().kind, ErrorKind::usage);
}

TEST(StudyCloth, NeverGetsIntoTheBallOrTheGround) {
  const Mesh& mesh = small_cloth().meshes[0];
  for (uint32_t k = 0; k < mesh.keys; ++k) {
    for (const vec3 p : key(mesh, k)) {
      ASSERT_GT(from_ball(p), 0.0055f) << "key " << k;
      ASSERT_GT(p.y, 0.0055f) << "key " << k;
    }
  }
  // Between keys, where vertices go straight, and in the middles of triangles.
  for (uint32_t k = 0; k + 1 < mesh.keys; ++k) {
    const std::span<const vec3> a = key(mesh, k), b = key(mesh, k + 1);
    for (size_t v = 0; v < a.size(); ++v) ASSERT_GT(from_ball(0.5f * (a[v] + b[v])), -0.002f);
    for (const uvec3 t : mesh.triangles) {
      ASSERT_GT(from_ball((a[t.x] + a[t.y] + a[t.z]) / 3.0f), 0.004f);
    }
  }
}

TEST(StudyCloth, HardlyStretches) {
  const Mesh& mesh = small_cloth().meshes[0];
  const std::span<const vec3> rest = key(mesh, 0);
  for (uint32_t k = 0; k < mesh.keys; k += 4) {
    const std::span<const vec3> at = key(mesh, k);
    std::vector<float> stretch;
    for (const uvec3 t : mesh.triangles) {
      for (int e = 0; e < 3; ++e) {
        const uint32_t a = t[e], b = t[(e + 1) % 3];
        stretch.push_back(length(at[a] - at[b]) / length(rest[a] - rest[b]));
      }
    }
    std::ranges::sort(stretch);
    EXPECT_NEAR(stretch[stretch.size() / 2], 1.0f, 0.02f) << "key " << k;
    EXPECT_LT(stretch[stretch.size() * 99 / 100], 1.10f) << "key " << k;
    EXPECT_LT(stretch.back(), 1.35f) << "key " << k;
  }
}

TEST(StudyCloth, FallsOverTheBallAndSlidesToTheGround) {
  const Mesh& mesh = small_cloth().meshes[0];
  const auto touching = [&](uint32_t k) {
    return std::ranges::count_if(key(mesh, k), [](vec3 p) { return from_ball(p) < 0.01f; });
  };
  const auto lying = [&](uint32_t k) {
    return std::ranges::count_if(key(mesh, k), [](vec3 p) { return p.y < 0.3f; });
  };
  const auto all = static_cast<long>(mesh.positions.size());
  EXPECT_EQ(touching(0), 0);
  EXPECT_EQ(lying(0), 0);
  EXPECT_GT(touching(22), all / 6);  // draped
  EXPECT_GT(lying(mesh.keys - 1), all * 17 / 20);
}

TEST(StudyCloth, LayersStayApart) {
  const Mesh& mesh = small_cloth().meshes[0];
  constexpr int kColumns = 51;
  const float spacing = length(mesh.positions[1] - mesh.positions[0]);
  for (const uint32_t k : {30u, 60u, 94u}) {
    const std::span<const vec3> at = key(mesh, k);
    size_t met = 0, close = 0;  // points of other parts within a cell, and within half of one
    for (int i = 0; i < static_cast<int>(at.size()); ++i) {
      for (int j = 0; j < i; ++j) {
        const bool beside = std::abs(i / kColumns - j / kColumns) <= 2 &&
                            std::abs(i % kColumns - j % kColumns) <= 2;
        const float distance = length(at[i] - at[j]);
        if (beside || distance > spacing) continue;
        ++met;
        close += distance < 0.5f * spacing;
      }
    }
    if (k == 94) {
      EXPECT_GT(met, 200u);  // it lies in folds
    }
    EXPECT_LE(close, met / 50) << "key " << k << ", " << met;
  }
}

TEST(StudyCloth, SameBitsForAnyThreadCount) {
  ClothConfig config;
  config.cells = 70;
  config.frames = 16;
  const std::vector<vec3> many = simulate_cloth(config);
  const ThreadLimit one(1);
  EXPECT_EQ(simulate_cloth(config), many);
}

}  // namespace
}  // namespace sinew
