// The three scenes of BART: what their files say of themselves, and the whole of their animations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sinew/io/aff/animated.h"
#include "sinew/io/load.h"
#include "sinew/scene/sample.h"
#include "test_data.h"

namespace sinew {
namespace {

constexpr float kPi = 3.14159265f;

Scene load_scene(const std::string& input) {
  Result<Scene> scene = load(input);
  EXPECT_TRUE(scene) << scene.error().message();
  return scene ? std::move(*scene) : Scene{};
}

bool is_named(const Scene& scene, const SceneObject& object, const std::string& name) {
  return scene.nodes[object.node].name == name;
}

Box bounds_of(const Scene& scene, const std::string& name) {
  ScenePose pose;
  sample(scene, 0, scene.clips[0].start, pose);
  Box box;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (!is_named(scene, scene.objects[i], name)) continue;
    std::vector<vec3> positions(scene.meshes[scene.objects[i].mesh].positions.size());
    world_positions(scene, pose, i, positions);
    for (const vec3& p : positions) box.extend(p);
  }
  EXPECT_FALSE(box.empty()) << name;
  return box;
}

// The camera's place and direction in every frame.
struct CameraPath {
  std::vector<vec3> places;
  std::vector<vec3> directions;
  std::vector<vec3> ups;
};

CameraPath camera_path(const Scene& scene) {
  const auto camera =
      std::ranges::find_if(scene.nodes, [](const Node& node) { return node.camera >= 0; });
  const size_t index = static_cast<size_t>(camera - scene.nodes.begin());
  CameraPath path;
  ScenePose pose;
  for (int32_t frame = 0; frame < scene.default_frames; ++frame) {
    sample(scene, 0, scene.clips[0].start + frame / scene.default_fps, pose);
    EXPECT_EQ(pose.absent, 0u) << "frame " << frame;
    const Affine& node = pose.nodes[index];
    EXPECT_NEAR(length(node[2]), 1.0f, 1e-4f);
    path.places.push_back(node[3]);
    path.directions.push_back(-node[2]);
    path.ups.push_back(node[1]);
  }
  return path;
}

// How far the camera moves and turns (degrees) from one frame to the next, and how much its turning
// changes: nothing may jump.
void expect_smooth(const CameraPath& path, float longest_step, float largest_turn,
                   float largest_change) {
  vec3 last_turn(0.0f);
  for (size_t i = 1; i < path.places.size(); ++i) {
    EXPECT_LE(distance(path.places[i], path.places[i - 1]), longest_step) << "frame " << i + 1;
    const vec3 turn = (path.directions[i] - path.directions[i - 1]) * (180.0f / kPi);
    EXPECT_LE(length(turn), largest_turn) << "frame " << i + 1;
    if (i > 1) {
      EXPECT_LE(distance(turn, last_turn), largest_change) << "frame " << i + 1;
    }
    EXPECT_GT(path.ups[i].y, 0.0f) << "upside down in frame " << i + 1;
    last_turn = turn;
  }
}

TEST(Bart, Kitchen) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_kitchen/aff/kitchen.aff");
  const Scene scene = load_scene(file);
  EXPECT_EQ(count(scene).triangles, 110'561u);  // T-SAH: 110.5k
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
  EXPECT_EQ(scene.images.size(), 8u);
  EXPECT_EQ(scene.lights.size(), 6u);
  EXPECT_EQ(scene.default_frames, 800);
  EXPECT_EQ(scene.clips[0].end, 20.0);
  EXPECT_FLOAT_EQ(scene.cameras[0].yfov, glm::radians(40.0f));
  EXPECT_TRUE(std::ranges::any_of(scene.materials, [](const Material& material) {
    return material.transmission > 0.5f && !material.thin && material.ior == 1.55f;
  })) << "glass";

  const Box walls = bounds_of(scene, "walls"), floor = bounds_of(scene, "floor");
  const CameraPath path = camera_path(scene);
  for (const vec3& eye : path.places) {
    EXPECT_TRUE(eye.x > walls.min.x && eye.x < walls.max.x && eye.y > floor.max.y &&
                eye.y < walls.max.y && eye.z > walls.min.z && eye.z < walls.max.z)
        << eye.x << " " << eye.y << " " << eye.z;
  }
  expect_smooth(path, 0.15f, 12.0f, 2.7f);
}

TEST(Bart, TheToyCarKeepsItsWheelsAndStaysOnTheFloor) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_kitchen/aff/kitchen.aff");
  const Scene scene = load_scene(file);
  ScenePose pose;
  for (double time = 0.0; time <= 19.7; time += 0.1) {
    sample(scene, 0, time, pose);
    Box body, wheels;
    int wheel_count = 0;
    for (uint32_t i = 0; i < scene.objects.size(); ++i) {
      const bool wheel = is_named(scene, scene.objects[i], "car_wheel") ||
                         scene.nodes[scene.objects[i].node].name.find("wheel") != std::string::npos;
      const bool car = is_named(scene, scene.objects[i], "car");
      if (!wheel && !car) continue;
      wheel_count += wheel;
      std::vector<vec3> positions(scene.meshes[scene.objects[i].mesh].positions.size());
      world_positions(scene, pose, i, positions);
      for (const vec3& p : positions) (wheel ? wheels : body).extend(p);
    }
    ASSERT_EQ(wheel_count, 4);
    EXPECT_NEAR(wheels.min.y, 0.0f, 0.02f) << time;
    EXPECT_LT(distance(wheels.center(), body.center()), 0.15f) << time;
    EXPECT_LT(body.min.y, wheels.max.y) << time;
  }
}

TEST(Bart, Robots) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_robot/aff/Robot.aff");
  const Scene scene = load_scene(file);
  EXPECT_EQ(count(scene).triangles, 71'708u);  // T-SAH: 71.5k, without 128 of no area
  EXPECT_EQ(scene.warnings.size(), 2u) << "the gun of robot 1 and the old camera";
  EXPECT_EQ(scene.meshes.size(), 23u) << "ten robots share their parts";
  EXPECT_EQ(scene.images.size(), 44u);
  EXPECT_EQ(scene.default_frames, 800);

  const Box city = bounds_of(scene, "city2");
  const CameraPath path = camera_path(scene);
  for (const vec3& eye : path.places) {
    EXPECT_TRUE(eye.y > 0.0f && eye.y < city.max.y && std::abs(eye.x) < city.max.x &&
                eye.z > city.min.z && eye.z < city.max.z)
        << eye.x << " " << eye.y << " " << eye.z;
  }
  expect_smooth(path, 2.0f, 5.0f, 1.5f);
}

// Limbs hang on their joints: a part and the one it is attached to keep their distance.
TEST(Bart, RobotsKeepTheirLimbs) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_robot/aff/Robot.aff");
  const Scene scene = load_scene(file);
  ScenePose pose;
  for (double time = 0.0; time <= 50.0; time += 1.0) {
    sample(scene, 0, time, pose);
    int robots = 0;
    vec3 body(0.0f);
    for (uint32_t i = 0; i < scene.objects.size(); ++i) {
      if (is_named(scene, scene.objects[i], "city2")) continue;
      const Mesh& mesh = scene.meshes[scene.objects[i].mesh];
      Box box;
      for (const vec3& p : mesh.positions)
        box.extend(transform_point(pose.nodes[scene.objects[i].node], p));
      if (mesh.name == "ro_arm") {  // the first part of a robot
        ++robots;
        body = box.center();
      }
      EXPECT_LT(distance(box.center(), body), 16.0f) << mesh.name << " at " << time;
      EXPECT_GT(box.min.y, -1.5f) << mesh.name << " at " << time;
    }
    EXPECT_EQ(robots, 10);
  }
}

TEST(Bart, Museum) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_museum/aff/museum5.aff");
  const Scene scene = load_scene(file);
  // Polygons: 10,143 (10,000 triangles, 10 textured ones and 133 polygons); 8 cones; 1,024
  // animated.
  std::map<std::string, size_t> triangles;
  for (const Mesh& mesh : scene.meshes) triangles[mesh.name] += mesh.triangles.size();
  EXPECT_EQ(triangles["pillar"], 10'000u);
  EXPECT_EQ(triangles["animart5"], 1'024u);
  EXPECT_EQ(count(scene).triangles - 8 * 64 - 1'024, 10'284u);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.images.size(), 5u);

  // A drum of radius 5 with a passage towards -z.
  const Box room = bounds_of(scene, "room");
  for (const vec3& eye : camera_path(scene).places) {
    const bool in_drum = std::hypot(eye.x, eye.z) < 5.0f;
    const bool in_passage = std::abs(eye.x) < 1.0f && eye.z < -4.0f && eye.z > room.min.z;
    EXPECT_TRUE((in_drum || in_passage) && eye.y > 0.0f && eye.y < 5.0f)
        << eye.x << " " << eye.y << " " << eye.z;
  }
  expect_smooth(camera_path(scene), 0.26f, 7.0f, 0.8f);
}

TEST(Bart, MuseumOfComplexity8) {
  SINEW_DATA_OR_SKIP(file, "bart/scene_museum/aff/museum5.aff");
  const Scene coarse = load_scene("aff:complexity=5," + file);
  const Scene scene = load_scene("aff:complexity=8," + file);
  EXPECT_NE(scene.name.find("derived from complexity 5"), std::string::npos);
  EXPECT_EQ(coarse.name, "museum5");
  const auto art = [](const Scene& in) -> const Mesh& {
    return *std::ranges::find_if(in.meshes, [](const Mesh& mesh) { return mesh.keys > 0; });
  };
  const Mesh &fine = art(scene), &given = art(coarse);
  EXPECT_NE(fine.name.find("derived from complexity 5"), std::string::npos);
  EXPECT_EQ(fine.triangles.size(), 65'536u);
  ASSERT_EQ(fine.keys, 5u);
  const size_t vertices = fine.positions.size();
  for (uint32_t key = 0; key < 5; ++key) {
    const std::span positions(fine.key_positions.data() + key * vertices, vertices);
    const std::span old(given.key_positions.data() + key * given.positions.size(),
                        given.positions.size());
    EXPECT_TRUE(std::ranges::equal(old, positions.first(old.size()))) << "the file's own stay";
    const auto sphere = aff::sphere_through(positions);
    EXPECT_EQ(sphere.has_value(), key == 3) << key;
    double area = 0.0, old_area = 0.0;
    const auto area_of = [](std::span<const vec3> p, uvec3 t) {
      return 0.5 * length(cross(p[t.y] - p[t.x], p[t.z] - p[t.x]));
    };
    for (const uvec3& t : fine.triangles) area += area_of(positions, t);
    for (const uvec3& t : given.triangles) old_area += area_of(old, t);
    if (key != 3) {
      EXPECT_NEAR(area / old_area, 1.0, 1e-4) << "flat triangles stay flat";
      continue;
    }
    EXPECT_NEAR(distance(sphere->center, vec3(0, 2.5f, 0)), 0.0f, 1e-5f);
    EXPECT_NEAR(sphere->radius, 0.8f, 1e-5f);
    EXPECT_NEAR(area / (4.0 * kPi * 0.64), 1.0, 1e-3);
    EXPECT_LT(old_area, area);
  }
}

}  // namespace
}  // namespace sinew
