#include "sinew/io/gltf/specular.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/parallel.h"
#include "sinew/math/srgb.h"

namespace sinew::gltf {
namespace {

constexpr float kDielectric = 0.04f;  // what non-metals reflect head-on

struct MetallicRoughness {
  vec3 base_color{1.0f};
  float metallic = 0.0f;
  float roughness = 1.0f;
};

float brightness(vec3 c) {
  return std::sqrt(0.299f * c.x * c.x + 0.587f * c.y * c.y + 0.114f * c.z * c.z);
}

// The metalness m at which a metallic-roughness surface has these brightnesses: a quadratic in m.
float solve_metallic(float diffuse, float specular, float not_reflected) {
  if (specular < kDielectric) return 0.0f;
  const float a = kDielectric;
  const float b = diffuse * not_reflected / (1.0f - kDielectric) + specular - 2.0f * kDielectric;
  const float c = kDielectric - specular;
  const float discriminant = std::max(b * b - 4.0f * a * c, 0.0f);
  return std::clamp((-b + std::sqrt(discriminant)) / (2.0f * a), 0.0f, 1.0f);
}

MetallicRoughness convert_values(vec3 diffuse, vec3 specular, float glossiness) {
  constexpr float kTiny = 1e-6f;
  const float not_reflected = 1.0f - std::max({specular.x, specular.y, specular.z});
  MetallicRoughness result;
  const float m = solve_metallic(brightness(diffuse), brightness(specular), not_reflected);
  const vec3 from_diffuse =
      diffuse * (not_reflected / (1.0f - kDielectric) / std::max(1.0f - m, kTiny));
  const vec3 from_specular = (specular - kDielectric * (1.0f - m)) / std::max(m, kTiny);
  result.base_color = glm::clamp(glm::mix(from_diffuse, from_specular, m * m), 0.0f, 1.0f);
  result.metallic = m;
  result.roughness = std::clamp(1.0f - glossiness, 0.0f, 1.0f);
  return result;
}

uint8_t to_byte(float x) {
  return static_cast<uint8_t>(std::lround(x * 255.0f));
}

const Image8* image_of(const TextureRef& texture, const std::vector<Image8>& images) {
  return texture.image < 0 ? nullptr : &images[static_cast<size_t>(texture.image)];
}

// The nearest texel of `image` to pixel (x, y) of a raster of the given size; white if no image.
std::array<uint8_t, 4> texel(const Image8* image, uint32_t x, uint32_t y, uint32_t width,
                             uint32_t height) {
  if (!image) return {255, 255, 255, 255};
  const uint8_t* p = image->at(static_cast<uint32_t>(uint64_t{x} * image->width / width),
                               static_cast<uint32_t>(uint64_t{y} * image->height / height));
  return {p[0], p[1], p[2], p[3]};
}

void convert_images(const SpecularGlossiness& surface, const Image8* diffuse,
                    const Image8* specular, Image8& base, Image8& metallic_roughness) {
  const std::array<float, 256>& linear = srgb_codes_to_linear();
  const auto color = [&](const std::array<uint8_t, 4>& p) {
    return vec3(linear[p[0]], linear[p[1]], linear[p[2]]);
  };
  parallel_for(base.height, 16, [&](size_t begin, size_t end) {
    for (uint32_t y = static_cast<uint32_t>(begin); y < end; ++y) {
      for (uint32_t x = 0; x < base.width; ++x) {
        const auto d = texel(diffuse, x, y, base.width, base.height);
        const auto s = texel(specular, x, y, base.width, base.height);
        const MetallicRoughness mr =
            convert_values(vec3(surface.diffuse) * color(d), surface.specular * color(s),
                           surface.glossiness * float(s[3]) / 255.0f);
        uint8_t* b = base.at(x, y);
        for (int k = 0; k < 3; ++k) b[k] = linear_to_srgb_code(mr.base_color[k]);
        b[3] = d[3];
        uint8_t* m = metallic_roughness.at(x, y);
        m[0] = 255;
        m[1] = to_byte(mr.roughness);
        m[2] = to_byte(mr.metallic);
        m[3] = 255;
      }
    }
  });
}

}  // namespace

uint64_t converted_pixels(const SpecularGlossiness& surface, const std::vector<Image8>& images) {
  const Image8* raster = image_of(surface.diffuse_texture, images);
  if (!raster) raster = image_of(surface.specular_texture, images);
  return raster ? uint64_t{raster->width} * raster->height : 0;
}

void convert(const SpecularGlossiness& surface, Material& out, std::vector<Image8>& images) {
  const Image8* diffuse = image_of(surface.diffuse_texture, images);
  const Image8* specular = image_of(surface.specular_texture, images);
  if (!diffuse && !specular) {
    const MetallicRoughness mr =
        convert_values(vec3(surface.diffuse), surface.specular, surface.glossiness);
    out.base_color = vec4(mr.base_color, surface.diffuse.a);
    out.metallic = mr.metallic;
    out.roughness = mr.roughness;
    return;
  }
  const Image8* raster = diffuse ? diffuse : specular;
  Image8 base{raster->width, raster->height, {}};
  base.pixels.resize(raster->pixels.size());
  Image8 metallic_roughness = base;
  convert_images(surface, diffuse, specular, base, metallic_roughness);

  out.base_color = vec4(1.0f, 1.0f, 1.0f, surface.diffuse.a);
  out.metallic = 1.0f;
  out.roughness = 1.0f;
  out.base_color_texture = diffuse ? surface.diffuse_texture : surface.specular_texture;
  out.metallic_roughness_texture = out.base_color_texture;
  out.base_color_texture.image = static_cast<int32_t>(images.size());
  out.metallic_roughness_texture.image = static_cast<int32_t>(images.size() + 1);
  images.push_back(std::move(base));
  images.push_back(std::move(metallic_roughness));
}

}  // namespace sinew::gltf
