#include "sinew/render/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/srgb.h"

namespace sinew {
namespace {

using Table = std::array<float, 256>;

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

// `uv` is where the texture is read, transformed already.
vec4 sample(const Image8& image, const TextureRef& texture, vec2 uv, const Table& colors) {
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

// The linear part of transform_texcoord.
vec2 transform_direction(const TextureRef& texture, vec2 uv) {
  uv *= texture.scale;
  if (texture.rotation == 0.0f) return uv;
  const float c = std::cos(texture.rotation), s = std::sin(texture.rotation);
  return vec2(c * uv.x + s * uv.y, c * uv.y - s * uv.x);
}

// Between the two levels whose texels are next in size to 2^lod texels of the image.
vec4 sample_between(const MipMap& map, const TextureRef& texture, vec2 uv, float lod,
                    const Table& colors) {
  const float inside = std::clamp(lod, 0.0f, static_cast<float>(map.smaller.size()));
  const auto low = static_cast<size_t>(inside);
  const float fraction = inside - static_cast<float>(low);
  const vec4 fine = sample(map.level(low), texture, uv, colors);
  if (!(fraction > 0.0f)) return fine;
  return mix(fine, sample(map.level(low + 1), texture, uv, colors), fraction);
}

vec4 sample(const MipMap& map, const TextureRef& texture, const TexturePoint& point,
            const Table& colors) {
  constexpr float kMostReads = 8.0f;
  const vec2 uv = transform_texcoord(texture, point.uv);
  const vec2 size(map.image->width, map.image->height);  // texels
  const vec2 major = transform_direction(texture, point.major);
  const float longer = 2.0f * length(major * size);
  const float shorter = 2.0f * length(transform_direction(texture, point.minor) * size);
  if (!(longer > 1.0f) || !std::isfinite(longer)) return sample(*map.image, texture, uv, colors);
  const float reads = std::clamp(std::ceil(longer / std::max(shorter, 1.0f)), 1.0f, kMostReads);
  const float lod = std::log2(std::max(longer / reads, shorter));
  vec4 sum(0.0f);
  for (float i = 0.0f; i < reads; i += 1.0f) {
    const vec2 at = uv + major * ((2.0f * i + 1.0f) / reads - 1.0f);
    sum += sample_between(map, texture, at, lod, colors);
  }
  return sum / reads;
}

// A texel of a smaller level is the mean over [begin, end) of the larger one's.
struct Share {
  float begin, end;
};

Image8 halve(const Image8& image, const Table& colors, bool srgb) {
  Image8 out;
  out.width = std::max(image.width / 2, 1u);
  out.height = std::max(image.height / 2, 1u);
  out.pixels.resize(size_t{4} * out.width * out.height);
  const auto share_of = [](uint32_t i, uint32_t from, uint32_t to) {
    const float step = static_cast<float>(from) / static_cast<float>(to);
    return Share{static_cast<float>(i) * step, static_cast<float>(i + 1) * step};
  };
  const auto weight = [](const Share& share, uint32_t i) {
    const float low = static_cast<float>(i);
    return std::min(share.end, low + 1.0f) - std::max(share.begin, low);
  };
  const auto texels_end = [](const Share& share, uint32_t size) {
    return std::min(static_cast<uint32_t>(std::ceil(share.end)), size);
  };
  parallel_for(out.height, 16, [&](size_t row_begin, size_t row_end) {
    for (size_t y = row_begin; y < row_end; ++y) {
      const Share rows = share_of(static_cast<uint32_t>(y), image.height, out.height);
      for (uint32_t x = 0; x < out.width; ++x) {
        const Share columns = share_of(x, image.width, out.width);
        vec4 plain(0.0f);
        vec3 weighted(0.0f);  // by alpha
        float total = 0.0f;
        for (auto j = static_cast<uint32_t>(rows.begin); j < texels_end(rows, image.height); ++j) {
          for (auto i = static_cast<uint32_t>(columns.begin); i < texels_end(columns, image.width);
               ++i) {
            const float w = weight(rows, j) * weight(columns, i);
            const vec4 texel = fetch(image, static_cast<int>(i), static_cast<int>(j), colors);
            plain += w * texel;
            weighted += w * texel.w * vec3(texel);
            total += w;
          }
        }
        const vec3 color = srgb && plain.w > 0.0f ? weighted / plain.w : vec3(plain) / total;
        uint8_t* to = out.at(x, static_cast<uint32_t>(y));
        for (int c = 0; c < 3; ++c) {
          to[c] =
              srgb ? linear_to_srgb_code(color[c]) : static_cast<uint8_t>(color[c] * 255.0f + 0.5f);
        }
        to[3] = static_cast<uint8_t>(plain.w / total * 255.0f + 0.5f);
      }
    }
  });
  return out;
}

}  // namespace

MipMap make_mip_map(const Image8& image, bool srgb) {
  MipMap map{&image, {}};
  const Image8* last = &image;
  map.smaller.reserve(16);  // so that `last` stays where it is
  while (last->width > 1 || last->height > 1) {
    map.smaller.push_back(halve(*last, srgb ? srgb_codes_to_linear() : linear_table(), srgb));
    last = &map.smaller.back();
  }
  return map;
}

void TextureTable::build(const Scene& scene) {
  colors_.clear();
  data_.clear();
  colors_.resize(scene.images.size());
  data_.resize(scene.images.size());
  const auto use = [&](std::vector<MipMap>& maps, const TextureRef& texture, bool srgb) {
    const Image8* image = texture_image(scene.images, texture);
    if (image == nullptr) return;
    MipMap& map = maps[static_cast<size_t>(texture.image)];
    if (map.image == nullptr) map = make_mip_map(*image, srgb);
  };
  for (const Material& material : scene.materials) {
    use(colors_, material.base_color_texture, true);
    use(colors_, material.emissive_texture, true);
    use(data_, material.metallic_roughness_texture, false);
    use(data_, material.normal_texture, false);
    use(data_, material.occlusion_texture, false);
    use(data_, material.transmission_texture, false);
  }
}

const MipMap* TextureTable::find(std::span<const MipMap> maps, const TextureRef& texture) {
  if (texture.image < 0 || static_cast<size_t>(texture.image) >= maps.size()) return nullptr;
  const MipMap& map = maps[static_cast<size_t>(texture.image)];
  return map.image != nullptr ? &map : nullptr;
}

vec2 transform_texcoord(const TextureRef& texture, vec2 uv) {
  return transform_direction(texture, uv) + texture.offset;
}

vec4 sample_srgb(const Image8& image, const TextureRef& texture, vec2 uv) {
  return sample(image, texture, transform_texcoord(texture, uv), srgb_codes_to_linear());
}

vec4 sample_srgb(const MipMap& map, const TextureRef& texture, const TexturePoint& point) {
  return sample(map, texture, point, srgb_codes_to_linear());
}

vec4 sample_linear(const MipMap& map, const TextureRef& texture, const TexturePoint& point) {
  return sample(map, texture, point, linear_table());
}

const Image8* texture_image(std::span<const Image8> images, const TextureRef& texture) {
  if (texture.image < 0 || static_cast<size_t>(texture.image) >= images.size()) return nullptr;
  const Image8& image = images[static_cast<size_t>(texture.image)];
  return image.width > 0 && image.height > 0 ? &image : nullptr;
}

}  // namespace sinew
