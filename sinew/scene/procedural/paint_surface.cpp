// Painting a texture texel by texel from the surface it covers.
#include <algorithm>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/noise.h"
#include "sinew/scene/procedural/unwrap.h"

namespace sinew {
namespace {

constexpr uint32_t kUncovered = 0xffffffffu;
constexpr int kBleed = 4;  // texels by which colours run over the edges of charts

float cross2(vec2 a, vec2 b) {
  return a.x * b.y - a.y * b.x;
}

struct TexelTriangle {
  vec2 corner[3];  // in texels

  vec3 barycentric(vec2 p) const {
    const float area = cross2(corner[1] - corner[0], corner[2] - corner[0]);
    const float b1 = cross2(p - corner[0], corner[2] - corner[0]) / area;
    const float b2 = cross2(corner[1] - corner[0], p - corner[0]) / area;
    return vec3(1.0f - b1 - b2, b1, b2);
  }
};

TexelTriangle texel_triangle(const Unwrapping& unwrapping, uint32_t t, uint32_t resolution) {
  TexelTriangle result;
  for (int k = 0; k < 3; ++k) {
    result.corner[k] =
        unwrapping.texcoords[unwrapping.corners[t][k]] * static_cast<float>(resolution);
  }
  return result;
}

// The triangle that covers the middle of each texel.
std::vector<uint32_t> cover(const Unwrapping& unwrapping, uint32_t resolution) {
  std::vector<uint32_t> covering(size_t{resolution} * resolution, kUncovered);
  const int last = static_cast<int>(resolution) - 1;
  for (uint32_t t = 0; t < unwrapping.corners.size(); ++t) {
    const TexelTriangle triangle = texel_triangle(unwrapping, t, resolution);
    const vec2 low = glm::min(triangle.corner[0], glm::min(triangle.corner[1], triangle.corner[2]));
    const vec2 high =
        glm::max(triangle.corner[0], glm::max(triangle.corner[1], triangle.corner[2]));
    const int x0 = std::max(0, static_cast<int>(low.x - 0.5f));
    const int y0 = std::max(0, static_cast<int>(low.y - 0.5f));
    const int x1 = std::min(last, static_cast<int>(high.x + 0.5f));
    const int y1 = std::min(last, static_cast<int>(high.y + 0.5f));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const vec3 b =
            triangle.barycentric({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        if (!(std::min({b.x, b.y, b.z}) >= 0.0f)) continue;  // also skips triangles without area
        covering[static_cast<size_t>(y) * resolution + static_cast<size_t>(x)] = t;
      }
    }
  }
  return covering;
}

SurfacePoint surface_point(const Unwrapping& unwrapping, std::span<const vec3> positions,
                           uvec3 triangle, uint32_t t, vec2 texel, uint32_t resolution) {
  const TexelTriangle flat = texel_triangle(unwrapping, t, resolution);
  SurfacePoint point;
  point.triangle = t;
  point.barycentric = flat.barycentric(texel);
  const vec2 d1 = flat.corner[1] - flat.corner[0], d2 = flat.corner[2] - flat.corner[0];
  const vec3 e1 = positions[triangle.y] - positions[triangle.x];
  const vec3 e2 = positions[triangle.z] - positions[triangle.x];
  const float sign = cross2(d1, d2) < 0.0f ? -1.0f : 1.0f;
  point.tangent = normalize(sign * (d2.y * e1 - d1.y * e2));
  point.bitangent = -normalize(sign * (d1.x * e2 - d2.x * e1));
  return point;
}

// Gives the texel the mean of its covered neighbours; false if there are none.
bool fill_texel(Image8& image, const std::vector<uint8_t>& covered, int x, int y) {
  const int n = static_cast<int>(image.width);
  int sum[3] = {0, 0, 0}, count = 0;
  for (int ny = std::max(0, y - 1); ny <= std::min(n - 1, y + 1); ++ny) {
    for (int nx = std::max(0, x - 1); nx <= std::min(n - 1, x + 1); ++nx) {
      if (!covered[static_cast<size_t>(ny * n + nx)]) continue;
      const uint8_t* p = image.at(static_cast<uint32_t>(nx), static_cast<uint32_t>(ny));
      for (int c = 0; c < 3; ++c) sum[c] += p[c];
      ++count;
    }
  }
  if (count == 0) return false;
  uint8_t* p = image.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
  for (int c = 0; c < 3; ++c) p[c] = static_cast<uint8_t>((sum[c] + count / 2) / count);
  return true;
}

// Fills texels next to covered ones, `kBleed` times.
void bleed(PaintedTextures& textures, std::vector<uint8_t> covered) {
  const int n = static_cast<int>(textures.color.width);
  for (int pass = 0; pass < kBleed; ++pass) {
    const std::vector<uint8_t> before = covered;
    parallel_for(static_cast<size_t>(n), 16, [&](size_t begin, size_t end) {
      for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
        for (int x = 0; x < n; ++x) {
          if (before[static_cast<size_t>(y * n + x)]) continue;
          if (!fill_texel(textures.color, before, x, y)) continue;
          fill_texel(textures.normal, before, x, y);
          covered[static_cast<size_t>(y * n + x)] = 1;
        }
      }
    });
  }
}

Image8 blank(uint32_t resolution, uint8_t r, uint8_t g, uint8_t b) {
  Image8 image{resolution, resolution, {}};
  image.pixels.resize(size_t{4} * resolution * resolution);
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    image.pixels[i] = r;
    image.pixels[i + 1] = g;
    image.pixels[i + 2] = b;
    image.pixels[i + 3] = 255;
  }
  return image;
}

}  // namespace

PaintedTextures paint_surface(const Unwrapping& unwrapping, std::span<const vec3> positions,
                              std::span<const uvec3> triangles, uint32_t resolution,
                              const std::function<Paint(const SurfacePoint&)>& paint) {
  const std::vector<uint32_t> covering = cover(unwrapping, resolution);
  PaintedTextures textures{blank(resolution, 128, 128, 128), blank(resolution, 128, 128, 255)};
  std::vector<uint8_t> covered(covering.size());
  parallel_for(resolution, 16, [&](size_t begin, size_t end) {
    for (uint32_t y = static_cast<uint32_t>(begin); y < end; ++y) {
      for (uint32_t x = 0; x < resolution; ++x) {
        const uint32_t t = covering[size_t{y} * resolution + x];
        if (t == kUncovered) continue;
        covered[size_t{y} * resolution + x] = 1;
        const vec2 texel(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        const Paint result =
            paint(surface_point(unwrapping, positions, triangles[t], t, texel, resolution));
        store_srgb(result.color, textures.color.at(x, y));
        const vec3 n = glm::clamp(127.5f * normalize(result.normal) + 127.5f, 0.0f, 255.0f);
        for (int c = 0; c < 3; ++c) {
          textures.normal.at(x, y)[c] = static_cast<uint8_t>(n[c] + 0.5f);
        }
      }
    }
  });
  bleed(textures, std::move(covered));
  return textures;
}

}  // namespace sinew
