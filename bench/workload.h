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

// One ray a pixel, in tiles of 32x32 pixels and in Morton order within them, so that 16 rays in a
// row are a block of 4x4 pixels: what packets and streams want.
std::vector<Ray> primary_rays(const CameraView& camera, uint32_t width, uint32_t height);

// `hits` belong to `primary` rays; secondary rays start at them.
Workload make_workload(const FlatScene& scene, std::vector<Ray> primary, std::span<const Hit> hits);

// Keeps about `most` of the rays: runs of 1024, evenly spread, so that they stay as coherent as
// they were.
void thin_out(std::vector<Ray>& rays, size_t most);

}  // namespace sinew::bench
