#include "sinew/scene/procedural/terrain.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

constexpr float kTwoPi = 6.28318531f;

vec3 ground_color(float x, float z, float height, float steepness) {
  constexpr vec3 kGrass(0.105f, 0.135f, 0.030f), kStraw(0.30f, 0.235f, 0.085f),
      kEarth(0.17f, 0.115f, 0.065f), kRock(0.21f, 0.195f, 0.175f);
  const float patches = fractal_noise(vec3(0.045f * x, 0.045f * z, 7.0f), 5, 21);
  const float spots = fractal_noise(vec3(0.6f * x, 0.6f * z, 3.0f), 3, 33);
  vec3 color = glm::mix(kGrass, kStraw, glm::smoothstep(-0.30f, 0.45f, patches + 0.3f * spots));
  // Trodden along the middle of the valley.
  const float aside = std::abs(x - valley_middle(z)) + 5.0f * patches;
  color = glm::mix(color, kEarth, 0.55f * glm::smoothstep(13.0f, 3.0f, aside + 9.0f * spots));
  const float rock = glm::smoothstep(0.42f, 0.75f, steepness + 0.25f * spots);
  color = glm::mix(color, kRock, rock);
  return color * (1.0f + 0.35f * spots) * (1.0f + 0.004f * height);
}

}  // namespace

float valley_middle(float z) {
  return 9.0f * std::sin(0.021f * z) + 4.0f * std::sin(0.047f * z + 1.0f);
}
float valley_slope(float z) {
  return 9.0f * 0.021f * std::cos(0.021f * z) + 4.0f * 0.047f * std::cos(0.047f * z + 1.0f);
}

float terrain_height(float x, float z) {
  const float rolling = 1.5f * gradient_noise(vec3(0.032f * x, 0.032f * z, 0.5f), 1) +
                        0.35f * gradient_noise(vec3(0.11f * x, 0.11f * z, 0.5f), 2);
  // Hills rise at the sides and at both ends; the higher, the rougher.
  const float aside = (std::abs(x - valley_middle(z)) - 34.0f) / 75.0f;
  const float beyond = (std::abs(z) - 120.0f) / 80.0f;
  const float rise =
      std::max(glm::smoothstep(0.0f, 1.0f, aside), 0.8f * glm::smoothstep(0.0f, 1.0f, beyond));
  const vec3 at(0.016f * x, 0.016f * z, 4.0f);
  const float ridges = 1.0f - std::abs(fractal_noise(at, 7, 5)) * 2.0f;
  const float bumps = 0.05f * fractal_noise(vec3(0.9f * x, 0.9f * z, 2.0f), 3, 9);
  return rolling + rise * (10.0f + 34.0f * ridges * ridges) + (1.0f + 6.0f * rise) * bumps;
}

Mesh make_terrain(uint32_t triangles, float tile, uint32_t material) {
  const float cells = 0.5f * static_cast<float>(triangles);
  const auto columns = std::max(
      2u, static_cast<uint32_t>(std::lround(std::sqrt(cells * kTerrainWidth / kTerrainLength))));
  const auto rows =
      std::max(2u, static_cast<uint32_t>(std::lround(cells / static_cast<float>(columns))));
  Mesh mesh;
  mesh.name = "terrain";
  const size_t stride = columns + 1, count = stride * (rows + 1);
  mesh.positions.resize(count);
  mesh.normals.resize(count);
  mesh.colors.resize(count);
  mesh.texcoords[0].resize(count);
  mesh.triangles.resize(size_t{2} * columns * rows);
  const float dx = kTerrainWidth / static_cast<float>(columns),
              dz = kTerrainLength / static_cast<float>(rows);
  parallel_for(rows + 1, 4, [&](size_t begin, size_t end) {
    for (size_t r = begin; r < end; ++r) {
      for (size_t c = 0; c < stride; ++c) {
        const float x = dx * static_cast<float>(c) - 0.5f * kTerrainWidth;
        const float z = dz * static_cast<float>(r) - 0.5f * kTerrainLength;
        mesh.positions[r * stride + c] = {x, terrain_height(x, z), z};
        mesh.texcoords[0][r * stride + c] = vec2(x, z) / tile;
      }
    }
  });
  parallel_for(rows + 1, 4, [&](size_t begin, size_t end) {
    for (size_t r = begin; r < end; ++r) {
      for (size_t c = 0; c < stride; ++c) {
        const auto at = [&](size_t row, size_t column) {
          return mesh.positions[row * stride + column];
        };
        const vec3 along = at(r, std::min<size_t>(c + 1, columns)) - at(r, c == 0 ? 0 : c - 1);
        const vec3 down = at(std::min<size_t>(r + 1, rows), c) - at(r == 0 ? 0 : r - 1, c);
        const vec3 normal = normalize(cross(down, along)), p = at(r, c);
        mesh.normals[r * stride + c] = normal;
        mesh.colors[r * stride + c] = vec4(ground_color(p.x, p.z, p.y, 1.0f - normal.y), 1.0f);
        if (r == rows || c == columns) continue;
        const auto a = static_cast<uint32_t>(r * stride + c), b = static_cast<uint32_t>(a + stride);
        mesh.triangles[2 * (r * columns + c)] = {a, b, a + 1};
        mesh.triangles[2 * (r * columns + c) + 1] = {a + 1, b, b + 1};
      }
    }
  });
  mesh.parts.push_back({material, false});
  mesh.triangle_part.assign(mesh.triangles.size(), 0);
  return mesh;
}

Image8 paint_grass(uint32_t resolution) {
  return paint_image(resolution, resolution, [](float u, float v) {
    // On a torus in space, so that it repeats.
    const float a = kTwoPi * u, b = kTwoPi * v;
    const vec3 at((2.0f + std::cos(a)) * std::cos(b), (2.0f + std::cos(a)) * std::sin(b),
                  std::sin(a));
    const float blades = fractal_noise(9.0f * at, 5, 61);
    return vec3(glm::clamp(0.80f + 0.62f * blades, 0.25f, 1.0f));
  });
}

}  // namespace sinew
