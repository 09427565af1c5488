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

#include "sinew/render/gbuffer.h"

namespace sinew {

inline constexpr size_t kChunk = 512;

// Where a ray's light goes.
struct Path {
  uint32_t pixel = 0;
  uint16_t bounce = 0;  // mirror reflections so far
  uint16_t layer = 0;   // blended surfaces passed so far
  vec3 throughput{1.0f};
};
static_assert(sizeof(Path) == 20);

struct Wave {
  size_t count = 0;  // of rays; the vectors only grow
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
  std::vector<uint32_t> optical_depth;  // of blends on the way
  std::vector<uint32_t> count;          // a chunk

  void resize(const Wave& wave);
  void push(size_t chunk, const Ray& ray, uint32_t surface, vec3 contribution);
  uint64_t total(const Wave& wave) const;
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

}  // namespace sinew
