// The ray workload of T (T-SAH 2015, section 6): 1024x768 primary rays, and at every hit 2 shadow
// rays to fixed lights and 8 cosine-distributed ambient occlusion rays without length limit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/ray.h"
#include "sinew/render/camera.h"
#include "sinew/scene/scene.h"

namespace sinew::bench {

// All objects of a scene as one mesh in world space, so that one tree holds everything.
struct FlatScene {
  std::vector<uvec3> triangles;
  std::vector<vec3> positions;  // as of the last flatten()
};

// Sizes `out` on the first call; later calls only move the vertices.
void flatten(const Scene& scene, const ScenePose& pose, FlatScene& out);

struct Workload {
  std::vector<Ray> primary, shadow, ambient;
};

// `hits` belong to `primary` rays; secondary rays start at them.
std::vector<Ray> primary_rays(const CameraView& camera, uint32_t width, uint32_t height);
Workload make_workload(const FlatScene& scene, std::vector<Ray> primary, std::span<const Hit> hits);

}  // namespace sinew::bench
