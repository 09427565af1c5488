// Trees for animations: the pictures stay the same, bodies change trees by time, files fit or not.
#include "sinew/world/animation_trees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "sinew/bvh/builders/derived_upper.h"
#include "sinew/math/random.h"
#include "sinew/scene/study.h"
#include "sinew/world/animation_key.h"
#include "sinew/world/body_animation.h"
#include "sinew/world/scene_bodies.h"
#include "sinew/world/world.h"

namespace sinew {
namespace {

std::vector<Ray> rays_through(const Box& box, size_t count, uint32_t seed) {
  Random random(seed);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    ray.origin = box.center() + length(box.extent()) * random.direction();
    ray.direction = box.center() + random.uniform3(-0.5f, 0.5f) * box.extent() - ray.origin;
  }
  return rays;
}

bool same_bits(std::span<const Hit> a, std::span<const Hit> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

struct Case {
  const char* scene;
  uint32_t segments;
  bool derived;
};

class AnimationTreesTest : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Studies, AnimationTreesTest,
                         testing::Values(Case{"soup,triangles=1000", 4, false},
                                         Case{"creature,triangles=8000", 1, true},
                                         Case{"bodies,subdivisions=3,bodies=3", 2, true},
                                         Case{"twist,triangles=4000", 3, false}));

TEST_P(AnimationTreesTest, HitsAreThoseOfBuiltTrees) {
  const Scene scene = *make_study_scene(GetParam().scene);
  AnimationTreeOptions options;
  options.most_segments = GetParam().segments;
  options.cost_limit = 1.01;
  options.derived_boxes = GetParam().derived;
  const Result<AnimationTrees> made = optimize_trees(scene, options);
  ASSERT_TRUE(made) << made.error().message();
  const TreeFile trees = *decode_trees(encode_trees(made->trees));
  World plain = *prepare(scene), optimized = *prepare(scene, {.trees = &trees});
  const double start = scene.clips[0].start, length = scene.clips[0].end - start;
  size_t hit_count = 0;
  for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
    plain.set_update_mode(mode);
    optimized.set_update_mode(mode);
    for (const double at : {0.05, 0.95, 0.3, 0.6, 0.62, 0.1}) {
      ASSERT_TRUE(plain.set_time(start + at * length));
      if (mode == UpdateMode::lazy) {
        ASSERT_TRUE(optimized.stage_time(start + at * length));
        optimized.flip();
      } else {
        ASSERT_TRUE(optimized.set_time(start + at * length));
      }
      const std::vector<Ray> rays = rays_through(plain.box(), 500, 11);
      std::vector<Hit> a(rays.size()), b(rays.size());
      plain.closest_hits(rays, a);
      optimized.closest_hits(rays, b);
      ASSERT_TRUE(same_bits(a, b)) << name_of(mode) << " at " << at;
      EXPECT_EQ(optimized.validate(), "");
      hit_count +=
          static_cast<size_t>(std::ranges::count_if(a, [](const Hit& h) { return bool(h); }));
    }
  }
  EXPECT_GT(hit_count, 500u);
}

TEST(AnimationTrees, ServeAScatteringBodyBetter) {
  const Scene scene = *make_study_scene("soup,triangles=2000");
  const AnimationTrees one = *optimize_trees(scene, {});
  AnimationTreeOptions options;
  options.most_segments = 4;
  const AnimationTrees four = *optimize_trees(scene, options);
  const auto art = [](const AnimationTrees& trees) {
    return *std::ranges::max_element(trees.bodies, {}, &BodyTreeReport::triangles);
  };
  EXPECT_LT(art(one).cost, 0.8 * art(one).middle_frame_cost);
  EXPECT_GT(art(four).segments, 1u);
  EXPECT_LT(art(four).cost, 0.8 * art(one).cost);
  EXPECT_LE(art(four).rebuild_cost, 1.02 * art(four).cost);
  EXPECT_GE(art(four).highest_cost, art(four).cost);
}

TEST(AnimationTrees, CostsSayWhetherTheLimitIsKept) {
  const Scene scene = *make_study_scene("twist,triangles=2000");
  AnimationTreeOptions options;
  options.most_segments = 8;
  for (const double limit : {1.1, 1.3}) {
    options.cost_limit = limit;
    const AnimationTrees made = *optimize_trees(scene, options);
    for (const BodyTreeReport& body : made.bodies) {
      if (body.segments == options.most_segments) continue;
      EXPECT_LE(body.cost, limit * body.rebuild_cost) << body.name;
    }
  }
}

TEST(AnimationTrees, EveryBodyHasATreeWithinTheBudget) {
  // Bodies of very different sizes: the smallest one's part of the budget is a tree all the same.
  const Scene scene = *make_study_scene("fracture,triangles=10000,pieces=100");
  size_t least = 0;
  for (const SceneBody& body : scene_bodies(scene)) {
    least += bytes_of_trees(static_cast<uint32_t>(scene.meshes[body.mesh].triangles.size()));
  }
  AnimationTreeOptions options;
  options.byte_budget = least - 1;
  const Result<AnimationTrees> refused = optimize_trees(scene, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find(std::to_string(least)), std::string::npos);
  for (const size_t enough : {least, std::numeric_limits<size_t>::max()}) {
    options.byte_budget = enough;
    EXPECT_TRUE(optimize_trees(scene, options));
  }
}

TEST(AnimationTrees, FitOneSceneAndClipOnly) {
  const Scene scene = *make_study_scene("soup,triangles=1000");
  AnimationTreeOptions options;
  options.most_segments = 4;
  options.cost_limit = 1.01;
  AnimationTrees made = *optimize_trees(scene, options);
  EXPECT_TRUE(check_trees(made.trees, scene, 0));
  EXPECT_FALSE(check_trees(made.trees, scene, kRestPose));
  const Scene other = *make_study_scene("soup,triangles=1004");
  const Result<World> world = prepare(other, {.trees = &made.trees});
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
  made.trees.bodies.pop_back();
  EXPECT_FALSE(check_trees(made.trees, scene, 0));
}

TEST(AnimationTrees, RefuseWhatMakesNoSense) {
  Scene scene = *make_study_scene("twist,triangles=1000");
  EXPECT_FALSE(optimize_trees(scene, {.clip = "nothing"}));
  EXPECT_FALSE(optimize_trees(scene, {.frames = 0}));
  EXPECT_FALSE(optimize_trees(scene, {.most_segments = 0}));
  EXPECT_FALSE(optimize_trees(scene, {.byte_budget = 10}));
  EXPECT_FALSE(optimize_trees(scene, {.exponent = 1000}));
  scene.clips.push_back(scene.clips.front());
  EXPECT_FALSE(optimize_trees(scene, {.clip = "all", .most_segments = 2}));
  EXPECT_TRUE(optimize_trees(scene, {.clip = "all"}));
  EXPECT_TRUE(optimize_trees(scene, {.clip = "rest"}));
  scene.clips[0].end = scene.clips[0].start;
  EXPECT_TRUE(optimize_trees(scene, {.most_segments = 4}));
}

// A triangle or none, a clip or none, vertices that are not finite, too large or on a line, and a
// body that is never shown: there are trees, and they can be traced.
Scene of_triangles(uint32_t count) {
  Scene scene;
  scene.materials.resize(1);
  Mesh& mesh = scene.meshes.emplace_back();
  mesh.parts.resize(1);
  for (uint32_t i = 0; i < count; ++i) {
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    for (const float x : {0.0f, 0.5f, 1.0f}) {
      mesh.positions.emplace_back(static_cast<float>(i) + x, x * x, 0.1f * static_cast<float>(i));
    }
  }
  mesh.triangle_part.resize(count, 0);
  scene.nodes.emplace_back().mesh = 0;
  list_objects(scene);
  return scene;
}

void add_clip(Scene& scene, double end) {
  scene.clips.push_back({.name = "clip", .start = 0.0, .end = end, .channels = {}});
}

TEST(AnimationTrees, OfDegenerateScenes) {
  const float kInfinity = std::numeric_limits<float>::infinity();
  const auto program = [](vec3 scale, float odd) {
    return [=](double time, std::span<vec3> out) {
      for (size_t i = 0; i < out.size(); ++i) {
        const auto at = static_cast<float>(i);
        out[i] = scale * vec3(at, std::sin(at + 5.0f * static_cast<float>(time)), -at);
        if (i % 5 == 1) out[i].y += odd * static_cast<float>(time);
      }
    };
  };
  std::vector<Scene> scenes(1);
  for (const uint32_t count : {0u, 1u, 2u, 3u, 40u}) {
    scenes.push_back(of_triangles(count));
    for (const vec3 scale : {vec3(1.0f), vec3(0.0f), vec3(1.0f, 0.0f, 0.0f), vec3(1e-30f),
                             vec3(1e30f), vec3(1e36f, 1e-44f, 0.0f)}) {
      for (const float odd : {0.0f, kInfinity}) {
        for (const double end : {0.0, 1.0}) {
          Scene scene = of_triangles(count);
          scene.meshes[0].vertex_program = program(scale, odd);
          add_clip(scene, end);
          scenes.push_back(std::move(scene));
        }
      }
    }
    scenes.push_back(scenes.back());
    scenes.back().nodes[0].visible = false;
  }
  for (size_t i = 0; i < scenes.size(); ++i) {
    SCOPED_TRACE(i);
    for (const FrameChoice choice : {FrameChoice::uniform, FrameChoice::medoids}) {
      for (const uint32_t exponent : {0u, 64u}) {
        const Result<AnimationTrees> made =
            optimize_trees(scenes[i], {.choice = choice,
                                       .exponent = exponent,
                                       .most_segments = 3,
                                       .view = [](const ScenePose&) { return mat4(1.0f); },
                                       .view_share = 0.5f,
                                       .derived_boxes = true});
        ASSERT_TRUE(made) << made.error().message();
        const Result<TreeFile> trees = decode_trees(encode_trees(made->trees));
        ASSERT_TRUE(trees) << trees.error().message();
        Result<World> world = prepare(scenes[i], {.trees = &*trees});
        ASSERT_TRUE(world) << world.error().message();
        EXPECT_TRUE(world->set_time(0.7));
        EXPECT_EQ(world->validate(), "");
        for (const BodyTreeReport& body : made->bodies) EXPECT_TRUE(std::isfinite(body.cost));
      }
    }
    EXPECT_TRUE(prepare(scenes[i]));
  }
}

TEST(AnimationTrees, EndWhenTheCallerSaysSo) {
  const Scene scene = *make_study_scene("twist,triangles=4000");
  int calls = 0;
  AnimationTreeOptions options;
  options.on_step = [&](const TreeProgress& progress) {
    EXPECT_LT(progress.body, progress.bodies);
    ++calls;
    return false;
  };
  EXPECT_TRUE(optimize_trees(scene, options));
  EXPECT_GT(calls, 0);
}

TEST(AnimationKey, TellsAnimationsApart) {
  const Scene made = *make_study_scene("creature,triangles=8000");
  const auto key_after = [&](auto change) {
    Scene scene = made;
    change(scene);
    return animation_key(scene);
  };
  const uint64_t key = key_after([](Scene&) {});
  EXPECT_EQ(key, key_after([](Scene& s) { s.materials[0].name += "x"; }));
  EXPECT_NE(key, key_after([](Scene& s) { s.meshes[0].positions[3].x += 1.0f; }));
  EXPECT_NE(key, key_after([](Scene& s) {
              std::swap(s.meshes[0].triangles[0], s.meshes[0].triangles[1]);
            }));
  EXPECT_NE(key, key_after([](Scene& s) { s.clips[0].channels[0].values[0] += 0.5f; }));
  EXPECT_NE(key, key_after([](Scene& s) { s.clips[0].end += 1.0; }));
  EXPECT_NE(key, key_after([](Scene& s) { s.nodes[0].translation.x += 1.0f; }));
  EXPECT_NE(key, key_after([](Scene& s) { s.skins[0].inverse_bind[0][3].x += 1.0f; }));
  EXPECT_NE(key, key_after([](Scene& s) { s.meshes[0].weights[0] *= 0.5f; }));
}

TEST(BodyAnimation, ShowsTheObjectsInTurn) {
  const Scene scene = *make_study_scene("herd,count=3,triangles=2000,terrain=2000");
  ScenePose pose;
  sample(scene, 0, 0.2, pose);
  for (const SceneBody& body : scene_bodies(scene)) {
    for (uint32_t frame = 0; frame < 6; ++frame) {
      const int32_t object = object_in_frame(body, pose, frame);
      EXPECT_EQ(uint32_t(object), body.objects[frame % body.objects.size()]);
    }
    const AnimatedBoxes animation = body_animation(scene, body, 0, 10);
    EXPECT_EQ(animation.primitive_count, scene.meshes[body.mesh].triangles.size());
    std::vector<Box> boxes(animation.primitive_count);
    animation.boxes(0, boxes);
    for (const Box& box : boxes) EXPECT_FALSE(box.empty());
  }
}

// The upper part gets cheaper where derived boxes are concerned, and everything stays in it.
TEST(DerivedUpper, SuitsDerivedBoxes) {
  const Scene scene = *make_study_scene("creature,triangles=8000");
  const std::vector<SceneBody> bodies = scene_bodies(scene);
  const auto body = *std::ranges::find_if(bodies, [](const SceneBody& b) { return b.skinned; });
  const Mesh& mesh = scene.meshes[body.mesh];
  const Motion motion = motion_of(mesh, true);
  std::vector<ScenePose> poses(3);
  std::vector<Pose> of_body;
  for (int i = 0; i < 3; ++i) {
    sample(scene, 0, 0.3 * i, poses[size_t(i)]);
    of_body.push_back(poses[size_t(i)].objects[body.objects[0]]);
  }
  std::vector<vec3> at(mesh.positions.size());
  positions(motion, of_body[0], 0, at);
  std::vector<Box> boxes(mesh.triangles.size());
  triangle_boxes(at, mesh.triangles, boxes);
  const Tree tree = build_binned(boxes);
  const std::vector<double> weights(3, 1.0 / 3.0);
  const Tree suited = suit_derived_boxes(tree, motion, mesh.triangles, of_body, weights, {});
  EXPECT_EQ(validate(suited, uint32_t(boxes.size())), "");
  EXPECT_EQ(suited.nodes.size(), tree.nodes.size());
}

}  // namespace
}  // namespace sinew
