// Views as frames: rectangles of triangles on the screen, against projected samples and rays.
#include "sinew/bvh/frames/camera_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "shapes.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

constexpr float kNear = 0.1f;

// At the origin, looking along -Z, 90 degrees wide and high: (x, y, z) is seen at (x, y) / -z.
mat4 camera_at_origin() {
  return glm::infinitePerspective(glm::radians(90.0f), 1.0f, kNear);
}

std::vector<Box> boxes_of(const test::Shape& shape, const mat4& m) {
  std::vector<Box> boxes(shape.triangles.size());
  view_boxes(shape.positions, shape.triangles, m, boxes);
  return boxes;
}

Box box_of(vec3 a, vec3 b, vec3 c, const mat4& m = camera_at_origin()) {
  return boxes_of({{a, b, c}, {{0, 1, 2}}}, m)[0];
}

void expect_rectangle(const Box& box, float x0, float y0, float x1, float y1) {
  EXPECT_NEAR(box.min.x, x0, 1e-6);
  EXPECT_NEAR(box.min.y, y0, 1e-6);
  EXPECT_NEAR(box.max.x, x1, 1e-6);
  EXPECT_NEAR(box.max.y, y1, 1e-6);
  EXPECT_EQ(box.min.z, 0.0f);
  EXPECT_EQ(box.max.z, 0.0f);
}

TEST(CameraFrames, RectanglesByHand) {
  // Two metres away everything is half as large.
  const Box box = box_of({-1, 0, -2}, {1, 0.5f, -2}, {0, 1, -2});
  expect_rectangle(box, -0.5f, 0.0f, 0.5f, 0.5f);
  EXPECT_FLOAT_EQ(half_area(box), 0.5f);  // 1 x 0.5
  // Partly beside the screen: x from 0.5 to 2 is seen up to 1.
  expect_rectangle(box_of({1, 0, -2}, {4, 0, -2}, {1, 1, -2}), 0.5f, 0.0f, 1.0f, 0.5f);
}

TEST(CameraFrames, WhatIsNotSeenHasNoArea) {
  const Box beside = box_of({-5, -1, -2}, {-4, 1, -2}, {-6, 0, -2});
  expect_rectangle(beside, -1.0f, -0.5f, -1.0f, 0.5f);
  EXPECT_EQ(half_area(beside), 0.0f);
  // Behind, to the upper right: x + y of the corners is (6, 3).
  const Box behind = box_of({2, 1, 1}, {3, 1, 2}, {1, 1, 3});
  expect_rectangle(behind, 1.0f, 0.5f, 1.0f, 0.5f);
  // Exactly behind: some point of the border.
  const Box back = box_of({0, 0, 1}, {1, 0, 2}, {-1, 0, 2});
  EXPECT_EQ(std::max(std::abs(back.min.x), std::abs(back.min.y)), 1.0f);
  EXPECT_EQ(half_area(back), 0.0f);
  EXPECT_TRUE(box_of({0, NAN, -1}, {1, 0, -1}, {0, 1, -1}).empty());
}

TEST(CameraFrames, TrianglesAreCutAtTheNearPlane) {
  // From (0, -1, -1), seen at (0, -1), backwards under the eye: the part before the near plane,
  // 0.1 away, is seen at y = -10 and below, beyond the border; x is 0 all along.
  expect_rectangle(box_of({0, -1, -1}, {0, -1, 1}, {0, -1, 3}), 0.0f, -1.0f, 0.0f, -1.0f);
  // A line from (0, 0, -1) to (1, 0, 1) is 0.1 away at x = 0.45, seen at 4.5: to the border.
  // Without the cut the corner behind would be seen at -1.
  expect_rectangle(box_of({0, 0, -1}, {1, 0, 1}, {0, 0, -1}), 0.0f, 0.0f, 1.0f, 0.0f);
  // The same with the near plane 0.8 away: there x = 0.1, seen at 0.125.
  const mat4 far_plane = glm::infinitePerspective(glm::radians(90.0f), 1.0f, 0.8f);
  expect_rectangle(box_of({0, 0, -1}, {1, 0, 1}, {0, 0, -1}, far_plane), 0, 0, 0.125f, 0);
  // Orthographic: w is 1, only the near plane cuts. Half of the line is seen.
  const mat4 flat = glm::ortho(-2.0f, 2.0f, -2.0f, 2.0f, 0.0f, 10.0f);
  expect_rectangle(box_of({0, 0, -1}, {1, 0, 1}, {0, 0, -1}, flat), 0, 0, 0.25f, 0);
}

// Every camera and many triangles, near ones among them: where a ray through a point of the screen
// meets a triangle, its rectangle contains the point; and the rectangle is no larger than the
// outline, which is followed in small steps.
TEST(CameraFrames, ContainsWhatRaysMeetAndIsTight) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const test::Shape shape = test::random_triangles(300, seed, 0.6f);
    const vec3 eye = random.uniform3(0.0f, 1.0f);  // in the middle of them
    const vec3 target = random.uniform3(-1.0f, 2.0f);
    const mat4 view = glm::lookAt(eye, target, vec3(0, 1, 0));
    const mat4 m = glm::infinitePerspective(1.0f, 1.5f, kNear) * view;
    const std::vector<Box> boxes = boxes_of(shape, m);
    int crossing = 0, seen = 0;
    for (size_t i = 0; i < boxes.size(); ++i) {
      Box outline;
      bool cut = false;
      const uvec3 t = shape.triangles[i];
      for (int k = 0; k < 3; ++k) {
        const vec3 a = shape.positions[t[k]], b = shape.positions[t[(k + 1) % 3]];
        for (int step = 0; step <= 2000; ++step) {
          const vec4 c = m * vec4(glm::mix(a, b, static_cast<float>(step) / 2000.0f), 1.0f);
          if (c.z < -c.w) {
            cut = true;
            continue;
          }
          outline.extend(vec3(glm::clamp(vec2(c) / c.w, -1.0f, 1.0f), 0.0f));
        }
      }
      crossing += cut && !outline.empty() ? 1 : 0;
      seen += outline.empty() ? 0 : 1;
      if (outline.empty()) {
        EXPECT_LT(half_area(boxes[i]), 1e-2f) << i;
        continue;
      }
      // A step along an edge moves by at most 1.2 * 2 / 2000 metres, at the near plane 0.1 away.
      const float step = cut ? 0.05f : 2e-6f;
      for (int axis = 0; axis < 2; ++axis) {
        EXPECT_LE(boxes[i].min[axis], outline.min[axis] + 2e-6f) << i;
        EXPECT_GE(boxes[i].max[axis], outline.max[axis] - 2e-6f) << i;
        EXPECT_GE(boxes[i].min[axis], outline.min[axis] - step) << i;
        EXPECT_LE(boxes[i].max[axis], outline.max[axis] + step) << i;
      }
    }
    EXPECT_GT(crossing, 10);
    EXPECT_GT(seen, 50);

    const mat4 to_world = glm::inverse(view);
    int hits = 0;
    for (int r = 0; r < 500; ++r) {
      const float x = random.uniform(-1.0f, 1.0f);
      const float y = random.uniform(-1.0f, 1.0f);
      const float high = std::tan(0.5f);
      const vec3 d = vec3(to_world * vec4(1.5f * high * x, high * y, -1.0f, 0.0f));
      for (size_t i = 0; i < boxes.size(); ++i) {
        const uvec3 t = shape.triangles[i];
        const vec3 a = shape.positions[t.x], u = shape.positions[t.y] - a,
                   v = shape.positions[t.z] - a;
        const glm::dmat3 system(glm::dvec3(u), glm::dvec3(v), -glm::dvec3(d));
        if (std::abs(glm::determinant(system)) < 1e-9) continue;
        const glm::dvec3 at = glm::inverse(system) * glm::dvec3(eye - a);
        if (at.x < 1e-4 || at.y < 1e-4 || at.x + at.y > 1 - 1e-4 || at.z < kNear * 1.001) continue;
        ++hits;
        EXPECT_TRUE(x >= boxes[i].min.x - 1e-5f && x <= boxes[i].max.x + 1e-5f &&
                    y >= boxes[i].min.y - 1e-5f && y <= boxes[i].max.y + 1e-5f)
            << i;
      }
    }
    EXPECT_GT(hits, 100);
  }
}

// The cost of a view's frame times its share of the screen is what a primary ray costs on average:
// 3 for each inner node whose rectangle holds its point of the screen, 2 for each leaf.
TEST(CameraFrames, CostIsThatOfPrimaryRays) {
  const test::Shape shape = test::random_triangles(200, 9, 0.1f);
  const mat4 m = glm::infinitePerspective(0.8f, 1.0f, kNear) *
                 glm::lookAt(vec3(0.5f, 0.5f, 4.0f), vec3(0.9f, 0.5f, 0.0f), vec3(0, 1, 0));
  FrameBoxes frames = make_frame_boxes({boxes_of(shape, m)});
  const Tree tree = build_binned(frames.frames[0], {.max_leaf = 1});
  const double share = screen_share(frames.frames[0]);
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.6);
  const double expected = share * frame_costs(tree, frames)[0];

  const Bounds bounds = refit(tree, frames.frames[0]);
  Random random(4);
  constexpr int kRays = 20000;
  double sum = 0.0;
  for (int r = 0; r < kRays; ++r) {
    const float x = random.uniform(-1.0f, 1.0f);
    const float y = random.uniform(-1.0f, 1.0f);
    for (size_t n = 0; n < bounds.size(); ++n) {
      if (bounds[n].contains(vec3(x, y, 0.0f))) sum += tree.nodes[n].is_leaf() ? 2.0 : 3.0;
    }
  }
  EXPECT_NEAR(sum / kRays, expected, 0.05 * expected);
}

TEST(CameraFrames, ViewsGetTheirShare) {
  const auto square = [](float size) {  // two primitives that cover (2 size)^2 of the screen's 4
    return std::vector<Box>{{vec3(-size, -size, 0), vec3(0)}, {vec3(0), vec3(size, size, 0)}};
  };
  const std::vector<Box> cubes = {{vec3(0), vec3(1)}, {vec3(2), vec3(3)}};
  FrameBoxes frames = make_frame_boxes({cubes, cubes});
  // Shares of the screen: 1, 0.25, 0. With weights 1 and 4 the first two count the same.
  append_view_frames(frames, {{square(1.0f), 1.0}, {square(0.5f), 4.0}, {square(0.0f), 9.0}}, 0.4);
  EXPECT_EQ(frames.frame_count(), 4u);
  const std::vector<double> expected = {0.3, 0.3, 0.2, 0.2};
  for (size_t f = 0; f < 4; ++f) EXPECT_NEAR(frames.weights[f], expected[f], 1e-12);

  const std::vector<double> before = frames.weights;
  append_view_frames(frames, {{square(0.0f), 1.0}}, 0.5);  // shows nothing
  append_view_frames(frames, {{square(1.0f), 1.0}}, 0.0);  // counts nothing
  append_view_frames(frames, {}, 0.5);
  EXPECT_EQ(frames.weights, before);
}

TEST(CameraFrames, TrianglesThatAreNotFiniteComeFromOtherViews) {
  const std::vector<Box> whole = {{vec3(-1, -1, 0), vec3(0)}, {vec3(0), vec3(1, 1, 0)}};
  std::vector<Box> torn = whole;
  torn[1] = Box();
  FrameBoxes frames = make_frame_boxes({whole});
  append_view_frames(frames, {{whole, 1.0}, {torn, 1.0}}, 0.5);
  ASSERT_EQ(frames.frame_count(), 3u);
  EXPECT_EQ(frames.frames[2][1].max, whole[1].max);
}

}  // namespace
}  // namespace sinew
