#include "sinew/render/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/math/random.h"
#include "sinew/render/sampling.h"

namespace sinew {
namespace {

// Where a point appears, in pixels; z is its depth in front of the eye.
vec3 project(const CameraView& camera, vec3 p, uint32_t width, uint32_t height) {
  const vec3 local = transform_point(inverse_affine(camera.to_world), p);
  const float focal = 0.5f * static_cast<float>(height) / std::tan(0.5f * camera.yfov);
  return vec3(0.5f * static_cast<float>(width) - focal * local.x / local.z,
              0.5f * static_cast<float>(height) + focal * local.y / local.z, -local.z);
}

TEST(Camera, CentreAndCornersOfThePicture) {
  CameraView camera;
  camera.yfov = 1.57079633f;
  const Ray centre = camera_ray(camera, 50.0f, 25.0f, 100, 50);
  EXPECT_NEAR(length(centre.direction - vec3(0.0f, 0.0f, -1.0f)), 0.0f, 1e-6f);
  const Ray corner = camera_ray(camera, 0.0f, 0.0f, 100, 50);  // upper left
  EXPECT_NEAR(length(corner.direction - normalize(vec3(-2.0f, 1.0f, -1.0f))), 0.0f, 1e-6f);
}

TEST(Camera, NearPlaneIsAPlane) {
  CameraView camera;
  camera.znear = 0.5f;
  for (float x : {0.0f, 31.5f, 64.0f}) {
    const Ray ray = camera_ray(camera, x, 7.0f, 64, 48);
    EXPECT_NEAR(-(ray.origin + ray.t_min * ray.direction).z, 0.5f, 1e-6f);
  }
}

TEST(Camera, OrthographicRaysAreParallel) {
  CameraView camera = look_at(vec3(0.0f, 0.0f, 5.0f), vec3(0.0f), vec3(0.0f, 1.0f, 0.0f), 0.8f);
  camera.orthographic = true;
  camera.ymag = 2.0f;
  const Ray ray = camera_ray(camera, 0.0f, 0.0f, 80, 40);
  EXPECT_NEAR(length(ray.origin - vec3(-4.0f, 2.0f, 5.0f)), 0.0f, 1e-6f);
  EXPECT_NEAR(length(ray.direction - vec3(0.0f, 0.0f, -1.0f)), 0.0f, 1e-6f);
}

TEST(Camera, LookAtPutsTheTargetInTheMiddle) {
  const vec3 eye(3.0f, 4.0f, -2.0f), target(-1.0f, 0.5f, 6.0f);
  const CameraView camera = look_at(eye, target, vec3(0.0f, 1.0f, 0.0f), 0.7f);
  const Ray ray = camera_ray(camera, 32.0f, 32.0f, 64, 64);
  EXPECT_NEAR(length(ray.direction - normalize(target - eye)), 0.0f, 1e-6f);
  EXPECT_GT(camera.to_world[1].y, 0.0f);
  const CameraView down = look_at(eye, eye - vec3(0.0f, 1.0f, 0.0f), vec3(0.0f, 1.0f, 0.0f), 0.7f);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(length(down.to_world[k]), 1.0f, 1e-6f);
}

TEST(Camera, FollowsItsNodeButNotItsScale) {
  Scene scene;
  scene.cameras.push_back({"lens", false, 0.6f, 1.0f, 0.25f});
  scene.nodes.resize(2);
  scene.nodes[1].camera = 0;
  ScenePose pose;
  pose.nodes = {
      identity_affine(),
      trs(vec3(1.0f, 2.0f, 3.0f), glm::angleAxis(1.57079633f, vec3(0.0f, 1.0f, 0.0f)), vec3(4.0f))};
  const CameraView camera = scene_camera(scene, pose, 0);
  EXPECT_FLOAT_EQ(camera.yfov, 0.6f);
  EXPECT_FLOAT_EQ(camera.znear, 0.25f);
  EXPECT_EQ(camera.to_world[3], vec3(1.0f, 2.0f, 3.0f));
  EXPECT_NEAR(length(camera.to_world[2] - vec3(1.0f, 0.0f, 0.0f)), 0.0f, 1e-6f);
}

TEST(Camera, FrameBoxSeesTheWholeBox) {
  const uint32_t seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  for (int round = 0; round < 500; ++round) {
    Box box;
    const float scale = std::pow(10.0f, random.uniform(-3.0f, 4.0f));
    for (int i = 0; i < 2; ++i) {
      box.extend(scale * vec3(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f),
                              random.uniform(-1.0f, 1.0f)));
    }
    const uint32_t width = 32 + random.next() % 400, height = 32 + random.next() % 400;
    const vec3 direction(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f),
                         random.uniform(-1.0f, 1.0f));
    const CameraView camera = frame_box(box, direction, random.uniform(0.2f, 2.0f),
                                        static_cast<float>(width) / static_cast<float>(height));
    float widest = 0.0f;  // how far out the box reaches, 1 at the picture's edge
    for (int i = 0; i < 8; ++i) {
      const vec3 corner(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                        i & 4 ? box.max.z : box.min.z);
      const vec3 p = project(camera, corner, width, height);
      ASSERT_GT(p.z, 0.0f);
      const vec2 half(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
      const vec2 out = abs(vec2(p) - half) / half;
      widest = std::max({widest, out.x, out.y});
    }
    ASSERT_LE(widest, 1.0f);
    ASSERT_GE(widest, 0.85f) << "the box should fill the picture";
  }
}

TEST(Sampling, PixelPatternIsCentredAndStratified) {
  EXPECT_EQ(hammersley(0, 1), vec2(0.5f));
  for (uint32_t n : {4u, 16u, 64u}) {
    std::vector<int> rows(n), columns(n);
    for (uint32_t i = 0; i < n; ++i) {
      const vec2 p = hammersley(i, n) * static_cast<float>(n);
      ++rows.at(static_cast<size_t>(p.x));
      ++columns.at(static_cast<size_t>(p.y));
    }
    EXPECT_EQ(rows, std::vector<int>(n, 1));
    EXPECT_EQ(columns, std::vector<int>(n, 1));
  }
}

TEST(Sampling, DirectionsFollowTheCosine) {
  for (const vec3 n :
       {vec3(0.0f, 0.0f, 1.0f), vec3(0.0f, 0.0f, -1.0f), normalize(vec3(1.0f, -2.0f, 0.5f))}) {
    constexpr uint32_t kCount = 4096;
    vec3 mean(0.0f);
    for (uint32_t i = 0; i < kCount; ++i) {
      const vec3 d = cosine_direction(n, hammersley(i, kCount));
      ASSERT_NEAR(length(d), 1.0f, 1e-5f);
      ASSERT_GE(dot(d, n), 0.0f);
      mean += d / static_cast<float>(kCount);
    }
    EXPECT_NEAR(length(mean - n * (2.0f / 3.0f)), 0.0f, 1e-3f);
  }
}

}  // namespace
}  // namespace sinew
