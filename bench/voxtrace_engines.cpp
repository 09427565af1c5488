#include "bench/voxtrace_engines.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "bench/workload.h"
#include "sinew/base/parallel.h"
#include "sinew/motion/motion.h"

namespace sinew::bench {
namespace {

constexpr uint32_t kSeed = 20261123;
constexpr uint32_t kAmbientRays = 4;

float uniform(std::mt19937& random) {
  return static_cast<float>(random() >> 8) * 0x1p-24f;
}

vec3 around(vec3 normal, float u, float v) {
  const float angle = 6.2831853f * u, radius = std::sqrt(v);
  const vec3 helper = std::abs(normal.x) < 0.5f ? vec3(1, 0, 0) : vec3(0, 1, 0);
  const vec3 x = normalize(cross(normal, helper)), y = cross(normal, x);
  return normalize(radius * (std::cos(angle) * x + std::sin(angle) * y) +
                   std::sqrt(std::max(1.0f - v, 0.0f)) * normal);
}

}  // namespace

const char* name_of(VoxtraceEngine engine) {
  constexpr const char* kNames[] = {"triangles", "animated", "voxelised anew"};
  return kNames[size_t(engine)];
}

const char* name_of(RayKind kind) {
  constexpr const char* kNames[] = {"primary", "shadow", "ambient"};
  return kNames[size_t(kind)];
}

uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

Result<VoxtraceWorlds> VoxtraceWorlds::open(const AsvoBody& body) {
  VoxtraceWorlds out(body);
  for (const VoxtraceEngine engine : kVoxtraceEngines) {
    if (engine == VoxtraceEngine::anew) {
      SINEW_CHECKED(out.voxelise_anew(0.0));
    } else {
      const bool triangles = engine == VoxtraceEngine::triangles;
      SINEW_TRY(World world, prepare(triangles ? body.triangles : body.voxels));
      out.worlds_[size_t(engine)] = std::make_unique<World>(std::move(world));
    }
  }
  return out;
}

Result<void> VoxtraceWorlds::set_pose(VoxtraceEngine engine, double u) {
  if (engine == VoxtraceEngine::anew) return voxelise_anew(u);
  const std::vector<Clip>& clips = body_->triangles.clips;
  if (clips.empty()) return {};
  return worlds_[size_t(engine)]->set_time(clips[0].start + u * (clips[0].end - clips[0].start));
}

Result<void> VoxtraceWorlds::voxelise_anew(double u) {
  AsvoPose pose;
  pose_at(*body_, 0, u, pose);
  std::vector<vec3> moved(body_->rest.size());
  parallel_for(moved.size(), 4096, [&](size_t begin, size_t end) {
    positions(body_->motion(), pose.pose, static_cast<uint32_t>(begin),
              std::span(moved).subspan(begin, end - begin));
  });
  SINEW_TRY(const VoxelGrid grid,
            grid_of_voxels(surface_box(moved, body_->faces), body_->surface.grid.voxel));
  SINEW_TRY(const VoxelSurface surface, voxelise_at(*body_, moved, grid));
  SINEW_TRY(Svo svo, make_svo(surface, {body_->faces, body_->materials, RigidMotion{moved}}));
  auto world = std::make_unique<World>();
  auto next = std::make_unique<Svo>(std::move(svo));
  SINEW_TRY(const BodyId id, world->add_octree({next.get(), {}}));
  SINEW_TRY(const ObjectId object, world->add_object(id));
  SINEW_CHECKED(world->set_pose(object, Pose{}));
  world->commit();
  worlds_[size_t(VoxtraceEngine::anew)] = std::move(world);
  anew_ = std::move(next);
  return {};
}

VoxtraceRays make_voxtrace_rays(const World& triangles, const CameraView& camera, uint32_t size,
                                float lift, size_t most) {
  VoxtraceRays out;
  std::vector<Ray>& primary = out.rays[size_t(RayKind::primary)];
  primary = primary_rays(camera, size, size);
  std::vector<Hit> hits(primary.size());
  triangles.closest_hits(primary, hits);
  const Box box = triangles.box();
  const vec3 eye = camera.to_world[3], up = camera.to_world[1];
  const float reach = length(box.extent());
  const vec3 lights[] = {eye + reach * up, eye + reach * (camera.to_world[0] + 0.5f * up)};
  std::mt19937 random(kSeed);
  uint64_t met = 0;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].object == kNoObject) continue;
    ++met;
    const std::array<vec3, 3> corner = triangles.triangle(hits[i].object, hits[i].primitive);
    const vec3 face = cofactor(triangles.placement(hits[i].object)) *
                      cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (!(dot(face, face) > 0.0f)) continue;
    const vec3 side = normalize(face);
    const vec3 normal = dot(side, primary[i].direction) > 0.0f ? -side : side;
    const vec3 from = primary[i].origin + hits[i].t * primary[i].direction + lift * normal;
    for (const vec3 light : lights) {
      if (dot(light - from, normal) <= 0.0f) continue;
      out.rays[size_t(RayKind::shadow)].push_back({from, 0.0f, light - from, 1.0f});
    }
    for (uint32_t k = 0; k < kAmbientRays; ++k) {
      const float u = uniform(random);
      const float v = uniform(random);
      out.rays[size_t(RayKind::ambient)].push_back({from, 0.0f, around(normal, u, v)});
    }
  }
  out.hit_share = double(met) / double(std::max<size_t>(primary.size(), 1));
  for (std::vector<Ray>& rays : out.rays) thin_out(rays, most);
  return out;
}

void trace(const World& world, RayKind kind, std::span<const Ray> rays, const QueryOptions& options,
           VoxtraceHits& out) {
  if (kind == RayKind::primary) {
    out.closest.resize(rays.size());
    world.closest_hits(rays, out.closest, options);
  } else {
    out.any.resize(rays.size());
    world.any_hits(rays, out.any, options);
  }
}

uint64_t hits_of(RayKind kind, const VoxtraceHits& hits) {
  if (kind != RayKind::primary) {
    return static_cast<uint64_t>(std::ranges::count_if(hits.any, [](uint8_t h) { return h != 0; }));
  }
  return static_cast<uint64_t>(
      std::ranges::count_if(hits.closest, [](const Hit& h) { return h.object != kNoObject; }));
}

}  // namespace sinew::bench
