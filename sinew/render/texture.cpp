#include "sinew/render/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew {
namespace {

using Table = std::array<float, 256>;

const Table& srgb_table() {
  static const Table table = [] {
    Table t{};
    for (size_t i = 0; i < t.size(); ++i) {
      const double s = static_cast<double>(i) / 255.0;
      t[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return t;
  }();
  return table;
}

const Table& linear_table() {
  static const Table table = [] {
    Table t{};
    for (size_t i = 0; i < t.size(); ++i) t[i] = static_cast<float>(i) / 255.0f;
    return t;
  }();
  return table;
}

// Brings a coordinate into one period, [0, 1] or for mirror [0, 2], so that texel indices are at
// most one off. Not finite: 0.
float reduce(float u, Wrap wrap) {
  if (!std::isfinite(u)) return 0.0f;
  if (wrap == Wrap::repeat) return u - std::floor(u);
  if (wrap == Wrap::mirror) return u - 2.0f * std::floor(0.5f * u);
  return std::clamp(u, 0.0f, 1.0f);
}

// The texel that index i in [-1, 2 * size] means.
int wrap_index(int i, int size, Wrap wrap) {
  if (wrap == Wrap::repeat) return i < 0 ? i + size : i >= size ? i - size : i;
  if (wrap == Wrap::mirror) {
    if (i < 0) return 0;
    if (i >= 2 * size) return 0;
    return i >= size ? 2 * size - 1 - i : i;
  }
  return std::clamp(i, 0, size - 1);
}

vec4 fetch(const Image8& image, int x, int y, const Table& colors) {
  const uint8_t* p = image.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
  return vec4(colors[p[0]], colors[p[1]], colors[p[2]], linear_table()[p[3]]);
}

vec4 sample(const Image8& image, const TextureRef& texture, vec2 uv, const Table& colors) {
  uv = transform_texcoord(texture, uv);
  const int w = static_cast<int>(image.width), h = static_cast<int>(image.height);
  float x = reduce(uv.x, texture.wrap_s) * static_cast<float>(w);
  float y = reduce(uv.y, texture.wrap_t) * static_cast<float>(h);
  if (texture.nearest) {
    return fetch(image, wrap_index(static_cast<int>(x), w, texture.wrap_s),
                 wrap_index(static_cast<int>(y), h, texture.wrap_t), colors);
  }
  x -= 0.5f;
  y -= 0.5f;
  const float floor_x = std::floor(x), floor_y = std::floor(y);
  const float fx = x - floor_x, fy = y - floor_y;
  const int x0 = wrap_index(static_cast<int>(floor_x), w, texture.wrap_s);
  const int y0 = wrap_index(static_cast<int>(floor_y), h, texture.wrap_t);
  const int x1 = wrap_index(static_cast<int>(floor_x) + 1, w, texture.wrap_s);
  const int y1 = wrap_index(static_cast<int>(floor_y) + 1, h, texture.wrap_t);
  const vec4 top = mix(fetch(image, x0, y0, colors), fetch(image, x1, y0, colors), fx);
  const vec4 bottom = mix(fetch(image, x0, y1, colors), fetch(image, x1, y1, colors), fx);
  return mix(top, bottom, fy);
}

}  // namespace

float srgb_to_linear(uint8_t code) {
  return srgb_table()[code];
}

vec2 transform_texcoord(const TextureRef& texture, vec2 uv) {
  uv *= texture.scale;
  if (texture.rotation != 0.0f) {
    const float c = std::cos(texture.rotation), s = std::sin(texture.rotation);
    uv = vec2(c * uv.x + s * uv.y, c * uv.y - s * uv.x);
  }
  return uv + texture.offset;
}

vec4 sample_srgb(const Image8& image, const TextureRef& texture, vec2 uv) {
  return sample(image, texture, uv, srgb_table());
}

vec4 sample_linear(const Image8& image, const TextureRef& texture, vec2 uv) {
  return sample(image, texture, uv, linear_table());
}

const Image8* texture_image(std::span<const Image8> images, const TextureRef& texture) {
  if (texture.image < 0 || static_cast<size_t>(texture.image) >= images.size()) return nullptr;
  const Image8& image = images[static_cast<size_t>(texture.image)];
  return image.width > 0 && image.height > 0 ? &image : nullptr;
}

}  // namespace sinew
