// Queries that are not closest hits: all hits, picks, nearest points, boxes; against brute force,
// in every update mode.
#include <gtest/gtest.h>

#include <algorithm>

#include "oracle.h"
#include "shapes.h"
#include "sinew/scene/study.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

constexpr UpdateMode kModes[] = {UpdateMode::full, UpdateMode::lazy};

// Balls of a key motion, some moved, turned and squeezed.
struct Balls {
  test::Shape shape = test::sphere(3);
  std::vector<vec3> keys;
  World world;
  std::vector<Affine> placements;
  std::vector<vec3> posed;  // of one ball, in its own space

  explicit Balls(UpdateMode mode) {
    keys = shape.positions;
    const auto twisted = test::twisted(shape.positions, 2.0f);
    keys.insert(keys.end(), twisted.begin(), twisted.end());
    const auto count = static_cast<uint32_t>(shape.positions.size());
    const BodyId body = *world.add_body({shape.triangles, KeyframeMotion{count, keys}, Pose()});
    world.set_update_mode(mode);
    for (int i = 0; i < 3; ++i) {
      Pose pose;
      pose.key_fraction = 0.7f;
      if (i > 0) {
        pose.placement = trs(vec3(1.5f * float(i), 0.2f, 0.0f),
                             glm::angleAxis(0.5f * float(i), vec3(0, 1, 0)), vec3(1, 0.6f, 1.3f));
      }
      placements.push_back(pose.placement);
      EXPECT_TRUE(world.set_pose(*world.add_object(body), pose));
    }
    world.commit();
    posed.resize(count);
    world.positions(0, posed);
  }
  vec3 corner(uint32_t object, uint32_t primitive, int k) const {
    return transform_point(placements[object], posed[shape.triangles[primitive][k]]);
  }
};

TEST(WorldQueries, AllHitsAreTheClosestHitsOneAfterAnother) {
  for (const UpdateMode mode : kModes) {
    const Balls balls(mode);
    Random random(17);
    size_t total = 0;
    for (int i = 0; i < 200; ++i) {
      const vec3 origin = vec3(1.5f, 0, 0) + 4.0f * random.direction();
      const vec3 target = vec3(1.5f, 0, 0) + random.uniform3(-1, 1);
      const Ray ray{.origin = origin, .direction = target - origin};
      std::vector<Hit> hits;
      balls.world.all_hits(ray, hits);
      total += hits.size();
      // Peeling: the closest hit of all that are left, by a filter.
      std::vector<Hit> peeled;
      const auto accept = [](const void* seen, uint32_t, const Hit& hit) {
        const auto& done = *static_cast<const std::vector<Hit>*>(seen);
        return std::none_of(done.begin(), done.end(), [&](const Hit& h) {
          return h.object == hit.object && h.primitive == hit.primitive;
        });
      };
      for (;;) {
        Hit hit;
        balls.world.closest_hits({&ray, 1}, {&hit, 1}, {.filter = {accept, &peeled, true}});
        if (!hit) break;
        peeled.push_back(hit);
      }
      ASSERT_EQ(hits.size(), peeled.size()) << "ray " << i << " seed 17";
      for (size_t k = 0; k < hits.size(); ++k) {
        EXPECT_EQ(hits[k].t, peeled[k].t);
        EXPECT_EQ(hits[k].object, peeled[k].object);
        EXPECT_EQ(hits[k].primitive, peeled[k].primitive);
      }
    }
    EXPECT_GT(total, 400u);
  }
}

// Of a triangle by dense sampling, which is never nearer than the true distance.
double sampled_distance(vec3 p, vec3 a, vec3 b, vec3 c) {
  constexpr int kSteps = 24;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const float u = float(i) / kSteps, v = float(j) / kSteps;
      best = std::min(best, double(length(a + u * (b - a) + v * (c - a) - p)));
    }
  }
  return best;
}

TEST(WorldQueries, TheNearestPointIsOnTheSurfaceAndNoneIsNearer) {
  for (const UpdateMode mode : kModes) {
    const Balls balls(mode);
    Random random(23);
    for (int i = 0; i < 12; ++i) {
      const vec3 from = vec3(1.5f, 0, 0) + 3.0f * random.uniform3(-1, 1);
      const auto nearest = balls.world.nearest_point(from);
      ASSERT_TRUE(nearest);
      const vec3 a = balls.corner(nearest->object, nearest->primitive, 0);
      const vec3 b = balls.corner(nearest->object, nearest->primitive, 1);
      const vec3 c = balls.corner(nearest->object, nearest->primitive, 2);
      const vec3 on = a + nearest->u * (b - a) + nearest->v * (c - a);
      EXPECT_LT(length(on - nearest->point), 1e-5f);
      EXPECT_NEAR(length(on - from), nearest->distance, 1e-5f);
      double best = std::numeric_limits<double>::infinity();
      for (uint32_t object = 0; object < 3; ++object) {
        for (uint32_t t = 0; t < balls.shape.triangles.size(); ++t) {
          best = std::min(
              best, sampled_distance(from, balls.corner(object, t, 0), balls.corner(object, t, 1),
                                     balls.corner(object, t, 2)));
        }
      }
      EXPECT_LE(nearest->distance, best + 1e-5) << "point " << i << " seed 23";
      EXPECT_GE(nearest->distance, best - 0.02);
      EXPECT_FALSE(balls.world.nearest_point(from, 0.99f * nearest->distance));
    }
    EXPECT_FALSE(balls.world.nearest_point(vec3(NAN)));
  }
}

TEST(WorldQueries, ABoxHoldsTheTrianglesThatHaveAPointInIt) {
  for (const UpdateMode mode : kModes) {
    const Balls balls(mode);
    Random random(29);
    size_t total = 0;
    for (int i = 0; i < 30; ++i) {
      const vec3 center = vec3(1.5f, 0, 0) + 1.8f * random.uniform3(-1, 1);
      const Box box{center - random.uniform3(0.05f, 0.5f), center + random.uniform3(0.05f, 0.5f)};
      std::vector<TriangleId> found;
      balls.world.triangles_in_box(box, found);
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
      total += found.size();
      for (uint32_t object = 0; object < 3; ++object) {
        for (uint32_t t = 0; t < balls.shape.triangles.size(); ++t) {
          const vec3 a = balls.corner(object, t, 0), b = balls.corner(object, t, 1),
                     c = balls.corner(object, t, 2);
          bool inside = false;
          for (int u = 0; u <= 8; ++u) {
            for (int v = 0; u + v <= 8; ++v) {
              inside |= box.contains(a + float(u) / 8 * (b - a) + float(v) / 8 * (c - a));
            }
          }
          Box bounds;
          for (const vec3 p : {a, b, c}) bounds.extend(p);
          const bool apart = glm::any(glm::greaterThan(bounds.min, box.max)) ||
                             glm::any(glm::lessThan(bounds.max, box.min));
          const bool reported =
              std::binary_search(found.begin(), found.end(), TriangleId{object, t});
          EXPECT_FALSE(inside && !reported) << object << " " << t << " box " << i << " seed 29";
          EXPECT_FALSE(apart && reported) << object << " " << t << " box " << i << " seed 29";
        }
      }
    }
    EXPECT_GT(total, 100u);
  }
}

TEST(WorldQueries, APickNamesTheJointsThatMoveThePoint) {
  const Scene scene = *make_study_scene("creature,triangles=8000");
  for (const UpdateMode mode : kModes) {
    World world = *prepare(scene, {.update = mode});
    ASSERT_TRUE(world.set_time(0.4));
    size_t picks = 0, with_joints = 0;
    Random random(37);
    for (int i = 0; i < 200; ++i) {
      const vec3 origin = world.box().center() + 10.0f * random.direction();
      const Ray ray{.origin = origin, .direction = random.uniform3(-0.6f, 0.6f) - origin};
      const auto pick = world.pick(ray);
      if (!pick) continue;
      ++picks;
      const auto corners = world.triangle(pick->hit.object, pick->hit.primitive);
      vec3 at(0.0f);
      for (int k = 0; k < 3; ++k) at += pick->barycentrics[k] * corners[k];
      const vec3 placed = transform_point(world.placement(pick->hit.object), at);
      EXPECT_LT(length(placed - pick->point), 1e-3f);
      if (pick->joints.empty()) continue;
      ++with_joints;
      float sum = 0.0f, last = 2.0f;
      for (const JointWeight& j : pick->joints) {
        EXPECT_LE(j.weight, last);
        last = j.weight;
        sum += j.weight;
      }
      EXPECT_NEAR(sum, 1.0f, 1e-5f);
    }
    EXPECT_GT(picks, 20u);
    EXPECT_GT(with_joints, 5u);
  }
}

}  // namespace
}  // namespace sinew
