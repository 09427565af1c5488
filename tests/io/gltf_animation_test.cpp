// Animations of small glTF files made here.
#include <cmath>

#include "gltf_builder.h"

namespace sinew {
namespace {

using nlohmann::json;

// A triangle node with one animation of one channel.
GltfBuilder animated(const std::string& path, const json& sampler_extra,
                     const std::vector<float>& times, const std::vector<float>& values,
                     const std::string& type) {
  GltfBuilder b;
  b.add_triangle();
  json sampler = {{"input", b.accessor(times, "SCALAR")}, {"output", b.accessor(values, type)}};
  sampler.update(sampler_extra);
  b.add("animations",
        {{"samplers", json::array({sampler})},
         {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})}});
  return b;
}

TEST(GltfAnimation, ChannelsOfEveryPathAndInterpolation) {
  GltfBuilder b = animated("translation", {{"interpolation", "STEP"}}, {0.5f, 2.0f},
                           {1, 2, 3, 4, 5, 6}, "VEC3");
  const Clip step = load_or_fail(b).clips.at(0);
  EXPECT_EQ(step.name, "clip 0");
  EXPECT_EQ(step.start, 0.5);
  EXPECT_EQ(step.end, 2.0);
  const Channel& channel = step.channels.at(0);
  EXPECT_EQ(channel.node, 0u);
  EXPECT_EQ(channel.path, ChannelPath::translation);
  EXPECT_EQ(channel.interpolation, Interpolation::step);
  EXPECT_EQ(channel.width, 3u);
  EXPECT_EQ(channel.times, (std::vector<float>{0.5f, 2.0f}));
  EXPECT_EQ(channel.values, (std::vector<float>{1, 2, 3, 4, 5, 6}));

  b = animated("scale", {{"interpolation", "CUBICSPLINE"}}, {1.0f}, {1, 2, 3, 4, 5, 6, 7, 8, 9},
               "VEC3");
  b.json["animations"][0]["name"] = "grow";
  const Clip cubic = load_or_fail(b).clips.at(0);
  EXPECT_EQ(cubic.name, "grow");
  EXPECT_EQ(cubic.channels.at(0).path, ChannelPath::scale);
  EXPECT_EQ(cubic.channels[0].interpolation, Interpolation::cubic_spline);
  EXPECT_EQ(cubic.channels[0].values.size(), 9u);

  b = animated("rotation", json::object(), {1.0f}, {0, 0, 0, 1}, "VEC4");
  b.json["animations"][0]["samplers"][0]["output"] =
      b.accessor<int16_t>({0, 0, 32767, 0}, "VEC4", true);
  const Clip rotation = load_or_fail(b).clips.at(0);
  EXPECT_EQ(rotation.channels.at(0).interpolation, Interpolation::linear);
  EXPECT_EQ(rotation.channels[0].values, (std::vector<float>{0, 0, 1, 0}));
}

TEST(GltfAnimation, WeightsHaveTheWidthOfTheMesh) {
  GltfBuilder b = animated("weights", json::object(), {0, 1}, {.1f, .2f, .3f, .4f}, "SCALAR");
  const json target = {{"POSITION", 0}};
  b.json["meshes"][0]["primitives"][0]["targets"] = {target, target};
  const Clip clip = load_or_fail(b).clips.at(0);
  EXPECT_EQ(clip.channels.at(0).width, 2u);
  EXPECT_EQ(clip.channels[0].values, (std::vector<float>{.1f, .2f, .3f, .4f}));
  b.json["meshes"][0]["primitives"][0]["targets"] = {target, target, target};
  expect_contains(load_error(b),
                  "accessor 2: has 4 numbers as output of animation 0 sampler 0; "
                  "2 keys need 6");
  b.json["meshes"][0]["primitives"][0].erase("targets");
  const Scene without = load_or_fail(b);
  EXPECT_TRUE(without.clips.at(0).channels.empty());
  expect_contains(without.warnings.at(0), "mesh without targets");
}

TEST(GltfAnimation, WeightsOfInstancesAllMove) {
  GltfBuilder b = animated("weights", json::object(), {0, 1}, {.1f, .2f}, "SCALAR");
  b.json["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", 0}}});
  b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
      b.accessor<float>({1, 1, 1, 2, 2, 2}, "VEC3");
  const Clip clip = load_or_fail(b).clips.at(0);
  ASSERT_EQ(clip.channels.size(), 2u);
  EXPECT_EQ(clip.channels[0].node, 1u);
  EXPECT_EQ(clip.channels[1].node, 2u);
}

TEST(GltfAnimation, TimesBecomeStrictlyRising) {
  // Two keys at 1 s with different values are a jump; equal ones are one; 0.5 s comes too late.
  const GltfBuilder b = animated("translation", json::object(), {0, 1, 1, 0.5f, 2, 2},
                                 {0, 0, 0, 1, 1, 1, 2, 2, 2, 9, 9, 9, 3, 3, 3, 3, 3, 3}, "VEC3");
  const Scene scene = load_or_fail(b);
  const Channel& channel = scene.clips.at(0).channels.at(0);
  EXPECT_EQ(channel.times, (std::vector<float>{0, 1, std::nextafter(1.0f, 2.0f), 2}));
  EXPECT_EQ(channel.values, (std::vector<float>{0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3}));
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_contains(scene.warnings[0], "animation 0 channel 0: has keys out of order");
}

TEST(GltfAnimation, RotationsWithoutLengthAreRepaired) {
  const GltfBuilder b =
      animated("rotation", json::object(), {0, 1}, {0, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  const Scene scene = load_or_fail(b);
  EXPECT_EQ(scene.clips.at(0).channels.at(0).values, (std::vector<float>{0, 0, 0, 1, 0, 1, 0, 0}));
  expect_contains(scene.warnings.at(0), "a rotation has no length");
}

TEST(GltfAnimation, AnimatedMatricesAreTakenApart) {
  GltfBuilder b = animated("translation", json::object(), {0}, {0, 0, 0}, "VEC3");
  b.json["nodes"][0]["matrix"] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1};
  const Node node = load_or_fail(b).nodes.at(0);
  EXPECT_FALSE(node.has_matrix);
  EXPECT_EQ(node.translation, vec3(5, 6, 7));
  EXPECT_EQ(node.scale, vec3(2, 3, 4));
  EXPECT_NEAR(node.rotation.w, std::sqrt(0.5f), 1e-6f);  // a quarter turn about Z
  EXPECT_NEAR(node.rotation.z, std::sqrt(0.5f), 1e-6f);
  b.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const Scene sheared = load_or_fail(b);
  EXPECT_TRUE(sheared.nodes.at(0).has_matrix);
  EXPECT_TRUE(sheared.clips.at(0).channels.empty());
  expect_contains(sheared.warnings.at(0), "shearing matrix");
}

TEST(GltfAnimation, WhatCannotMoveIsNamed) {
  GltfBuilder b = animated("translation", json::object(), {0}, {0, 0, 0}, "VEC3");
  json& channels = b.json["animations"][0]["channels"];
  b.add("nodes", json::object());  // not in the scene
  channels[0]["target"]["node"] = 1;
  channels.push_back({{"sampler", 0}, {"target", {{"path", "pointer"}}}});
  const Scene scene = load_or_fail(b);
  EXPECT_TRUE(scene.clips.at(0).channels.empty());
  ASSERT_EQ(scene.warnings.size(), 2u);
  expect_contains(scene.warnings[0], "a node outside the scene");
  expect_contains(scene.warnings[1], "\"pointer\", which is not supported");
  channels = {{{"sampler", 5}, {"target", {{"node", 0}, {"path", "scale"}}}}};
  expect_contains(load_error(b), "\"sampler\" is 5, but the file has only 1");
}

}  // namespace
}  // namespace sinew
