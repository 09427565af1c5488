// The SIMD shading of voxels against shade.h, lights.h and lit_share(), one voxel at a time; and
// fetching against sample_voxel().
#include "sinew/render/voxels/voxel_shade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "sinew/math/color.h"
#include "sinew/math/random.h"
#include "sinew/render/raster_view.h"
#include "sinew/render/shade.h"
#include "svo/svo_oracle.h"

namespace sinew {
namespace {

VoxelMaterial random_material(Random& random, bool unlit) {
  VoxelMaterial m;
  m.dielectric = vec3(random.uniform(0.0f, 0.2f));
  m.specular = random.uniform(0.0f, 1.0f);
  m.emission = vec3(random.uniform(0.0f, 0.3f), 0.0f, 0.1f);
  m.metallic = random.uniform(0.0f, 1.0f);
  m.roughness = random.uniform(0.0f, 1.0f);
  m.occlusion = random.uniform(0.0f, 1.0f);
  m.unlit = unlit ? 1.0f : 0.0f;
  return m;
}

VoxelSample random_sample(Random& random, uint32_t materials) {
  VoxelSample s;
  s.material = random.next() % materials;
  s.position = vec3(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f), 0.0f);
  s.position.z = random.uniform(-1.0f, 1.0f);
  s.size = random.uniform(0.001f, 0.05f);
  s.normal = random.direction();
  s.color = unpack_color(static_cast<uint16_t>(random.next()));
  s.spread = random.next() % 2 == 0 ? 1.0f : random.uniform(0.0f, 1.0f);
  return s;
}

std::vector<ShadingLight> some_lights() {
  ShadingLight sun{.direction = normalize(vec3(-0.4f, -0.8f, 0.2f)), .intensity = vec3(2, 1.5f, 1)};
  ShadingLight lamp{.type = LightType::point, .position = vec3(2, 1, 0.5f)};
  lamp.intensity = vec3(3.0f);
  lamp.range = 4.0f;
  ShadingLight spot{.type = LightType::spot, .position = vec3(0, 2.5f, 1)};
  spot.direction = normalize(vec3(0.1f, -1.0f, -0.2f));
  spot.intensity = vec3(4, 0, 2);
  spot.falloff = false;
  spot.cone_scale = 1.0f / (std::cos(0.2f) - std::cos(0.6f));
  spot.cone_offset = -std::cos(0.6f) * spot.cone_scale;
  return {sun, lamp, spot};
}

// Maps as the lights see the unit ball about the origin, full of depths that hide about half.
VoxelShadowMap random_shadow(Random& random, const ShadingLight& light) {
  VoxelShadowMap out;
  const Box box{vec3(-1.0f), vec3(1.0f)};
  const uint32_t size = 48;
  if (light.type == LightType::directional) {
    out.views = 1;
    out.view[0] = directional_view(light.direction, {&box, 1}, size);
    out.texel = 2.5f / static_cast<float>(size);
  } else {
    out.views = light_views(light, 1e-3f, size, out.view);
    out.texel = 2.0f / static_cast<float>(size);
  }
  for (uint32_t v = 0; v < out.views; ++v) {
    out.map[v].width = out.map[v].height = size;
    out.map[v].depth.resize(size_t{size} * size);
    for (float& depth : out.map[v].depth) depth = random.uniform(0.0f, 6.0f);
  }
  return out;
}

vec3 shade_one(const VoxelLighting& l, const VoxelSample& sample) {
  const vec3 view = l.camera.orthographic ? l.camera.to_world[2]
                                          : normalize(l.camera.to_world[3] - sample.position);
  Surface s;
  resolve_voxel(sample, std::sqrt(3.0f) * sample.size, l.materials[sample.material], view, s);
  if (s.unlit) return s.emission;
  vec3 sum = s.emission;
  for (size_t i = 0; i < l.lights.size(); ++i) {
    const Illumination in = illuminate(l.lights[i], s.position);
    const vec3 light =
        in.irradiance * scatter(s, view, in.direction,
                                l.lights[i].falloff ? Highlight::normalized : Highlight::phong);
    const float cosine = std::clamp(dot(s.normal, in.direction), 0.0f, 1.0f);
    sum += light * lit_share(l.shadows[i], {s.position, s.normal, cosine, s.voxel});
  }
  const vec3 reflectance = mirror_reflectance(s, view);
  float traced = l.mirrors ? mirror_share(s.roughness) : 0.0f;
  if (largest(traced * reflectance) < 0.01f) traced = 0.0f;
  sum += traced * reflectance * environment_radiance(l.environment, mirror_direction(s, view));
  return sum + scatter_environment(s, l.environment, view, 1.0f, traced);
}

void expect_same_light(const VoxelLighting& lighting, uint32_t count, Random& random) {
  auto batch = std::make_unique<VoxelBatch>();
  std::vector<VoxelSample> samples;
  batch->count = count;
  for (uint32_t i = 0; i < count; ++i) {
    samples.push_back(random_sample(random, static_cast<uint32_t>(lighting.materials.size())));
    batch->set(i, samples[i]);
  }
  batch->pad();
  alignas(64) static Radiance out;
  shade_voxels(lighting, *batch, out);
  uint32_t different = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const vec3 expected = shade_one(lighting, samples[i]);
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(out[i][c])) << i;
      // A depth at the very edge of a texel or of a voxel may fall on either side.
      different += std::abs(out[i][c] - expected[c]) > 2e-4f * (1.0f + expected[c]);
    }
    EXPECT_EQ(out[i][3], 1.0f);
  }
  EXPECT_LE(different, count / 100);
}

TEST(VoxelShade, KernelAgreesWithScalarShading) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    std::vector<VoxelMaterial> materials;
    for (uint32_t i = 0; i < (seed == 1 ? 1u : 7u); ++i) {
      materials.push_back(random_material(random, i == 5));
    }
    const std::vector<ShadingLight> lights = some_lights();
    std::vector<VoxelShadowMap> shadows(lights.size());
    if (seed >= 3) {
      for (size_t i = 0; i < lights.size(); ++i) shadows[i] = random_shadow(random, lights[i]);
    }
    VoxelLighting lighting{materials, lights, shadows, {}, {}, seed % 2 == 0};
    if (seed == 5) lighting.environment.ambient = vec3(0.3f, 0.2f, 0.1f);
    lighting.camera = look_at(vec3(0.5f, 1, 5), vec3(0.0f), vec3(0, 1, 0), 0.7f);
    lighting.camera.orthographic = seed == 4;
    expect_same_light(lighting, seed == 2 ? 37 : kMostWinners, random);
  }
}

TEST(VoxelShade, RoughnessGrowsWithTheSpreadOfNormals) {
  EXPECT_FLOAT_EQ(widened_roughness(0.3f, 1.0f), 0.3f);
  EXPECT_NEAR(widened_roughness(0.3f, 0.9999f), 0.3f, 0.01f);
  EXPECT_FLOAT_EQ(widened_roughness(0.3f, 0.0f), 1.0f);
  // Exponent 30 and a mean of length 0.9: 30 * 0.9 / (0.9 + 3) = 6.923; (2 / 8.923)^(1/4).
  EXPECT_NEAR(widened_roughness(0.5f, 0.9f), 0.68806f, 1e-4f);
}

TEST(VoxelShade, BackgroundIsTheEnvironmentOfCameraRays) {
  const Environment environment;
  for (const bool orthographic : {false, true}) {
    CameraView camera = look_at(vec3(1, 2, 3), vec3(0, 0.5f, 0), vec3(0, 1, 0), 1.0f);
    camera.orthographic = orthographic;
    const CameraRays rays(camera, 101, 67);
    std::vector<vec4> row(37);
    shade_background(environment, camera, {3.5f, 1.0f, 20.25f, 101, 67, 37}, row.data());
    for (uint32_t i = 0; i < row.size(); ++i) {
      const vec3 expected =
          environment_radiance(environment, rays(3.5f + static_cast<float>(i), 20.25f).direction);
      EXPECT_NEAR(length(vec3(row[i]) - expected), 0.0f, 1e-5f);
      EXPECT_EQ(row[i].w, 1.0f);
    }
  }
}

// Two ends a brick and selectors instead of a colour a voxel.
void select_colors(Svo& svo, Random& random) {
  svo.colors.clear();
  for (size_t i = 0; i < svo.bricks.size(); ++i) {
    SvoColorEnds ends;
    ends.a = static_cast<uint16_t>(random.next());
    ends.b = static_cast<uint16_t>(random.next());
    svo.color_ends.push_back(ends);
  }
  for (uint64_t i = 0; i < svo.voxel_count(); i += 16) svo.color_selectors.push_back(random.next());
}

void expect_fetched(uint32_t seed, bool selectors) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  const std::vector<PlainVoxel> voxels = test::random_voxels(150, 60000, 3, seed);
  Svo svo = *make_svo({vec3(-1.0f), 2.0f / 150.0f, uvec3(150)}, voxels);
  if (selectors) select_colors(svo, random);
  const SvoMotion motion = make_svo_motion(svo);
  PosedSvo posed;
  posed.set_pose(motion, {});
  for (uint32_t b = 0; b < svo.block_count(); ++b) posed.make_block(b);
  Affine turned = trs(vec3(1, 2, 3), glm::angleAxis(1.0f, vec3(0, 0.6f, 0.8f)), vec3(2, 1, -0.5f));
  const VoxelInstance instances[2] = {{&posed, identity_affine(), 0},
                                      {&posed, turned, unit_count(svo)}};
  const std::vector<test::ReadVoxel> read = test::read_voxels(svo);
  std::vector<VisibilityKey> keys;
  for (uint32_t i = 0; i < kMostWinners; ++i) {
    const test::ReadVoxel& voxel = read[random.next() % read.size()];
    const uint32_t code = voxel.code;
    uint32_t named = code;  // or a coarser voxel that holds it
    const uint32_t local = code & 63, brick = code >> 6;
    switch (random.next() % 4) {
      case 1: {
        const uvec3 at = place_of(code).min / 2u;
        named = kFirstCode[1] + at.x + 4 * at.y + 16 * at.z;
        break;
      }
      case 2:
        named = kFirstCode[2] + brick;
        break;
      case 3:
        named = kFirstCode[3];
        break;
      default:
        ASSERT_LT(local, 64u);
    }
    const uint32_t instance = random.next() % 2;
    keys.push_back(make_key(1.0f, instances[instance].first_unit + voxel.cell, named));
  }
  auto batch = std::make_unique<VoxelBatch>();
  fetch_voxels(instances, keys, *batch);
  ASSERT_EQ(batch->count, keys.size());
  for (uint32_t i = 0; i < keys.size(); ++i) {
    const VoxelSample s = sample_voxel(instances, keys[i]);
    const vec3 place(batch->place[i][0], batch->place[i][1], batch->place[i][2]);
    const vec3 normal(batch->normal[i][0], batch->normal[i][1], batch->normal[i][2]);
    EXPECT_NEAR(length(place - s.position), 0.0f, 1e-5f);
    EXPECT_NEAR(length(normalize(normal) - s.normal), 0.0f, 1e-5f);
    const vec3 color(batch->color[i][0], batch->color[i][1], batch->color[i][2]);
    if (s.level == 1) {  // means are summed in another order
      EXPECT_NEAR(batch->normal[i][3], s.spread, 1e-6f);
      EXPECT_NEAR(length(color - s.color), 0.0f, 1e-6f);
    } else {
      EXPECT_EQ(batch->normal[i][3], s.spread);
      EXPECT_EQ(color, s.color);
    }
    EXPECT_EQ(batch->material[i], s.material);
    if (s.instance == 0) {
      const float side = static_cast<float>(1u << s.level) * svo.grid.voxel;
      EXPECT_NEAR(batch->place[i][3], std::sqrt(3.0f) * side, 1e-5f);
    }
  }
}

TEST(VoxelFetch, GivesWhatSampleVoxelGives) {
  for (uint32_t seed = 3; seed < 7; ++seed) expect_fetched(seed, false);
}

TEST(VoxelFetch, OfColoursBetweenTwoEnds) {
  for (uint32_t seed = 13; seed < 17; ++seed) expect_fetched(seed, true);
}

}  // namespace
}  // namespace sinew
