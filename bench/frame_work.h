// What is asked of an engine in a frame: an image's primary and shadow rays, or picks.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/engines.h"
#include "sinew/math/box.h"
#include "sinew/render/camera.h"

namespace sinew::bench {

// Primary rays, and at every hit one shadow ray to a distant light.
struct Picture {
  std::vector<Ray> primary;
  vec3 to_light{0.0f, 1.0f, 0.0f};
};

// What came back, so that engines can be seen to do the same.
struct PictureCounts {
  uint64_t hits = 0;
  uint64_t lit = 0;
};

PictureCounts trace_picture(const Engine& engine, const Picture& picture);

// Embree's fastest calls for the picture, closest hits and any hits, found by trying all of them on
// one of its engines. Its pose must be set. Returns their names.
std::string choose_embree_calls(Arena& arena, const Engine& embree, const Picture& picture);

// Rays from around the scene towards random points in the boxes of its objects: one pick each.
void pick_rays(std::span<const Box> boxes, uint32_t seed, std::span<Ray> out);
// World boxes of the objects that deform, or of all if none does.
std::vector<Box> object_boxes(const Scene& scene, const ScenePose& pose);

}  // namespace sinew::bench
