// study:cell24: the polytope, its tubes, and how they turn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/study_helpers.h"
#include "scene/surface_checks.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/study.h"

namespace sinew {
namespace {

constexpr double kFrame = 1.0 / 25.0;

// First vertices of the connected pieces, and the number of vertices; pieces lie one after another.
std::vector<size_t> piece_bounds(const Mesh& mesh) {
  std::vector<uint32_t> least(mesh.positions.size());
  for (uint32_t v = 0; v < least.size(); ++v) least[v] = v;
  for (bool changed = true; changed;) {
    changed = false;
    for (const uvec3 t : mesh.triangles) {
      const uint32_t low = std::min({least[t.x], least[t.y], least[t.z]});
      for (int k = 0; k < 3; ++k) {
        changed |= least[t[k]] != low;
        least[t[k]] = low;
      }
    }
  }
  std::vector<size_t> bounds;
  for (uint32_t v = 0; v < least.size(); ++v) {
    if (least[v] == v) bounds.push_back(v);
  }
  bounds.push_back(least.size());
  return bounds;
}

vec3 mean(const std::vector<vec3>& points, size_t begin, size_t end) {
  glm::dvec3 sum(0.0);
  for (size_t i = begin; i < end; ++i) sum += glm::dvec3(points[i]);
  return vec3(sum / static_cast<double>(end - begin));
}

TEST(StudyCell24, HasTheTrianglesOfThePaperInClosedPieces) {
  const Result<Scene> scene = make_study_scene("cell24");
  ASSERT_TRUE(scene);
  const Mesh& cell = scene->meshes[0];
  EXPECT_EQ(cell.triangles.size(), 122880u);
  EXPECT_EQ(scene->default_frames, 128);
  EXPECT_EQ(why_not_manifold(cell.triangles, cell.positions.size()), "");
  EXPECT_EQ(count_components(cell.triangles, cell.positions.size()), 96u + 24u);
  for (const double time : {0.0, 1.7, 4.4}) {
    EXPECT_GT(signed_volume6(positions_at(*scene, 0, time, 0), cell.triangles), 0.0);
  }
}

TEST(StudyCell24, EveryCornerEndsEightTubesAtAllTimes) {
  const Result<Scene> scene = make_study_scene("cell24,triangles=10000");
  ASSERT_TRUE(scene);
  const std::vector<size_t> bounds = piece_bounds(scene->meshes[0]);
  ASSERT_EQ(bounds.size(), 121u);
  for (const double time : {0.0, 0.9, 2.3, 5.0}) {
    const std::vector<vec3> at = positions_at(*scene, 0, time, 0);
    std::vector<int> ends(24, 0);
    for (size_t tube = 0; tube < 96; ++tube) {
      for (const size_t pole : {bounds[tube + 1] - 2, bounds[tube + 1] - 1}) {
        for (size_t corner = 0; corner < 24; ++corner) {
          const vec3 middle = mean(at, bounds[96 + corner], bounds[97 + corner]);
          ends[corner] += length(middle - at[pole]) < 1e-4f;
        }
      }
    }
    EXPECT_EQ(std::ranges::count(ends, 8), 24) << time;
  }
}

TEST(StudyCell24, TubesTurnWithoutFlips) {
  const Result<Scene> scene = make_study_scene("cell24,triangles=10000");
  ASSERT_TRUE(scene);
  const std::vector<size_t> bounds = piece_bounds(scene->meshes[0]);
  std::vector<vec3> sides_before;
  float least = 1.0f, farthest = 0.0f;
  std::vector<vec3> before;
  for (int frame = 0; frame <= 128; ++frame) {
    const std::vector<vec3> at = positions_at(*scene, 0, kFrame * frame, 0);
    std::vector<vec3> sides;  // from a tube's end to the first vertex around it
    for (size_t tube = 0; tube < 96; ++tube) {
      sides.push_back(normalize(at[bounds[tube]] - at[bounds[tube + 1] - 2]));
    }
    for (size_t tube = 0; frame > 0 && tube < 96; ++tube) {
      least = std::min(least, dot(sides[tube], sides_before[tube]));
    }
    for (size_t v = 0; frame > 0 && v < at.size(); ++v) {
      farthest = std::max(farthest, length(at[v] - before[v]));
    }
    sides_before = sides;
    before = at;
  }
  EXPECT_GT(least, 0.9f);      // 25 degrees a frame
  EXPECT_LT(farthest, 0.30f);  // metres a frame
}

TEST(StudyCell24, LoopsAndItsKeysAreItsFrames) {
  const Result<Scene> free = make_study_scene("cell24,triangles=10000");
  const Result<Scene> keys = make_study_scene("cell24,triangles=10000,motion=keys");
  ASSERT_TRUE(free && keys);
  EXPECT_EQ(keys->meshes[0].keys, 129u);
  const std::vector<vec3> start = positions_at(*free, 0, 0.0, 0);
  const std::vector<vec3> end = positions_at(*free, 0, free->clips[0].end, 0);
  for (size_t v = 0; v < start.size(); ++v) ASSERT_LT(length(end[v] - start[v]), 1e-4f);
  for (const int frame : {0, 17, 64, 127, 128}) {
    const std::vector<vec3> a = positions_at(*free, 0, kFrame * frame, 0);
    const std::vector<vec3> b = positions_at(*keys, 0, kFrame * frame, 0);
    for (size_t v = 0; v < a.size(); ++v) ASSERT_LT(length(a[v] - b[v]), 1e-4f) << frame;
  }
}

TEST(StudyCell24, SameBitsForAnyThreadCount) {
  const Result<Scene> scene = make_study_scene("cell24,triangles=30000");
  ASSERT_TRUE(scene);
  const std::vector<vec3> many = positions_at(*scene, 0, 1.234, 0);
  const ThreadLimit one(1);
  EXPECT_EQ(positions_at(*scene, 0, 1.234, 0), many);
}

}  // namespace
}  // namespace sinew
