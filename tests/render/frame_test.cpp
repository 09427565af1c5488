// Whole pictures of small scenes against what the formulas say.
#include "sinew/render/frame.h"

#include <gtest/gtest.h>

#include "sinew/base/parallel.h"
#include "sinew/render/shade.h"
#include "test_scene.h"

namespace sinew {
namespace {

using test::pixel;
using test::TestScene;

const vec3 kBack(0.0f, 0.0f, -1.0f);

Surface surface_of(const Material& material, vec3 normal) {
  Surface surface;
  surface.normal = surface.geometric_normal = normal;
  surface.albedo = vec3(material.base_color) * (1.0f - material.metallic);
  surface.specular = mix(vec3(0.04f), vec3(material.base_color), material.metallic);
  surface.roughness = material.roughness;
  return surface;
}

void expect_color(vec4 actual, vec3 expected, float tolerance = 1e-4f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "channel " << c;
}

TEST(Frame, PlaneUnderADirectionalLight) {
  TestScene t;
  const uint32_t material = t.add_material(vec3(0.8f, 0.5f, 0.2f), 0.6f);
  t.place(t.add_quad(vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0), material));
  const vec3 shines = normalize(vec3(1.0f, -0.5f, -1.0f));
  t.add_light(LightType::directional, vec3(0.0f), shines, 3.0f).color = vec3(1.0f, 0.5f, 0.25f);
  const Image image = t.render();
  const vec3 expected = 3.0f * vec3(1.0f, 0.5f, 0.25f) *
                        scatter(surface_of(t.scene.materials[material], -kBack), -kBack, -shines);
  for (uint32_t i = 0; i < 32; ++i) expect_color(pixel(image, i, 31 - i), expected);
  EXPECT_EQ(pixel(image, 3, 3).w, 1.0f);
  EXPECT_EQ(t.stats.rays.primary, 32u * 32u);
  EXPECT_EQ(t.stats.rays.shadow, 32u * 32u);
  EXPECT_EQ(t.stats.rays.ambient, 0u);
  EXPECT_EQ(t.stats.rays.reflection, 0u);
}

TEST(Frame, SmoothSphereFollowsTheFormula) {
  TestScene t;
  t.camera.ymag = 1.25f;
  const uint32_t material = t.add_material(vec3(0.7f), 0.5f);
  t.place(t.add_mesh(test::sphere(5), material));
  const vec3 shines = normalize(vec3(1.0f, -1.0f, -1.0f));
  t.add_light(LightType::directional, vec3(0.0f), shines, 2.0f);
  const Image image = t.render();
  for (uint32_t y = 0; y < 32; ++y) {
    for (uint32_t x = 0; x < 32; ++x) {
      const Ray ray =
          camera_ray(t.camera, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 32, 32);
      const float r2 = ray.origin.x * ray.origin.x + ray.origin.y * ray.origin.y;
      if (r2 > 0.9f) continue;
      const vec3 normal(ray.origin.x, ray.origin.y, std::sqrt(1.0f - r2));
      const vec3 expected =
          2.0f * scatter(surface_of(t.scene.materials[material], normal), -kBack, -shines);
      expect_color(pixel(image, x, y), expected, 0.02f);
    }
  }
}

TEST(Frame, ShadowEdgeOfASquare) {
  TestScene t;
  const uint32_t white = t.add_material(vec3(1.0f));
  t.place(t.add_quad(vec3(-4, -4, 0), vec3(8, 0, 0), vec3(0, 8, 0), white));
  // One metre before the wall and out of the camera's sight; its shadow is the square
  // [-0.5, 0.5] x [-0.5, 0.5].
  t.place(t.add_quad(vec3(1.5f, -0.5f, 1), vec3(1, 0, 0), vec3(0, 1, 0), white));
  t.add_light(LightType::directional, vec3(0.0f), normalize(vec3(-2.0f, 0.0f, -1.0f)), 1.0f);
  const Image image = t.render();
  for (uint32_t y = 0; y < 32; ++y) {
    for (uint32_t x = 0; x < 32; ++x) {
      const bool in_shadow = x >= 8 && x < 24 && y >= 8 && y < 24;
      EXPECT_EQ(pixel(image, x, y).x > 0.0f, !in_shadow) << x << ' ' << y;
    }
  }
}

TEST(Frame, PointLightFallsWithTheSquareAndStopsAtBlockers) {
  TestScene t;
  t.camera.ymag = 0.01f;
  const uint32_t white = t.add_material(vec3(1.0f));
  t.place(t.add_quad(vec3(-4, -4, 0), vec3(8, 0, 0), vec3(0, 8, 0), white));
  t.add_light(LightType::point, vec3(0.0f, 0.0f, 2.0f), kBack, 1.0f);
  const vec4 far = pixel(t.render(), 16, 16);
  t.scene.nodes.back().matrix[3].z = 1.0f;
  const vec4 near = pixel(t.render(), 16, 16);
  EXPECT_NEAR(near.x / far.x, 4.0f, 0.01f);
  // A blocker behind the light casts no shadow, one before it does.
  const uint32_t blocker = t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), white);
  t.camera.to_world[3].z = 1.2f;
  t.place(blocker, Affine(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0, 0, 1.5f)));
  EXPECT_EQ(pixel(t.render(), 16, 16), near);
  t.camera.to_world[3].z = 0.4f;
  t.scene.nodes.back().matrix[3].z = 0.5f;
  EXPECT_EQ(pixel(t.render(), 16, 16).x, 0.0f);
}

TEST(Frame, MirrorShowsTheReflectedObjectWhereItBelongs) {
  TestScene t;
  t.camera.to_world = look_at(vec3(0, 1, 4), vec3(0, 0, 0), vec3(0, 1, 0), 0.6f).to_world;
  t.camera.orthographic = false;
  t.camera.yfov = 0.6f;
  const uint32_t mirror = t.add_material(vec3(1.0f), 0.0f);
  t.scene.materials[mirror].metallic = 1.0f;
  const uint32_t red = t.add_material(vec3(1.0f, 0.0f, 0.0f));
  t.scene.materials[red].unlit = true;
  t.place(t.add_quad(vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8), mirror));
  t.place(t.add_quad(vec3(-0.3f, 0.2f, -1), vec3(0.6f, 0, 0), vec3(0, 0.6f, 0), red));
  t.add_light(LightType::directional, vec3(0.0f), vec3(0, -1, 0), 0.0f);
  t.settings.width = t.settings.height = 64;
  const Image image = t.render();
  uint32_t direct = 0, mirrored = 0;
  for (uint32_t y = 0; y < 64; ++y) {
    for (uint32_t x = 0; x < 64; ++x) {
      const Ray ray =
          camera_ray(t.camera, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 64, 64);
      const vec3 at = ray.origin + ray.direction * ((-1.0f - ray.origin.z) / ray.direction.z);
      // The mirror image of the square stands upside down below the floor.
      const float height = std::abs(at.y);
      const float margin = std::min({0.3f - std::abs(at.x), height - 0.2f, 0.8f - height});
      if (std::abs(margin) < 1e-3f) continue;
      EXPECT_EQ(pixel(image, x, y).x > 0.9f, margin > 0.0f) << x << ' ' << y;
      EXPECT_LT(pixel(image, x, y).y, 1e-3f);
      if (margin > 0.0f) ++(at.y > 0.0f ? direct : mirrored);
    }
  }
  EXPECT_GT(direct, 100u);
  EXPECT_GT(mirrored, 100u);
  t.settings.reflections = 0;
  t.render();
  EXPECT_EQ(t.stats.rays.reflection, 0u);
}

TEST(Frame, FacingMirrorsStopAtTheBounceLimit) {
  TestScene t;
  const uint32_t mirror = t.add_material(vec3(1.0f), 0.0f);
  t.scene.materials[mirror].metallic = 1.0f;
  t.place(t.add_quad(vec3(-4, -4, 0), vec3(8, 0, 0), vec3(0, 8, 0), mirror));
  t.place(t.add_quad(vec3(-4, -4, 20), vec3(8, 0, 0), vec3(0, 8, 0), mirror));
  t.scene.environment.horizon = vec3(0.5f);
  t.add_light(LightType::directional, vec3(0.0f), vec3(0, 0, -1), 0.0f);
  for (uint32_t bounces : {1u, 3u, 16u}) {
    t.settings.reflections = bounces;
    expect_color(pixel(t.render(), 5, 5), vec3(0.5f));
    EXPECT_EQ(t.stats.rays.reflection, uint64_t{bounces} * 32 * 32);
  }
}

// A wall lit through a blocker that the camera does not see.
TestScene lit_through(AlphaMode mode, float alpha) {
  TestScene t;
  const uint32_t white = t.add_material(vec3(1.0f));
  const uint32_t cover = t.add_material(vec3(1.0f));
  t.scene.materials[cover].alpha_mode = mode;
  t.scene.materials[cover].base_color.w = alpha;
  t.place(t.add_quad(vec3(-4, -4, 0), vec3(8, 0, 0), vec3(0, 8, 0), white));
  t.place(t.add_quad(vec3(-4, -4, 20), vec3(8, 0, 0), vec3(0, 8, 0), cover));
  t.add_light(LightType::directional, vec3(0.0f), kBack, 1.0f);
  return t;
}

TEST(Frame, MasksLetLightThroughAndBlendsDimIt) {
  const vec4 open = pixel(lit_through(AlphaMode::mask, 0.3f).render(), 7, 9);
  EXPECT_NEAR(open.x, 0.96f / 3.14159265f + 0.04f / 3.14159265f, 1e-4f);
  EXPECT_EQ(pixel(lit_through(AlphaMode::mask, 0.7f).render(), 7, 9).x, 0.0f);
  EXPECT_EQ(pixel(lit_through(AlphaMode::opaque, 0.3f).render(), 7, 9).x, 0.0f);
  for (float alpha : {0.0f, 0.25f, 0.6f, 1.0f}) {
    const vec4 dimmed = pixel(lit_through(AlphaMode::blend, alpha).render(), 7, 9);
    EXPECT_NEAR(dimmed.x, open.x * (1.0f - alpha), 2e-4f) << alpha;
  }
}

TEST(Frame, SingleSidedSurfacesHaveNoBack) {
  for (const bool mirrored : {false, true}) {
    TestScene t;
    const uint32_t white = t.add_material(vec3(1.0f));
    const uint32_t red = t.add_material(vec3(1.0f, 0.0f, 0.0f));
    t.scene.materials[red].double_sided = false;
    t.place(t.add_quad(vec3(-4, -4, 0), vec3(8, 0, 0), vec3(0, 8, 0), white));
    t.add_light(LightType::directional, vec3(0.0f), kBack, 1.0f);
    const vec4 open = pixel(t.render(), 7, 9);
    // Before the wall, its back towards the camera and the light: neither meets it.
    const Affine flip(vec3(mirrored ? -1 : 1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.0f));
    t.place(t.add_quad(vec3(-4, 4, 5), vec3(8, 0, 0), vec3(0, -8, 0), red), flip);
    EXPECT_EQ(pixel(t.render(), 7, 9), open);
    // Turned round, both do.
    t.scene.materials[red].double_sided = true;
    EXPECT_LT(pixel(t.render(), 7, 9).y, 0.5f * open.y);
    t.scene.materials[red].double_sided = false;
    std::swap(t.scene.meshes[1].triangles[0].y, t.scene.meshes[1].triangles[0].z);
    std::swap(t.scene.meshes[1].triangles[1].y, t.scene.meshes[1].triangles[1].z);
    EXPECT_LT(pixel(t.render(), 7, 9).y, 0.5f * open.y);
    // Behind the camera it shades the wall only if its front faces the light.
    t.scene.nodes.back().matrix[3].z = 10.0f;
    EXPECT_EQ(pixel(t.render(), 7, 9).x, 0.0f);
  }
}

TEST(Frame, BlendedLayersAreComposited) {
  TestScene t;
  const vec3 colors[3] = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t m = t.add_material(colors[i]);
    t.scene.materials[m].unlit = true;
    t.scene.materials[m].alpha_mode = AlphaMode::blend;
    t.scene.materials[m].base_color.w = 0.5f;
    t.place(t.add_quad(vec3(-4, -4, -static_cast<float>(i)), vec3(8, 0, 0), vec3(0, 8, 0), m));
  }
  t.scene.environment.horizon = vec3(1.0f);
  expect_color(pixel(t.render(), 4, 20), vec3(0.5f, 0.25f, 0.125f) + 0.125f);
  EXPECT_EQ(t.stats.rays.primary, 4u * 32 * 32);
  EXPECT_NEAR(pixel(t.render(), 4, 20).w, 1.0f, 1e-6f);
  t.settings.transparent = true;
  const vec4 out = pixel(t.render(), 4, 20);
  expect_color(out, vec3(0.5f, 0.25f, 0.125f));
  EXPECT_NEAR(out.w, 0.875f, 1e-6f);
}

TEST(Frame, TexturesAreTheRightWayUp) {
  TestScene t;
  const uint32_t m = t.add_material(vec3(1.0f));
  t.scene.materials[m].unlit = true;
  t.scene.materials[m].base_color_texture.image = 0;
  t.scene.materials[m].base_color_texture.nearest = true;
  t.scene.images.push_back(
      {2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}});
  t.place(t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), m));
  const Image image = t.render();
  expect_color(pixel(image, 2, 2), vec3(1, 0, 0));
  expect_color(pixel(image, 29, 2), vec3(0, 1, 0));
  expect_color(pixel(image, 2, 29), vec3(0, 0, 1));
  expect_color(pixel(image, 29, 29), vec3(1, 1, 1));
}

TEST(Frame, SamplesConvergeToCoverage) {
  TestScene t;
  const uint32_t m = t.add_material(vec3(1.0f));
  t.scene.materials[m].unlit = true;
  // A slanted edge through the middle: x < 0.37 * y.
  t.place(t.add_quad(vec3(-8.0f - 0.37f * 4, -4, 0), vec3(8, 0, 0), vec3(0.37f * 8, 8, 0), m));
  t.settings.samples = 256;
  const Image image = t.render();
  EXPECT_EQ(t.stats.rays.primary, 256u * 32 * 32);
  for (uint32_t y = 0; y < 32; ++y) {
    double row = 0.0;  // covered length of the row, in pixels
    for (uint32_t x = 0; x < 32; ++x) row += pixel(image, x, y).x;
    const double edge = 0.37 * (1.0 - (y + 0.5) / 16.0);
    EXPECT_NEAR(row, 16.0 * (1.0 + edge), 0.02) << y;
  }
}

TEST(Frame, AmbientOcclusionBesideAWall) {
  TestScene t;
  const uint32_t white = t.add_material(vec3(1.0f));
  t.scene.materials[white].metallic = 0.0f;
  t.scene.environment = {vec3(1.0f), vec3(1.0f), vec3(1.0f), {}, {}};
  // The camera looks down at the floor at x = 1 from a wall of height 1 that runs along z.
  t.camera.to_world = look_at(vec3(1, 5, 0), vec3(1, 0, 0), vec3(0, 0, -1), 1.0f).to_world;
  t.camera.ymag = 0.02f;
  t.place(t.add_quad(vec3(-400, 0, 400), vec3(800, 0, 0), vec3(0, 0, -800), white));
  const vec4 open = pixel(t.render(), 0, 0);
  t.place(t.add_quad(vec3(0, 0, 400), vec3(0, 0, -800), vec3(0, 1, 0), white));
  t.settings.ambient_rays = 64;
  t.settings.ambient_distance = 1000.0f;
  t.add_light(LightType::directional, vec3(0.0f), vec3(0, -1, 0), 0.0f);
  const Image image = t.render();
  EXPECT_EQ(t.stats.rays.ambient, 64u * 32 * 32);
  double mean = 0.0;
  for (const vec4& p : image.pixels) mean += p.x / (32.0 * 32.0);
  // An endless strip at right angles hides (1 - cos(atan(height / distance))) / 2.
  const double share = 1.0 - 0.5 * (1.0 - std::sqrt(0.5));
  t.settings.ambient_rays = 0;
  EXPECT_NEAR(mean / pixel(t.render(), 0, 0).x, share, 2e-3);
  EXPECT_GT(open.x, 0.0f);
}

TEST(Frame, ConvexBodiesDoNotShadowThemselves) {
  // Coarse, with smooth normals, and far from the origin: acne and terminator would show.
  TestScene t;
  const vec3 far(2000.0f, -500.0f, 900.0f);
  t.camera.to_world[3] += far;
  t.camera.ymag = 1.2f;
  t.settings.width = t.settings.height = 96;
  const uint32_t m = t.add_material(vec3(0.8f));
  t.place(t.add_mesh(test::sphere(2), m), Affine(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), far));
  for (const vec3 shines : {vec3(0, 0, -1), vec3(1, 0, -0.2f), vec3(0.4f, -1, 0.3f)}) {
    t.scene.lights.clear();
    t.scene.nodes.resize(1);
    t.add_light(LightType::directional, vec3(0.0f), normalize(shines), 3.0f);
    t.settings.shadows = true;
    const Image with = t.render();
    t.settings.shadows = false;
    const Image without = t.render();
    size_t darker = 0;
    for (size_t i = 0; i < with.pixels.size(); ++i) {
      darker += with.pixels[i].x < 0.9f * without.pixels[i].x ? 1 : 0;
    }
    EXPECT_LE(darker, 4u);
  }
}

TEST(Frame, MirroredPlacementsShadeAlike) {
  TestScene t;
  const uint32_t m = t.add_material(vec3(0.8f), 0.4f);
  t.place(t.add_mesh(test::sphere(3), m));
  t.add_light(LightType::directional, vec3(0.0f), normalize(vec3(1, -1, -1)), 3.0f);
  const Image plain = t.render();
  t.scene.nodes[0].matrix = Affine(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.0f));
  const Image mirrored = t.render();  // the sphere is symmetric
  for (size_t i = 0; i < plain.pixels.size(); ++i) {
    EXPECT_NEAR(plain.pixels[i].x, mirrored.pixels[i].x, 0.02f);
  }
}

// Everything at once: blends, masks, mirrors, three kinds of lights, ambient rays.
TestScene busy_scene() {
  TestScene t;
  t.scene.environment = Environment{};
  t.settings = {.width = 70, .height = 45, .samples = 3, .reflections = 2, .ambient_rays = 2};
  t.camera.orthographic = false;
  t.camera.to_world = look_at(vec3(0, 2, 5), vec3(0), vec3(0, 1, 0), 0.8f).to_world;
  t.place(
      t.add_quad(vec3(-3, -1, 3), vec3(6, 0, 0), vec3(0, 0, -6), t.add_material(vec3(0.5f), 0.1f)));
  const uint32_t ball = t.add_mesh(test::sphere(3), t.add_material(vec3(0.9f, 0.4f, 0.1f), 0.2f));
  t.place(ball);
  t.place(ball, Affine(vec3(-0.5f, 0, 0), vec3(0, 0.7f, 0), vec3(0, 0, 0.5f), vec3(1.6f, 0, 0)));
  const uint32_t glass = t.add_material(vec3(0.2f, 0.5f, 0.8f), 0.0f);
  t.scene.materials[glass].alpha_mode = AlphaMode::blend;
  t.scene.materials[glass].base_color.w = 0.3f;
  t.place(t.add_mesh(test::sphere(2), glass),
          Affine(vec3(0.6f, 0, 0), vec3(0, 0.6f, 0), vec3(0, 0, 0.6f), vec3(-1, 0.3f, 1.5f)));
  t.add_light(LightType::directional, vec3(0.0f), normalize(vec3(1, -2, -1)), 2.0f);
  t.add_light(LightType::point, vec3(2, 3, 2), kBack, 5.0f);
  t.add_light(LightType::spot, vec3(-2, 4, 1), vec3(0.3f, -1, 0), 9.0f);
  return t;
}

TEST(Frame, SameBitsForEveryThreadCount) {
  TestScene t = busy_scene();
  uint64_t first = 0;
  for (int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    const Image image = t.render();
    if (threads == 1) first = test::hash_of(image);
    EXPECT_EQ(test::hash_of(image), first) << threads << " threads";
    for (const vec4& p : image.pixels) {
      ASSERT_TRUE(p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f && p.x < 1e3f);
      ASSERT_NEAR(p.w, 1.0f, 1e-5f);
    }
  }
}

TEST(Frame, ScratchMayServeOneFrameAfterAnotherAndAnotherScene) {
  TestScene busy = busy_scene(), plain;
  plain.place(plain.add_mesh(test::sphere(2), plain.add_material(vec3(0.5f))));
  const World busy_world = busy.prepare_world(), plain_world = plain.prepare_world();
  const RenderScratchPtr scratch = make_render_scratch();
  Image image;
  std::vector<uint64_t> hashes;
  for (int i = 0; i < 4; ++i) {
    TestScene& t = i % 2 == 0 ? busy : plain;
    const World& world = i % 2 == 0 ? busy_world : plain_world;
    render_frame(world, t.scene, world.pose(), t.camera, t.settings, *scratch, image);
    hashes.push_back(test::hash_of(image));
    EXPECT_EQ(hashes.back(), test::hash_of(t.render()));
  }
  EXPECT_EQ(hashes[0], hashes[2]);
  EXPECT_EQ(hashes[1], hashes[3]);
}

TEST(Frame, LargerThanOneBatch) {
  TestScene t;
  t.settings.width = 1000;
  t.settings.height = 301;
  t.scene.environment.horizon = vec3(0.25f);
  t.place(t.add_mesh(test::sphere(1), t.add_material(vec3(0.5f))));
  const Image image = t.render();
  EXPECT_EQ(t.stats.rays.primary, 301'000u);
  for (const vec4& p : image.pixels) ASSERT_EQ(p.w, 1.0f);
  expect_color(pixel(image, 999, 300), vec3(0.25f));
}

TEST(Frame, AnEmptyWorldShowsTheEnvironment) {
  TestScene t;
  t.scene.environment.horizon = vec3(0.1f, 0.2f, 0.3f);
  expect_color(pixel(t.render(), 0, 31), vec3(0.1f, 0.2f, 0.3f));
  t.settings.transparent = true;
  EXPECT_EQ(pixel(t.render(), 0, 31), vec4(0.0f));
}

}  // namespace
}  // namespace sinew
