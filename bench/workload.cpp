#include "bench/workload.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/render/sampling.h"
#include "sinew/scene/sample.h"

namespace sinew::bench {
namespace {

constexpr uint32_t kShadowRays = 2, kAmbientRays = 8;
constexpr uint32_t kTile = 32;  // pixels
constexpr size_t kRun = 1024;   // rays

// Bits 0, 2, 4, 6, 8 of a Morton code, put together.
uint32_t even_bits(uint32_t code) {
  uint32_t out = 0;
  for (uint32_t bit = 0; bit < 5; ++bit) out |= (code >> (2 * bit) & 1u) << bit;
  return out;
}

}  // namespace

void flatten(const Scene& scene, const ScenePose& pose, FlatScene& out) {
  if (out.triangles.empty()) {
    uint32_t vertices = 0;
    for (const SceneObject& object : scene.objects) {
      const Mesh& mesh = scene.meshes[object.mesh];
      for (const uvec3 t : mesh.triangles) out.triangles.push_back(t + vertices);
      vertices += static_cast<uint32_t>(mesh.positions.size());
    }
    out.positions.resize(vertices);
  }
  size_t first = 0;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    const size_t count = scene.meshes[scene.objects[i].mesh].positions.size();
    const std::span<vec3> part(out.positions.data() + first, count);
    world_positions(scene, pose, i, part);
    first += count;
  }
}

std::vector<Ray> primary_rays(const CameraView& camera, uint32_t width, uint32_t height) {
  const CameraRays ray(camera, width, height);
  std::vector<Ray> rays;
  rays.reserve(size_t{width} * height);
  for (uint32_t tile_y = 0; tile_y < height; tile_y += kTile) {
    for (uint32_t tile_x = 0; tile_x < width; tile_x += kTile) {
      for (uint32_t i = 0; i < kTile * kTile; ++i) {
        const uint32_t x = tile_x + even_bits(i), y = tile_y + even_bits(i >> 1);
        if (x < width && y < height) rays.push_back(ray(float(x) + 0.5f, float(y) + 0.5f));
      }
    }
  }
  return rays;
}

void thin_out(std::vector<Ray>& rays, size_t most) {
  const size_t runs = rays.size() / kRun, kept = std::max<size_t>(most / kRun, 1);
  if (rays.size() <= most || runs <= kept) return;
  for (size_t i = 0; i < kept; ++i) {
    const auto from = rays.begin() + static_cast<std::ptrdiff_t>(i * runs / kept * kRun);
    std::copy_n(from, kRun, rays.begin() + static_cast<std::ptrdiff_t>(i * kRun));
  }
  rays.resize(kept * kRun);
}

Workload make_workload(const FlatScene& scene, std::vector<Ray> primary,
                       std::span<const Hit> hits) {
  SINEW_CHECK(primary.size() == hits.size());
  Box box;
  for (const vec3 p : scene.positions) box.extend(p);
  const float size = length(box.extent());
  const vec3 lights[kShadowRays] = {box.center() + size * vec3(0.6f, 0.9f, 0.5f),
                                    box.center() + size * vec3(-0.8f, 0.7f, 0.3f)};
  Workload out;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i]) continue;
    const uvec3 t = scene.triangles[hits[i].primitive];
    const vec3 a = scene.positions[t.x], b = scene.positions[t.y], c = scene.positions[t.z];
    vec3 normal = cross(b - a, c - a);
    if (!(dot(normal, normal) > 0.0f)) continue;
    normal = normalize(normal);
    if (dot(normal, primary[i].direction) > 0.0f) normal = -normal;
    const vec3 at = primary[i].origin + hits[i].t * primary[i].direction + normal * (size * 1e-5f);
    for (const vec3& light : lights) {
      out.shadow.push_back({.origin = at, .direction = light - at, .t_max = 1.0f});
    }
    const uint32_t seed = hash_u32(static_cast<uint32_t>(i));
    for (uint32_t k = 0; k < kAmbientRays; ++k) {
      // Stratified in one dimension, jittered in both.
      const float u = (float(k) + unit_float(hash_combine(seed, 2 * k))) / float(kAmbientRays);
      const float v = unit_float(hash_combine(seed, 2 * k + 1));
      out.ambient.push_back({.origin = at, .direction = cosine_direction(normal, {u, v})});
    }
  }
  out.primary = std::move(primary);
  return out;
}

}  // namespace sinew::bench
