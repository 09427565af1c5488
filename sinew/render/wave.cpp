#include "sinew/render/wave.h"

#include <algorithm>
#include <numeric>

#include "sinew/base/parallel.h"

namespace sinew {
namespace {

template <class... Vectors>
void grow(size_t size, Vectors&... vectors) {
  ((vectors.size() < size ? vectors.resize(size) : void()), ...);
}

}  // namespace

void Wave::resize(size_t new_count) {
  count = new_count;
  grow(count, rays, paths, hits, surfaces, direct, ambient, result);
}

void Probes::resize(const Wave& wave) {
  grow(wave.chunks() * kChunk, rays, owner, light, blocked, optical_depth);
  grow(wave.chunks(), count);
  std::fill_n(count.begin(), wave.chunks(), 0u);
}

void Probes::push(size_t chunk, const Ray& ray, uint32_t surface, vec3 contribution) {
  const size_t slot = chunk * kChunk + count[chunk]++;
  rays[slot] = ray;
  owner[slot] = surface;
  light[slot] = contribution;
  optical_depth[slot] = uvec3(0u);
}

uint64_t Probes::total(size_t slots) const {
  const size_t chunks = (slots + kChunk - 1) / kChunk;
  return std::accumulate(count.begin(), count.begin() + static_cast<ptrdiff_t>(chunks),
                         uint64_t{0});
}

void Offspring::resize(const Wave& wave) {
  grow(2 * wave.chunks() * kChunk, rays, paths);
  grow(wave.chunks(), count, first);
  std::fill_n(count.begin(), wave.chunks(), 0u);
}

void Offspring::push(size_t chunk, const Ray& ray, const Path& path) {
  const size_t slot = 2 * chunk * kChunk + count[chunk]++;
  rays[slot] = ray;
  paths[slot] = path;
}

void Offspring::become(Wave& wave) {
  const size_t chunks = wave.chunks();
  std::exclusive_scan(count.begin(), count.begin() + static_cast<ptrdiff_t>(chunks), first.begin(),
                      0u);
  wave.camera = false;
  wave.resize(chunks > 0 ? size_t{first[chunks - 1]} + count[chunks - 1] : 0);
  parallel_for(chunks, 8, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      std::copy_n(rays.begin() + static_cast<ptrdiff_t>(2 * c * kChunk), count[c],
                  wave.rays.begin() + first[c]);
      std::copy_n(paths.begin() + static_cast<ptrdiff_t>(2 * c * kChunk), count[c],
                  wave.paths.begin() + first[c]);
    }
  });
}

}  // namespace sinew
