// Small scenes for rendering tests, and a renderer for them.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "shapes.h"
#include "sinew/render/frame.h"
#include "sinew/world/world.h"

namespace sinew::test {

struct TestScene {
  Scene scene;
  CameraView camera;
  RenderSettings settings;
  FrameStats stats;  // of the last render

  // Black surroundings; 32 x 32 pixels; looks along -z at the square [-1, 1]^2 without perspective.
  TestScene() {
    scene.environment = {vec3(0.0f), vec3(0.0f), vec3(0.0f), {}, {}};
    settings.width = settings.height = 32;
    camera.to_world[3] = vec3(0.0f, 0.0f, 10.0f);
    camera.orthographic = true;
    camera.ymag = 1.0f;
  }

  uint32_t add_material(vec3 color, float roughness = 1.0f) {
    Material material;
    material.base_color = vec4(color, 1.0f);
    material.roughness = roughness;
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
  }

  // Returns the index of the new mesh.
  uint32_t add_mesh(const Shape& shape, uint32_t material) {
    Mesh mesh;
    mesh.positions = shape.positions;
    mesh.triangles = shape.triangles;
    mesh.triangle_part.assign(shape.triangles.size(), 0);
    mesh.parts = {{material, false}};
    scene.meshes.push_back(mesh);
    return static_cast<uint32_t>(scene.meshes.size() - 1);
  }
  // A parallelogram: corner + [0, 1] x + [0, 1] y, with texture coordinates (0, 0) at corner + y.
  uint32_t add_quad(vec3 corner, vec3 x, vec3 y, uint32_t material) {
    const uint32_t mesh = add_mesh(
        {{corner, corner + x, corner + x + y, corner + y}, {{0, 1, 2}, {0, 2, 3}}}, material);
    scene.meshes[mesh].texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    return mesh;
  }

  Node& place(uint32_t mesh, const Affine& at = identity_affine()) {
    Node node;
    node.mesh = static_cast<int32_t>(mesh);
    node.has_matrix = true;
    node.matrix = at;
    scene.nodes.push_back(node);
    return scene.nodes.back();
  }

  // A light that shines along `direction` from `position`.
  Light& add_light(LightType type, vec3 position, vec3 direction, float intensity) {
    Light light;
    light.type = type;
    light.intensity = intensity;
    Node node;
    node.has_matrix = true;
    node.matrix = look_at(position, position + direction, vec3(0.1f, 0.9f, 0.2f), 1.0f).to_world;
    node.light = static_cast<int32_t>(scene.lights.size());
    scene.nodes.push_back(node);
    scene.lights.push_back(light);
    return scene.lights.back();
  }

  World prepare_world() {
    list_objects(scene);
    EXPECT_EQ(validate(scene), "");
    Result<World> world = prepare(scene);
    EXPECT_TRUE(world.has_value()) << (world ? "" : world.error().message());
    return std::move(*world);
  }

  Image render() {
    const World world = prepare_world();
    const RenderScratchPtr scratch = make_render_scratch();
    Image image;
    stats = render_frame(world, scene, world.pose(), camera, settings, *scratch, image);
    return image;
  }
};

inline vec4 pixel(const Image& image, uint32_t x, uint32_t y) {
  return image.pixels[size_t{y} * image.width + x];
}

inline uint64_t hash_of(const Image& image) {
  uint64_t h = 0xcbf29ce484222325u;
  const auto* bytes = reinterpret_cast<const uint8_t*>(image.pixels.data());
  for (size_t i = 0; i < image.pixels.size() * sizeof(vec4); ++i) {
    h = (h ^ bytes[i]) * 0x100000001b3u;
  }
  return h;
}

}  // namespace sinew::test
