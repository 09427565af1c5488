#include "app/camera_choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/scene/study.h"

namespace sinew::app {
namespace {

TEST(CameraChoice, LookAtIsReadInAnyOrder) {
  const auto choice = parse_camera("eye=1,2,3,target=0,-1,0.5,fov=30");
  const auto& camera = std::get<LookAtCamera>(*choice);
  EXPECT_EQ(camera.eye, vec3(1, 2, 3));
  EXPECT_EQ(camera.target, vec3(0, -1, 0.5f));
  EXPECT_EQ(camera.fov, 30.0f);
  EXPECT_EQ(std::get<LookAtCamera>(*parse_camera("target=0,0,0,eye=1,0,0")).eye, vec3(1, 0, 0));
}

TEST(CameraChoice, OrbitTakesTwoOrThreeNumbers) {
  const OrbitCamera camera = std::get<OrbitCamera>(*parse_camera("orbit=-90,15,2"));
  EXPECT_EQ(camera.azimuth, -90.0f);
  EXPECT_EQ(camera.elevation, 15.0f);
  EXPECT_EQ(camera.zoom, 2.0f);
  EXPECT_EQ(std::get<OrbitCamera>(*parse_camera("orbit=370,0")).azimuth, 10.0f);
}

TEST(CameraChoice, AnythingElseIsACameraOfTheFile) {
  EXPECT_EQ(std::get<FileCamera>(*parse_camera("")).name, "");
  EXPECT_EQ(std::get<FileCamera>(*parse_camera("Front view")).name, "Front view");
}

TEST(CameraChoice, NonsenseIsAUsageErrorWithARemedy) {
  for (const char* text :
       {"eye=1,2,3", "target=0,0,0", "eye=1,2,target=0,0,0", "eye=1,2,3,target=1,2,3",
        "eye=a,b,c,target=0,0,0", "eye=nan,0,0,target=0,0,0", "eye=1,2,3,target=0,0,0,fov=0",
        "eye=1,2,3,target=0,0,0,fov=180", "eye=1,2,3,target=0,0,0,roll=5", "orbit=", "orbit=1",
        "orbit=1,2,3,4", "orbit=0,91", "orbit=0,0,0", "orbit=0,0,-1", "orbit=1,2,fov=3"}) {
    const auto choice = parse_camera(text);
    ASSERT_FALSE(choice.has_value()) << text;
    EXPECT_EQ(choice.error().kind, ErrorKind::usage) << text;
    EXPECT_FALSE(choice.error().remedy.empty()) << text;
  }
}

Scene some_scene() {
  return *make_study_scene("twist,triangles=1000");
}

vec3 forward(const CameraView& view) {
  return -view.to_world[2];
}

TEST(FrameCamera, OrbitsLookAtTheMiddleFromWhereTheyAreTold) {
  const Scene scene = some_scene();
  const vec3 center = animation_bounds(scene, 0, 24).center();
  const struct {
    const char* text;
    vec3 from;
  } cases[] = {{"orbit=0,0", {0, 0, 1}}, {"orbit=90,0", {1, 0, 0}}, {"orbit=0,90", {0, 1, 0}}};
  for (const auto& [text, from] : cases) {
    const auto camera = FrameCamera::choose(*parse_camera(text), scene, 0, 1.5f);
    const CameraView view = camera->view(scene, {});
    EXPECT_GT(dot(forward(view), -from), 0.9999f) << text;
    EXPECT_GT(dot(normalize(view.to_world[3] - center), from), 0.9999f) << text;
  }
}

TEST(FrameCamera, ZoomDividesTheDistance) {
  const Scene scene = some_scene();
  const vec3 center = animation_bounds(scene, 0, 24).center();
  const auto distance = [&](const char* text) {
    const auto camera = FrameCamera::choose(*parse_camera(text), scene, 0, 1.5f);
    return length(camera->view(scene, {}).to_world[3] - center);
  };
  EXPECT_NEAR(distance("orbit=20,10") / distance("orbit=20,10,2"), 2.0f, 1e-3f);
}

TEST(FrameCamera, UnknownCamerasAreListed) {
  const Scene bodies = *make_study_scene("bodies,subdivisions=2");
  const std::string name = bodies.cameras.at(0).name;
  EXPECT_TRUE(FrameCamera::choose(FileCamera{name}, bodies, 0, 1.0f).has_value());
  EXPECT_TRUE(FrameCamera::choose(FileCamera{"0"}, bodies, 0, 1.0f).has_value());
  const auto wrong = FrameCamera::choose(FileCamera{"nobody"}, bodies, 0, 1.0f);
  ASSERT_FALSE(wrong.has_value());
  EXPECT_EQ(wrong.error().kind, ErrorKind::usage);
  EXPECT_NE(wrong.error().problem.find(name), std::string::npos);
}

TEST(FrameCamera, NothingToSeeIsAnError) {
  const auto camera = FrameCamera::choose(OrbitCamera{}, Scene{}, kRestPose, 1.0f);
  ASSERT_FALSE(camera.has_value());
  EXPECT_EQ(camera.error().kind, ErrorKind::bad_input);
}

}  // namespace
}  // namespace sinew::app
