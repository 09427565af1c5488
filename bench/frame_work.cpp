#include "bench/frame_work.h"

#include <algorithm>
#include <array>

#include "bench/measure.h"
#include "sinew/base/parallel.h"
#include "sinew/math/random.h"

namespace sinew::bench {
namespace {

constexpr size_t kRun = 1024;  // rays that are traced, and then shadowed, at a time

// Starts a little before the hit, so that the surface does not shade itself.
Ray shadow_ray(const Ray& primary, const Hit& hit, vec3 to_light) {
  return {.origin = primary.origin + (hit.t * (1.0f - 1e-4f)) * primary.direction,
          .direction = to_light};
}

PictureCounts trace_run(const Engine& engine, std::span<const Ray> primary, vec3 to_light) {
  std::array<Hit, kRun> hits;
  std::array<Ray, kRun> shadow;
  std::array<uint8_t, kRun> dark;
  engine.closest(primary, std::span(hits).first(primary.size()));
  size_t count = 0;
  for (size_t i = 0; i < primary.size(); ++i) {
    if (hits[i]) shadow[count++] = shadow_ray(primary[i], hits[i], to_light);
  }
  engine.any(std::span(shadow).first(count), std::span(dark).first(count));
  PictureCounts counts{count, count};
  for (size_t i = 0; i < count; ++i) counts.lit -= dark[i];
  return counts;
}

}  // namespace

PictureCounts trace_picture(const Engine& engine, const Picture& picture) {
  std::atomic<uint64_t> hits = 0, lit = 0;
  const std::span<const Ray> rays = picture.primary;
  parallel_for(rays.size(), kRun, [&](size_t begin, size_t end) {
    const PictureCounts run = trace_run(engine, rays.subspan(begin, end - begin), picture.to_light);
    hits.fetch_add(run.hits, std::memory_order_relaxed);
    lit.fetch_add(run.lit, std::memory_order_relaxed);
  });
  return {hits, lit};
}

std::string choose_embree_calls(Arena& arena, const Engine& embree, const Picture& picture) {
  constexpr int kTries = 3;
  const auto fastest = [&](const auto& use) {
    EmbreeCall best = EmbreeCall::single;
    double best_ms = 0.0;
    for (const EmbreeCall call : kEmbreeCalls) {
      use(call);
      std::vector<double> ms;
      for (int i = 0; i < kTries; ++i) {
        ms.push_back(milliseconds([&] { trace_picture(embree, picture); }));
      }
      if (call != kEmbreeCalls.front() && median(ms) >= best_ms) continue;
      best = call;
      best_ms = median(ms);
    }
    return best;
  };
  const EmbreeCall closest = fastest([&](EmbreeCall call) { arena.use(call, EmbreeCall::single); });
  const EmbreeCall any = fastest([&](EmbreeCall call) { arena.use(closest, call); });
  arena.use(closest, any);
  return std::string(name_of(closest)) + ", " + name_of(any);
}

void pick_rays(std::span<const Box> boxes, uint32_t seed, std::span<Ray> out) {
  Box all;
  for (const Box& box : boxes) all.extend(box);
  const vec3 center = all.center();
  const float radius = length(all.extent());
  Random random(seed);
  for (Ray& ray : out) {
    const Box& box = boxes[random.next() % boxes.size()];
    const vec3 target = box.center() + 0.5f * box.extent() * random.uniform3(-1.0f, 1.0f);
    const vec3 eye = center + radius * random.direction();
    ray = {.origin = eye, .direction = normalize(target - eye)};
  }
}

std::vector<Box> object_boxes(const Scene& scene, const ScenePose& pose) {
  const auto moves = [&](const SceneObject& object) {
    return deforms(motion_of(scene.meshes[object.mesh], object.skin >= 0));
  };
  const bool all = std::ranges::none_of(scene.objects, moves);
  std::vector<Box> boxes;
  std::vector<vec3> at;
  for (uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (!all && !moves(scene.objects[i])) continue;
    at.resize(scene.meshes[scene.objects[i].mesh].positions.size());
    world_positions(scene, pose, i, at);
    Box& box = boxes.emplace_back();
    for (const vec3 p : at) box.extend(p);
  }
  return boxes;
}

}  // namespace sinew::bench
