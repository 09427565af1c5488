// Small scenes made by hand for the tests of sampling and validation.
#pragma once

#include "sinew/scene/scene.h"

namespace sinew::test {

inline Mesh triangle_mesh() {
  Mesh mesh;
  mesh.name = "triangle";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_part = {0};
  mesh.parts = {{}};
  return mesh;
}

// The triangle, half bound to joint 0 and half to joint 1.
inline Mesh skinned_mesh() {
  Mesh mesh = triangle_mesh();
  mesh.influences = 2;
  mesh.joints = {0, 1, 0, 1, 0, 1};
  mesh.weights = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f};
  return mesh;
}

// The triangle with two targets: up by 1 in z, and along by 1 in x.
inline Mesh morphed_mesh() {
  Mesh mesh = triangle_mesh();
  mesh.morph_targets = 2;
  mesh.morph_positions = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  mesh.morph_weights = {0.25f, 0.0f};
  mesh.morph_names = {"up", "along"};
  return mesh;
}

// Three keys: at rest, moved by 1 in x, moved by 3 in x.
inline Mesh cached_mesh() {
  Mesh mesh = triangle_mesh();
  mesh.keys = 3;
  for (const float x : {0.0f, 1.0f, 3.0f}) {
    for (const vec3 p : mesh.positions) mesh.key_positions.push_back(p + vec3(x, 0, 0));
  }
  return mesh;
}

inline Node node(int32_t parent, vec3 translation = vec3(0)) {
  Node out;
  out.parent = parent;
  out.translation = translation;
  return out;
}

// One node for each mesh, side by side.
inline Scene scene_of(std::vector<Mesh> meshes) {
  Scene scene;
  scene.materials.resize(1);
  scene.meshes = std::move(meshes);
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    scene.nodes.push_back(node(-1));
    scene.nodes.back().mesh = static_cast<int32_t>(i);
  }
  list_objects(scene);
  return scene;
}

// Node 0 shows a skinned triangle; nodes 1 and 2 are its joints, 2 a child of 1.
inline Scene skinned_scene() {
  Scene scene = scene_of({skinned_mesh()});
  scene.nodes.push_back(node(-1));
  scene.nodes.push_back(node(1));
  scene.nodes[0].skin = 0;
  scene.skins = {{"skin", {1, 2}, {identity_affine(), identity_affine()}}};
  list_objects(scene);
  return scene;
}

inline Channel channel(uint32_t node, ChannelPath path, uint32_t width, std::vector<float> times,
                       std::vector<float> values) {
  return {node, path, Interpolation::linear, width, std::move(times), std::move(values)};
}

}  // namespace sinew::test
