#include "sinew/render/shade.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/math/random.h"
#include "sinew/render/ray_filter.h"
#include "sinew/render/sampling.h"

namespace sinew {
namespace {

constexpr float kPi = 3.14159265f;
const vec3 kUp(0.0f, 1.0f, 0.0f);

Surface plane(vec3 albedo, vec3 specular, float roughness) {
  Surface surface;
  surface.normal = surface.geometric_normal = kUp;
  surface.albedo = albedo;
  surface.specular = specular;
  surface.roughness = roughness;
  return surface;
}

TEST(Shade, DiffusePartIsLambert) {
  const Surface surface = plane(vec3(0.8f, 0.4f, 0.2f), vec3(0.0f), 1.0f);
  // With no reflectance at normal incidence and light from the viewer there is no gloss at all.
  for (float angle : {0.0f, 0.5f, 1.0f, 1.5f}) {
    const vec3 l(std::sin(angle), std::cos(angle), 0.0f);
    const vec3 out = scatter(surface, l, l);
    EXPECT_NEAR(out.x, 0.8f / kPi * std::cos(angle), 1e-6f);
    EXPECT_NEAR(out.z, 0.2f / kPi * std::cos(angle), 1e-6f);
  }
  EXPECT_EQ(scatter(surface, kUp, -kUp), vec3(0.0f));
}

TEST(Shade, HighlightByHand) {
  // Metal of roughness 0.5: alpha = 0.25, exponent 30. View and light at 30 degrees to the normal
  // on either side: the half vector is the normal.
  const Surface surface = plane(vec3(0.0f), vec3(0.9f, 0.6f, 0.3f), 0.5f);
  EXPECT_NEAR(phong_exponent(0.5f), 30.0f, 1e-3f);
  const vec3 v(0.5f, std::sqrt(0.75f), 0.0f), l(-0.5f, std::sqrt(0.75f), 0.0f);
  const float schlick = std::pow(1.0f - std::sqrt(0.75f), 5.0f);
  const float expected = (0.9f + 0.1f * schlick) * 38.0f / (8.0f * kPi) * std::sqrt(0.75f);
  EXPECT_NEAR(scatter(surface, v, l).x, expected, 1e-5f);
}

// The normalisation is exact for a highlight seen head-on; at a slant it may be 8% too bright.
TEST(Shade, ReflectsNoMoreThanArrives) {
  for (float roughness : {0.0f, 0.2f, 0.4f, 0.7f, 1.0f}) {
    for (float specular : {0.04f, 1.0f}) {
      const Surface surface = plane(vec3(specular < 1.0f ? 1.0f : 0.0f), vec3(specular), roughness);
      for (float tilt : {0.0f, 0.7f, 1.3f}) {
        const vec3 view(std::sin(tilt), std::cos(tilt), 0.0f);
        double sum = 0.0;
        constexpr uint32_t kCount = 1 << 15;
        for (uint32_t i = 0; i < kCount; ++i) {
          // Uniform over the hemisphere: density 1 / (2 pi).
          const vec2 p = hammersley(i, kCount);
          const float r = std::sqrt(1.0f - p.x * p.x), phi = 2.0f * kPi * p.y;
          const vec3 l(r * std::cos(phi), p.x, r * std::sin(phi));
          sum += scatter(surface, view, l).x * 2.0f * kPi / kCount;
        }
        EXPECT_LT(sum, 1.08) << roughness << ' ' << specular << ' ' << tilt;
      }
    }
  }
}

TEST(Shade, MirrorDirectionObeysTheLaw) {
  Surface surface = plane(vec3(0.0f), vec3(1.0f), 0.0f);
  const vec3 view = normalize(vec3(1.0f, 2.0f, 0.5f));
  const vec3 out = mirror_direction(surface, view);
  EXPECT_NEAR(length(out - normalize(vec3(-1.0f, 2.0f, -0.5f))), 0.0f, 1e-6f);
  surface.normal = normalize(vec3(-1.0f, 0.2f, 0.0f));  // would reflect into the ground
  const vec3 bent = mirror_direction(surface, normalize(vec3(-1.0f, -0.1f, 0.0f) * -1.0f + kUp));
  EXPECT_GT(dot(bent, surface.geometric_normal), 0.0f);
}

TEST(Shade, AmbientIsTheMeanOfTheEnvironment) {
  Environment environment;
  environment.zenith = vec3(1.0f, 0.2f, 0.0f);
  environment.horizon = vec3(0.5f, 0.5f, 1.0f);
  environment.nadir = vec3(0.1f, 0.0f, 0.3f);
  Random random(3);
  for (int round = 0; round < 8; ++round) {
    const vec3 n = round == 0 ? kUp : round == 1 ? -kUp : random.direction();
    vec3 mean(0.0f);
    constexpr uint32_t kCount = 1 << 14;
    for (uint32_t i = 0; i < kCount; ++i) {
      mean += environment_radiance(environment, cosine_direction(n, hammersley(i, kCount))) /
              static_cast<float>(kCount);
    }
    EXPECT_NEAR(length(mean - environment_ambient(environment, n)), 0.0f, 2e-3f);
  }
}

TEST(Lights, PointLightFallsWithTheSquare) {
  ShadingLight light;
  light.type = LightType::point;
  light.position = vec3(0.0f, 3.0f, 0.0f);
  light.intensity = vec3(8.0f, 4.0f, 2.0f);
  const Illumination near = illuminate(light, vec3(0.0f, 1.0f, 0.0f));
  EXPECT_NEAR(near.irradiance.x, 2.0f, 1e-6f);
  EXPECT_NEAR(near.distance, 2.0f, 1e-6f);
  EXPECT_EQ(near.direction, kUp);
  EXPECT_NEAR(illuminate(light, vec3(0.0f, -1.0f, 0.0f)).irradiance.y, 0.25f, 1e-6f);
  light.range = 4.0f;  // window 1 - (2 / 4)^4
  EXPECT_NEAR(illuminate(light, vec3(0.0f, 1.0f, 0.0f)).irradiance.x, 2.0f * 0.9375f, 1e-6f);
  EXPECT_EQ(illuminate(light, vec3(0.0f, -1.5f, 0.0f)).irradiance, vec3(0.0f));
}

TEST(Lights, SpotFadesBetweenItsCones) {
  Scene scene;
  Light lamp;
  lamp.type = LightType::spot;
  lamp.inner_cone = 0.2f;
  lamp.outer_cone = 0.4f;
  scene.lights.push_back(lamp);
  scene.nodes.resize(1);
  scene.nodes[0].light = 0;
  ScenePose pose;
  pose.nodes = {identity_affine()};  // shines along -z
  pose.visible = {1};
  std::vector<ShadingLight> lights;
  gather_lights(scene, pose, {}, lights);
  ASSERT_EQ(lights.size(), 1u);
  const auto at = [&](float angle) {
    return illuminate(lights[0], vec3(std::sin(angle), 0.0f, -std::cos(angle))).irradiance.x;
  };
  EXPECT_NEAR(at(0.1f), 1.0f, 1e-5f);
  const float t = (std::cos(0.3f) - std::cos(0.4f)) / (std::cos(0.2f) - std::cos(0.4f));
  EXPECT_NEAR(at(0.3f), t * t, 1e-5f);
  EXPECT_EQ(at(0.45f), 0.0f);
}

TEST(Lights, HiddenLightsAreOffAndNoLightsMeanADefaultSet) {
  Scene scene;
  ScenePose pose;
  std::vector<ShadingLight> lights;
  gather_lights(scene, pose, {}, lights);
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_TRUE(lights[0].shadows);
  EXPECT_FALSE(lights[1].shadows);
  EXPECT_LT(lights[0].direction.y, 0.0f);

  scene.lights.emplace_back();
  scene.nodes.resize(1);
  scene.nodes[0].light = 0;
  pose.nodes = {identity_affine()};
  pose.visible = {0};
  gather_lights(scene, pose, {}, lights);
  EXPECT_TRUE(lights.empty());
}

TEST(Alpha, TransmittanceDoesNotDependOnOrder) {
  Scene scene;
  Mesh mesh;
  mesh.positions = {vec3(0.0f), vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 1.0f, 0.0f)};
  const float alphas[] = {0.1f, 0.37f, 0.5f, 0.8f};
  for (uint32_t i = 0; i < 4; ++i) {
    Material material;
    material.alpha_mode = AlphaMode::blend;
    material.base_color.w = alphas[i];
    scene.materials.push_back(material);
    mesh.triangles.push_back(uvec3(0, 1, 2));
    mesh.triangle_part.push_back(i);
    mesh.parts.push_back({i, false});
  }
  scene.meshes.push_back(mesh);
  scene.objects.emplace_back();
  const auto through = [&](std::initializer_list<uint32_t> triangles) {
    uvec3 depth[1] = {uvec3(0u)};
    const TextureTable textures;
    const FilterContext context{nullptr, &scene, nullptr, depth, &textures};
    const HitFilter filter = shadow_filter(context);
    for (uint32_t t : triangles) {
      EXPECT_FALSE(filter.accept(filter.context, 0, {1.0f, 0.25f, 0.25f, t, 0}));
    }
    return transmittance(depth[0]);
  };
  EXPECT_EQ(through({}), vec3(1.0f));
  EXPECT_NEAR(through({0, 1, 2, 3}).x, 0.9f * 0.63f * 0.5f * 0.2f, 1e-4f);
  EXPECT_EQ(through({0, 1, 2, 3}), through({3, 0, 2, 1}));
}

}  // namespace
}  // namespace sinew
