#include "sinew/render/gbuffer.h"

#include <gtest/gtest.h>

#include "test_scene.h"

namespace sinew {
namespace {

using test::TestScene;

// The surface in the middle of the picture.
Surface middle(TestScene& t, float x = 0.01f, float y = 0.02f) {
  const World world = t.prepare_world();
  AttributeTable attributes;
  attributes.begin_frame(world, t.scene, world.pose(), 1u << 20);
  const Ray ray{vec3(x, y, 10.0f), 0.0f, vec3(0.0f, 0.0f, -2.0f)};
  const auto hit = world.closest_hit(ray);
  EXPECT_TRUE(hit.has_value());
  Surface surface;
  if (!hit) return surface;
  attributes.touch(hit->object);
  attributes.refresh();
  TextureTable textures;
  textures.build(t.scene);
  resolve_surface(t.scene, textures, attributes.of(hit->object), ray, {}, *hit, surface);
  return surface;
}

void expect_near(vec3 actual, vec3 expected, float tolerance = 1e-4f) {
  EXPECT_NEAR(length(actual - expected), 0.0f, tolerance)
      << actual.x << ' ' << actual.y << ' ' << actual.z;
}

uint8_t encode(float x) {
  return static_cast<uint8_t>(std::lround((0.5f * x + 0.5f) * 255.0f));
}

// A square towards the viewer whose normal map says `mapped` everywhere.
TestScene mapped_square(vec3 mapped) {
  TestScene t;
  const uint32_t m = t.add_material(vec3(1.0f));
  t.scene.materials[m].normal_texture.image = 0;
  t.scene.images.push_back({1, 1, {encode(mapped.x), encode(mapped.y), encode(mapped.z), 255}});
  t.place(t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), m));
  return t;
}

TEST(GBuffer, ConstantNormalMapTiltsTheNormal) {
  const vec3 tilt = normalize(vec3(0.5f, 0.25f, 0.8f));
  TestScene t = mapped_square(tilt);
  expect_near(middle(t).normal, tilt, 0.01f);  // u runs along x, "up" in the image along y
  expect_near(middle(t).geometric_normal, vec3(0, 0, 1));

  Mesh& mesh = t.scene.meshes[0];
  mesh.normals.assign(4, vec3(0, 0, 1));
  mesh.tangents.assign(4, vec4(1, 0, 0, 1));
  expect_near(middle(t).normal, tilt, 0.01f);
  mesh.tangents.assign(4, vec4(0, 1, 0, -1));  // x -> +y, y -> -cross(z, y) = +x
  expect_near(middle(t).normal, vec3(tilt.y, tilt.x, tilt.z), 0.01f);
}

TEST(GBuffer, NormalMapFollowsMirroredCoordinatesPlacementsAndSides) {
  const vec3 tilt = normalize(vec3(0.5f, 0.25f, 0.8f));
  TestScene t = mapped_square(tilt);
  for (vec2& uv : t.scene.meshes[0].texcoords[0]) uv.x = -uv.x;
  expect_near(middle(t).normal, tilt * vec3(-1, 1, 1), 0.01f);

  t = mapped_square(tilt);
  t.scene.nodes[0].matrix = Affine(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.0f));
  expect_near(middle(t).normal, tilt * vec3(-1, 1, 1), 0.01f);

  // Seen from behind (turned about y): the bump's normal is reversed as a whole.
  t.scene.nodes[0].matrix = Affine(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, -1), vec3(0.0f));
  expect_near(middle(t).normal, vec3(tilt.x, -tilt.y, tilt.z), 0.01f);
}

TEST(GBuffer, NormalsFollowTheCofactorOfThePlacement) {
  TestScene t;
  t.place(t.add_mesh(test::sphere(6), t.add_material(vec3(1.0f))),
          Affine(vec3(2, 0, 0), vec3(0, 1, 0), vec3(0, 0, 0.5f), vec3(0.0f)));
  const Surface s = middle(t, 1.0f, 0.3f);
  // Ellipsoid (x / 2)^2 + y^2 + (2 z)^2 = 1: its gradient.
  const float z = 0.5f * std::sqrt(1.0f - 0.25f - 0.09f);
  expect_near(s.position, vec3(1.0f, 0.3f, z), 1e-3f);
  expect_near(s.normal, normalize(vec3(0.25f, 0.3f, 4.0f * z)), 5e-3f);
}

TEST(GBuffer, StoredNormalsFollowTheSkin) {
  TestScene t;
  const uint32_t mesh =
      t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), t.add_material(vec3(1.0f)));
  Mesh& m = t.scene.meshes[mesh];
  const vec3 rest = normalize(vec3(0.2f, 0.1f, 1.0f));
  m.normals.assign(4, rest);
  m.influences = 1;
  m.joints.assign(4, 0);
  m.weights.assign(4, 1.0f);
  t.place(mesh).skin = 0;
  Node joint;
  joint.has_matrix = true;
  const float angle = 0.4f;
  const mat3 turn = glm::mat3_cast(glm::angleAxis(angle, vec3(0, 1, 0)));
  joint.matrix = Affine(turn[0] * 3.0f, turn[1], turn[2], vec3(0.0f));
  t.scene.nodes.push_back(joint);
  t.scene.skins.push_back({"skin", {1}, {identity_affine()}});
  expect_near(middle(t).normal, normalize(turn * (rest * vec3(1.0f / 3.0f, 1.0f, 1.0f))));
}

TEST(GBuffer, MorphDeltasMoveNormals) {
  TestScene t;
  const uint32_t mesh =
      t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), t.add_material(vec3(1.0f)));
  Mesh& m = t.scene.meshes[mesh];
  m.normals.assign(4, vec3(0, 0, 1));
  m.morph_targets = 2;
  m.morph_positions.assign(8, vec3(0.0f));
  m.morph_normals.assign(4, vec3(0.6f, 0.0f, 0.0f));
  m.morph_normals.resize(8, vec3(0.0f, 0.4f, 0.0f));
  m.morph_weights = {0.5f, 0.25f};
  t.place(mesh);
  expect_near(middle(t).normal, normalize(vec3(0.3f, 0.1f, 1.0f)));
}

TEST(GBuffer, VertexCachesGetSmoothNormalsFromTheirPositions) {
  TestScene t;
  const test::Shape ball = test::sphere(6);
  const uint32_t mesh = t.add_mesh(ball, t.add_material(vec3(1.0f)));
  Mesh& m = t.scene.meshes[mesh];
  m.keys = 1;
  m.key_positions = ball.positions;
  for (vec3& p : m.key_positions) p.x *= 2.0f;
  t.place(mesh);
  const Surface s = middle(t, 1.0f, 0.3f);
  const float z = std::sqrt(1.0f - 0.25f - 0.09f);
  expect_near(s.normal, normalize(vec3(0.25f, 0.3f, z)), 5e-3f);
  EXPECT_GT(dot(s.lifted - s.position, s.normal), 0.0f);
  m.parts[0].flat = true;
  const Surface flat = middle(t, 1.0f, 0.3f);
  EXPECT_EQ(flat.normal, flat.geometric_normal);
  EXPECT_EQ(flat.lifted, flat.position);
}

TEST(GBuffer, ContradictingNormalsKeepTheSide) {
  TestScene t;
  const uint32_t mesh =
      t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), t.add_material(vec3(1.0f)));
  t.scene.meshes[mesh].normals.assign(4, -normalize(vec3(0.3f, 0.0f, 1.0f)));
  t.place(mesh);
  expect_near(middle(t).normal, normalize(vec3(0.3f, 0.0f, 1.0f)));
}

TEST(GBuffer, MaterialsAreMappedAsGltfSays) {
  TestScene t;
  const uint32_t index = t.add_material(vec3(0.8f, 0.4f, 0.2f));
  Material& m = t.scene.materials[index];
  m.metallic = 0.5f;
  m.roughness = 0.5f;
  m.metallic_roughness_texture.image = 0;  // roughness 128 / 255 in G, metallic 51 / 255 in B
  m.occlusion_texture.image = 0;           // 102 / 255 in R
  m.occlusion_strength = 0.5f;
  m.emissive = vec3(2.0f, 0.0f, 1.0f);
  t.scene.images.push_back({1, 1, {102, 128, 51, 255}});
  const uint32_t mesh = t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), index);
  t.scene.meshes[mesh].colors.assign(4, vec4(0.5f, 1.0f, 1.0f, 1.0f));
  t.place(mesh);
  const Surface s = middle(t);
  const vec3 base(0.4f, 0.4f, 0.2f);
  expect_near(s.albedo, base * 0.9f);
  expect_near(s.specular, vec3(0.04f) * 0.9f + base * 0.1f);
  EXPECT_NEAR(s.roughness, 0.5f * 128.0f / 255.0f, 1e-5f);
  EXPECT_NEAR(s.occlusion, 1.0f - 0.5f * 0.6f, 1e-5f);
  expect_near(s.emission, vec3(2.0f, 0.0f, 1.0f));
  EXPECT_EQ(s.alpha, 1.0f);
}

}  // namespace
}  // namespace sinew
