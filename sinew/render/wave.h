// A wave: the rays of one depth of a batch of pixels, and what becomes of them. Rays of a pixel
// stand next to each other in every wave, and waves are compacted in order, so a picture's bits do
// not depend on threads.
//
//   fixed chunks of kChunk rays    [ chunk 0 | chunk 1 | chunk 2 ...
//   probes (shadow, ambient)       [ slots of chunk 0, the first count[0] used | chunk 1 ...
//   offspring                      [ 2 slots a ray; packed into the next wave by prefix sums
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/base/parallel.h"
#include "sinew/render/gbuffer.h"

namespace sinew {

inline constexpr size_t kChunk = 512;

enum class RayKind : uint8_t { primary, reflection, refraction };

// Where a ray's light goes, and what the path to it has been through.
struct Path {
  uint32_t pixel = 0;
  uint8_t mirrors = 0;
  uint8_t refractions = 0;  // transmissive surfaces
  uint8_t layers = 0;       // blended surfaces
  RayKind kind = RayKind::primary;
  vec3 throughput{1.0f};
  RayCone cone;

  // Whether the camera sees the ray's end straight.
  bool is_direct() const { return mirrors == 0 && refractions == 0; }
};
static_assert(sizeof(Path) == 28);

struct Wave {
  size_t count = 0;     // of rays; the vectors only grow
  bool camera = false;  // all rays begin at the eye: what the rasteriser draws is not traced
  std::vector<Ray> rays;
  std::vector<Path> paths;
  std::vector<Hit> hits;
  std::vector<Surface> surfaces;
  std::vector<vec3> direct;    // light from lights, reflected
  std::vector<float> ambient;  // unoccluded part of the surroundings
  std::vector<vec4> result;    // what the ray adds to its pixel

  void resize(size_t new_count);
  size_t chunks() const { return (count + kChunk - 1) / kChunk; }
};

// Any-hit rays from the surfaces of a wave, at most one a surface at a time.
struct Probes {
  std::vector<Ray> rays;
  std::vector<uint32_t> owner;  // index in the wave
  std::vector<vec3> light;      // what it brings if nothing is in the way
  std::vector<uint8_t> blocked;
  std::vector<uvec3> optical_depth;  // of what lets light through on the way; R, G, B
  std::vector<uint32_t> count;       // a chunk

  void resize(const Wave& wave);
  void push(size_t chunk, const Ray& ray, uint32_t surface, vec3 contribution);
  // Of the probes in the first `slots` slots.
  uint64_t total(size_t slots) const;
};

// The next wave's rays while they are being made.
struct Offspring {
  std::vector<Ray> rays;
  std::vector<Path> paths;
  std::vector<uint32_t> count;  // a chunk
  std::vector<uint32_t> first;  // a chunk: where its rays go

  void resize(const Wave& wave);
  void push(size_t chunk, const Ray& ray, const Path& path);
  // Replaces the wave's rays and paths by the offspring, in order.
  void become(Wave& wave);
};

// Calls body(chunk, begin, end) for every chunk of the wave's rays, in parallel.
template <class Body>
void for_chunks(const Wave& wave, const Body& body) {
  parallel_for(wave.count, kChunk,
               [&](size_t begin, size_t end) { body(begin / kChunk, begin, end); });
}

// A start for rays that leave the surface on the side of the viewer, or on the other one.
inline vec3 leave_before(const Surface& surface, vec3 point) {
  return point + surface.geometric_normal * surface.footprint;
}
inline vec3 leave_behind(const Surface& surface, vec3 point) {
  return point - surface.geometric_normal * surface.footprint;
}

}  // namespace sinew
