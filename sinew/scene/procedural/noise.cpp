#include "sinew/scene/procedural/noise.h"

#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/random.h"
#include "sinew/math/srgb.h"

namespace sinew {
namespace {

uint32_t lattice_hash(int x, int y, int z, uint32_t seed) {
  return hash_u32(static_cast<uint32_t>(x) * 0x9e3779b1u ^ static_cast<uint32_t>(y) * 0x85ebca77u ^
                  static_cast<uint32_t>(z) * 0xc2b2ae3du ^ seed);
}

// Dot product with one of the twelve edge directions of a cube.
float edge_gradient(uint32_t hash, float x, float y, float z) {
  const uint32_t h = hash >> 28;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : (h == 12 || h == 14 ? x : z);
  return ((h & 1) ? -u : u) + ((h & 2) ? -v : v);
}

float fade(float t) {
  return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

}  // namespace

float gradient_noise(vec3 p, uint32_t seed) {
  const vec3 base = glm::floor(p);
  const vec3 f = p - base;
  const int x = static_cast<int>(base.x), y = static_cast<int>(base.y),
            z = static_cast<int>(base.z);
  float corner[8];
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1, dy = (i >> 1) & 1, dz = i >> 2;
    corner[i] =
        edge_gradient(lattice_hash(x + dx, y + dy, z + dz, seed), f.x - static_cast<float>(dx),
                      f.y - static_cast<float>(dy), f.z - static_cast<float>(dz));
  }
  const float u = fade(f.x), v = fade(f.y), w = fade(f.z);
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const float low = mix(mix(corner[0], corner[1], u), mix(corner[2], corner[3], u), v);
  const float high = mix(mix(corner[4], corner[5], u), mix(corner[6], corner[7], u), v);
  return mix(low, high, w);
}

float fractal_noise(vec3 p, uint32_t octaves, uint32_t seed) {
  float sum = 0.0f, height = 0.5f;
  for (uint32_t i = 0; i < octaves; ++i) {
    sum += height * gradient_noise(p, seed + i);
    p = 2.0f * p + vec3(17.3f, 5.1f, 9.7f);
    height *= 0.5f;
  }
  return sum;
}

Cells cellular_noise(vec3 p, float jitter, uint32_t seed) {
  const vec3 base = glm::floor(p);
  const int x = static_cast<int>(base.x), y = static_cast<int>(base.y),
            z = static_cast<int>(base.z);
  Cells cells;
  float nearest = 1e30f, second = 1e30f;  // squared
  for (int i = 0; i < 27; ++i) {
    const int cx = x + i % 3 - 1, cy = y + i / 3 % 3 - 1, cz = z + i / 9 - 1;
    const uint32_t h = lattice_hash(cx, cy, cz, seed);
    const vec3 stray = vec3(static_cast<float>(h & 1023u), static_cast<float>((h >> 10) & 1023u),
                            static_cast<float>((h >> 20) & 1023u)) /
                           1023.0f -
                       0.5f;
    const vec3 to = vec3(cx, cy, cz) + 0.5f + jitter * stray - p;
    const float d = dot(to, to);
    if (d < nearest) {
      second = nearest;
      cells.to_second = cells.to_nearest;
      nearest = d;
      cells.to_nearest = to;
      cells.id = h;
    } else if (d < second) {
      second = d;
      cells.to_second = to;
    }
  }
  cells.nearest = std::sqrt(nearest);
  cells.second = std::sqrt(second);
  return cells;
}

void store_srgb(vec3 linear, uint8_t* rgba) {
  for (int c = 0; c < 3; ++c) {
    rgba[c] = linear_to_srgb_code(linear[c]);
  }
  rgba[3] = 255;
}

Image8 paint_image(uint32_t width, uint32_t height,
                   const std::function<vec3(float u, float v)>& color) {
  Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
  parallel_for(height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (uint32_t x = 0; x < width; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
        const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
        store_srgb(color(u, v), image.at(x, static_cast<uint32_t>(y)));
      }
    }
  });
  return image;
}

}  // namespace sinew
