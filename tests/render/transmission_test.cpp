// Light through surfaces: Snell's law, Fresnel's weights, tints and absorption by hand numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "render/test_scene.h"
#include "sinew/render/shade.h"

namespace sinew {
namespace {

using test::pixel;
using test::TestScene;

void expect_color(vec4 got, vec3 want, float tolerance = 1e-4f) {
  EXPECT_NEAR(got.x, want.x, tolerance);
  EXPECT_NEAR(got.y, want.y, tolerance);
  EXPECT_NEAR(got.z, want.z, tolerance);
}

// A scene with an unlit striped backdrop at z = -4: white for x > 0, dark red elsewhere.
struct GlassScene : TestScene {
  uint32_t glass;

  GlassScene() {
    const uint32_t white = add_material(vec3(1.0f)), red = add_material(vec3(0.2f, 0.0f, 0.0f));
    scene.materials[white].unlit = scene.materials[red].unlit = true;
    place(add_quad(vec3(0, -8, -4), vec3(8, 0, 0), vec3(0, 16, 0), white));
    place(add_quad(vec3(-8, -8, -4), vec3(8, 0, 0), vec3(0, 16, 0), red));
    glass = add_material(vec3(1.0f), 0.0f);
    Material& m = scene.materials[glass];
    m.transmission = 1.0f;
    m.ior = 1.5f;
    settings.shadows = false;
    settings.reflections = 0;
    add_light(LightType::directional, vec3(0.0f), vec3(0, 0, -1), 0.0f);
  }
  void add_pane(float z) {
    place(add_quad(vec3(-8, -8, z), vec3(16, 0, 0), vec3(0, 16, 0), glass));
  }
};

TEST(Transmission, SnellsLaw) {
  Surface surface;
  surface.normal = surface.geometric_normal = vec3(0, 1, 0);
  surface.transmitted = vec3(1.0f);
  for (const float bend : {1.0f / 1.5f, 1.0f, 1.5f}) {
    surface.bend = bend;
    for (float angle = 0.0f; angle < 1.5f; angle += 0.1f) {
      const vec3 view(std::sin(angle), std::cos(angle), 0.0f);
      const auto bent = refracted_direction(surface, view);
      const float sine = bend * std::sin(angle);
      ASSERT_EQ(bent.has_value(), sine < 1.0f) << angle;
      if (!bent) {
        EXPECT_NEAR(mirror_reflectance(surface, view).x, 1.0f - surface.roughness, 1e-6f);
        continue;
      }
      EXPECT_NEAR(bent->x, -sine, 1e-5f);
      EXPECT_NEAR(bent->y, -std::sqrt(1.0f - sine * sine), 1e-5f);
      EXPECT_NEAR(length(*bent), 1.0f, 1e-5f);
    }
  }
}

TEST(Transmission, BothSidesOfAnInterfaceReflectAlike) {
  // A ray and the one it is refracted into meet the same Fresnel reflectance.
  Surface outside, inside;
  outside.normal = inside.normal = vec3(0, 0, 1);
  outside.specular = inside.specular = vec3(0.04f);
  outside.roughness = inside.roughness = 0.0f;
  outside.bend = 1.0f / 1.5f;
  inside.bend = 1.5f;
  for (float angle = 0.0f; angle < 1.5f; angle += 0.1f) {
    const vec3 view(std::sin(angle), 0.0f, std::cos(angle));
    const float sine = std::sin(angle) / 1.5f;
    const vec3 within(sine, 0.0f, std::sqrt(1.0f - sine * sine));
    EXPECT_NEAR(mirror_reflectance(outside, view).x, mirror_reflectance(inside, within).x, 1e-5f);
  }
}

TEST(Transmission, AThinPaneTintsAndDoesNotBend) {
  GlassScene t;
  t.scene.materials[t.glass].base_color = vec4(0.5f, 0.8f, 1.0f, 1.0f);
  t.add_pane(0.0f);
  const Image image = t.render();
  // Seen straight on it reflects 4%, and the surroundings are black.
  expect_color(pixel(image, 20, 16), 0.96f * vec3(0.5f, 0.8f, 1.0f));
  expect_color(pixel(image, 16, 16), 0.96f * vec3(0.5f, 0.8f, 1.0f));
  expect_color(pixel(image, 15, 16), 0.96f * vec3(0.1f, 0.0f, 0.0f));
  EXPECT_EQ(t.stats.rays.refraction, 32u * 32u);
}

TEST(Transmission, BlendedGlassCoversNoMoreThanThePicture) {
  GlassScene t;
  t.scene.materials[t.glass].alpha_mode = AlphaMode::blend;
  t.scene.materials[t.glass].base_color.w = 0.5f;
  t.add_pane(0.0f);
  EXPECT_NEAR(pixel(t.render(), 20, 16).w, 1.0f, 1e-5f);  // in front of an opaque wall
  t.settings.transparent = true;
  for (Node& node : t.scene.nodes) node.visible = node.mesh == 2;
  EXPECT_NEAR(pixel(t.render(), 20, 16).w, 0.5f * 0.04f, 1e-5f);  // in front of nothing
}

TEST(Transmission, HalfATransmissiveSurfaceIsDiffuse) {
  GlassScene t;
  t.scene.materials[t.glass].transmission = 0.25f;
  t.scene.environment = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
  t.add_pane(0.0f);
  const Image image = t.render();
  // 0.75 of what is not reflected scatters the white surroundings, and 4% mirror them.
  expect_color(pixel(image, 20, 16), vec3(0.96f * (0.25f + 0.75f) + 0.04f));
  expect_color(pixel(image, 5, 16), vec3(0.96f * 0.75f + 0.04f) + 0.96f * 0.25f * vec3(0.2f, 0, 0));
}

TEST(Transmission, ASolidSlabShiftsWhatIsBehindItAndAbsorbs) {
  GlassScene t;
  Material& glass = t.scene.materials[t.glass];
  glass.thin = false;
  glass.attenuation_color = vec3(0.5f, 0.25f, 1.0f);
  glass.attenuation_distance = 2.0f;
  // One metre thick; outward normals on both sides.
  t.add_pane(0.0f);
  t.place(t.add_quad(vec3(8, -8, -1), vec3(-16, 0, 0), vec3(0, 16, 0), t.glass));
  const Image straight = t.render();
  const vec3 half_way = vec3(std::sqrt(0.5f), 0.5f, 1.0f);
  expect_color(pixel(straight, 20, 16), 0.96f * 0.96f * half_way);

  // Seen at 45 degrees the backdrop moves by d (tan(45) - tan(refracted)).
  const float sine = std::sqrt(0.5f) / 1.5f;
  const float shift = 1.0f - sine / std::sqrt(1.0f - sine * sine);
  const auto edge_column = [&](float x) {
    t.camera.to_world = look_at(vec3(x + 10, 0, 10), vec3(x, 0, 0), vec3(0, 1, 0), 1.0f).to_world;
    t.camera.ymag = 0.05f;
    const Image image = t.render();
    uint32_t dark = 0;
    while (dark < 32 && pixel(image, dark, 16).y < 0.1f) ++dark;
    return dark;
  };
  // The ray that meets z = 0 at x hits z = -4 at x - 4 + shift.
  EXPECT_EQ(edge_column(4.0f - shift), 16u);
  EXPECT_EQ(edge_column(4.0f), 0u);
}

TEST(Transmission, BeyondTheLastRefractionIsTheEnvironment) {
  GlassScene t;
  t.scene.environment = {vec3(0.0f, 0.5f, 0.0f), vec3(0.0f, 0.5f, 0.0f), vec3(0.0f, 0.5f, 0.0f)};
  for (int i = 0; i < 3; ++i) t.add_pane(static_cast<float>(-i));
  t.scene.materials[t.glass].specular = 0.0f;
  t.settings.refractions = 3;
  expect_color(pixel(t.render(), 20, 16), vec3(1.0f));
  t.settings.refractions = 2;
  expect_color(pixel(t.render(), 20, 16), vec3(0.0f, 0.5f, 0.0f));
}

TEST(Transmission, GlassCannotBeSeenInAWhiteFurnace) {
  // Whatever a ray does in clear glass, total reflection included, white light comes of it.
  for (const float roughness : {0.0f, 0.25f, 0.6f}) {
    TestScene t;
    const uint32_t glass = t.add_material(vec3(1.0f), roughness);
    t.scene.materials[glass].transmission = 1.0f;
    t.scene.materials[glass].thin = false;
    t.scene.environment = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), low(-0.5f), high(0.5f);
    for (const auto& [a, b] : {std::pair(x, y), std::pair(y, z), std::pair(z, x)}) {
      t.place(t.add_quad(low, b, a, glass));
      t.place(t.add_quad(high, -a, -b, glass));
    }
    t.add_light(LightType::directional, vec3(0.0f), vec3(0, 0, -1), 0.0f);
    t.camera = look_at(vec3(1.5f, 1.0f, 2.0f), vec3(0.0f), y, 0.8f);
    t.settings.reflections = 4;
    for (const vec4& p : t.render().pixels) expect_color(p, vec3(1.0f), 1e-3f);
    EXPECT_GT(t.stats.rays.refraction, t.stats.rays.primary / 2);
  }
}

TEST(Transmission, ShadowsAreTinted) {
  TestScene t;
  const uint32_t white = t.add_material(vec3(1.0f));
  t.scene.materials[white].specular = 0.0f;
  const uint32_t glass = t.add_material(vec3(0.5f, 1.0f, 0.25f), 0.0f);
  t.scene.materials[glass].transmission = 1.0f;
  t.scene.materials[glass].specular = 0.0f;
  t.place(t.add_quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), white));
  // Between the light and the right half, off the camera's sight: the light shines aslant.
  t.place(t.add_quad(vec3(3, -1, 3), vec3(1, 0, 0), vec3(0, 2, 0), glass));
  t.add_light(LightType::directional, vec3(0.0f), vec3(-1, 0, -1), 3.0f);
  const Image image = t.render();
  const vec3 open = vec3(pixel(image, 4, 16));
  EXPECT_GT(open.x, 0.1f);
  expect_color(pixel(image, 28, 16), open * vec3(0.5f, 1.0f, 0.25f), 1e-3f);
}

TEST(Transmission, LightsWithoutFalloffAndAmbientOfTheirOwn) {
  ShadingLight light;
  light.type = LightType::point;
  light.intensity = vec3(2.0f);
  light.falloff = false;
  EXPECT_EQ(illuminate(light, vec3(0, 0, 5)).irradiance, vec3(2.0f));
  EXPECT_EQ(illuminate(light, vec3(0, 0, 50)).irradiance, vec3(2.0f));
  light.falloff = true;
  EXPECT_NEAR(illuminate(light, vec3(0, 0, 5)).irradiance.x, 2.0f / 25.0f, 1e-7f);

  Surface surface;
  surface.albedo = vec3(0.5f);
  surface.normal = vec3(0, 1, 0);
  Environment environment{vec3(1.0f), vec3(1.0f), vec3(1.0f)};
  EXPECT_NEAR(scatter_environment(surface, environment, vec3(0, 1, 0), 1.0f, 1.0f).x, 0.5f, 1e-6f);
  environment.ambient = vec3(0.25f);
  EXPECT_NEAR(scatter_environment(surface, environment, vec3(0, 1, 0), 1.0f, 1.0f).x, 0.125f,
              1e-6f);
}

}  // namespace
}  // namespace sinew
