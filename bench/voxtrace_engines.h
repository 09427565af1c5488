// What `sinew bench voxtrace` sends rays through, and the rays.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "bench/asvo_body.h"
#include "sinew/world/world.h"

namespace sinew::bench {

// The same body three times.
enum class VoxtraceEngine : uint8_t { triangles, animated, anew };
inline constexpr std::array kVoxtraceEngines = {VoxtraceEngine::triangles, VoxtraceEngine::animated,
                                                VoxtraceEngine::anew};
const char* name_of(VoxtraceEngine engine);

class VoxtraceWorlds {
 public:
  // `body` must outlive it.
  static Result<VoxtraceWorlds> open(const AsvoBody& body);

  // Brings one of them to an instant of the first clip, 0..1: a commit, or for `anew` voxels of the
  // same size where the surface is now.
  Result<void> set_pose(VoxtraceEngine engine, double u);
  const World& world(VoxtraceEngine engine) const { return *worlds_[size_t(engine)]; }
  const Svo& anew() const { return *anew_; }

 private:
  explicit VoxtraceWorlds(const AsvoBody& body) : body_(&body) {}
  Result<void> voxelise_anew(double u);

  const AsvoBody* body_;
  std::unique_ptr<Svo> anew_;  // outlives its world
  std::array<std::unique_ptr<World>, 3> worlds_;
};

// Bytes of memory that the process holds.
uint64_t resident_bytes();

enum class RayKind : uint8_t { primary, shadow, ambient };
inline constexpr std::array kRayKinds = {RayKind::primary, RayKind::shadow, RayKind::ambient};
const char* name_of(RayKind kind);

struct VoxtraceRays {
  std::vector<Ray> rays[3];  // by kind
  double hit_share = 0.0;    // of primary rays, by the triangles
};

// One primary ray a pixel. Where they meet triangles one ray to each of two lights, and four into
// the hemisphere (cosine distribution, no limit), which start `lift` above the surface, clear of
// the boxes of its voxels. The same rays for everybody; about `most` of each kind.
VoxtraceRays make_voxtrace_rays(const World& triangles, const CameraView& camera, uint32_t size,
                                float lift, size_t most);

// Closest hits of primary rays, any hits of the others.
struct VoxtraceHits {
  std::vector<Hit> closest;
  std::vector<uint8_t> any;
};
void trace(const World& world, RayKind kind, std::span<const Ray> rays, const QueryOptions& options,
           VoxtraceHits& out);
// Of those traced last, how many met something.
uint64_t hits_of(RayKind kind, const VoxtraceHits& hits);

}  // namespace sinew::bench
