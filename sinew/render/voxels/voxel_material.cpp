#include "sinew/render/voxels/voxel_material.h"

#include <algorithm>
#include <cmath>

#include "sinew/render/shade.h"

namespace sinew {
namespace {

constexpr float kLeastCosine = 1e-3f;  // of the shading normal to the viewer

// The mean of a texture, RGBA.
vec4 mean_of(const MipMap* map, const TextureRef& texture, bool srgb) {
  if (map == nullptr) return vec4(1.0f);
  const Image8& texel = map->level(map->smaller.size());
  TextureRef plain;
  plain.image = texture.image;
  plain.nearest = true;
  if (srgb) return sample_srgb(texel, plain, vec2(0.5f));
  const uint8_t* const at = texel.at(texel.width / 2, texel.height / 2);
  return vec4(at[0], at[1], at[2], at[3]) / 255.0f;
}

}  // namespace

void fold_textures(const TextureTable& textures, Material& material) {
  const auto data = [&](const TextureRef& texture) {
    return mean_of(textures.data(texture), texture, false);
  };
  const vec4 surface = data(material.metallic_roughness_texture);
  material.metallic = std::clamp(material.metallic * surface.z, 0.0f, 1.0f);
  material.roughness = std::clamp(material.roughness * surface.y, 0.0f, 1.0f);
  const TextureRef& emissive = material.emissive_texture;
  material.emissive *= vec3(mean_of(textures.colors(emissive), emissive, true));
  material.transmission *= data(material.transmission_texture).x;
  for (TextureRef* texture : {&material.base_color_texture, &material.metallic_roughness_texture,
                              &material.normal_texture, &material.occlusion_texture,
                              &material.emissive_texture, &material.transmission_texture}) {
    *texture = {};
  }
}

void list_voxel_materials(const Scene& scene, const TextureTable& textures,
                          std::vector<VoxelMaterial>& out) {
  out.clear();
  for (Material material : scene.materials) {
    const TextureRef& texture = material.occlusion_texture;
    const float occlusion = mean_of(textures.data(texture), texture, false).x;
    const float occluded = material.occlusion_strength * (1.0f - occlusion);
    fold_textures(textures, material);
    VoxelMaterial m;
    m.dielectric = dielectric_reflectance(material);
    m.specular = material.specular;
    m.emission = material.emissive;
    m.metallic = material.metallic;
    m.roughness = material.roughness;
    m.occlusion = 1.0f - occluded;
    m.unlit = material.unlit ? 1.0f : 0.0f;
    out.push_back(m);
  }
}

float widened_roughness(float roughness, float spread) {
  if (spread >= 1.0f) return roughness;
  const float exponent = phong_exponent(roughness);
  const float share = spread / (spread + exponent * (1.0f - spread));
  return std::sqrt(std::sqrt(2.0f / (2.0f + share * exponent)));
}

void resolve_voxel(const VoxelSample& voxel, float diagonal, const VoxelMaterial& material,
                   vec3 view, Surface& out) {
  out = {};
  float cosine = dot(voxel.normal, view);
  const float side = cosine < kFromBehind ? -1.0f : 1.0f;
  cosine *= side;
  vec3 normal = side * voxel.normal;
  if (cosine < kLeastCosine) {
    normal = normalize(normal + (std::max(-cosine, kProfile) - cosine) * view);
  }
  out.position = out.lifted = voxel.position;
  out.normal = normal;
  out.geometric_normal = normal;
  out.from_behind = side < 0.0f;
  out.voxel = diagonal;
  out.footprint = voxel.clearance > 0.0f ? voxel.clearance : diagonal;
  out.unlit = material.unlit > 0.0f;
  if (out.unlit) {
    out.emission = voxel.color;
    return;
  }
  out.albedo = voxel.color * (1.0f - material.metallic);
  out.specular = mix(material.dielectric, voxel.color, material.metallic);
  out.grazing = 1.0f - (1.0f - material.specular) * (1.0f - material.metallic);
  out.roughness = widened_roughness(material.roughness, voxel.spread);
  out.emission = material.emission;
  out.occlusion = material.occlusion;
}

}  // namespace sinew
