#include "sinew/io/gltf/material.h"

#include <glm/common.hpp>

#include "sinew/io/gltf/specular.h"
#include "sinew/io/gltf/texture.h"

namespace sinew::gltf {
namespace {

// A specular-glossiness material waits here until its images are decoded.
struct Pending {
  uint32_t material;
  SpecularGlossiness surface;
};

Result<void> read_metallic_roughness(const Json& json, TextureReader& textures, Material& out) {
  SINEW_TRY(const Json surface, json.object("pbrMetallicRoughness"));
  SINEW_CHECKED(surface.numbers("baseColorFactor", {&out.base_color.x, 4}));
  SINEW_TRY(out.base_color_texture, textures.read(surface, "baseColorTexture"));
  SINEW_TRY(out.metallic, surface.number("metallicFactor", out.metallic));
  SINEW_TRY(out.roughness, surface.number("roughnessFactor", out.roughness));
  SINEW_TRY(out.metallic_roughness_texture, textures.read(surface, "metallicRoughnessTexture"));
  return {};
}

Result<void> read_detail_textures(const Json& json, TextureReader& textures, Material& out) {
  SINEW_TRY(out.normal_texture, textures.read(json, "normalTexture"));
  SINEW_TRY(const Json normal, json.object("normalTexture"));
  SINEW_TRY(out.normal_scale, normal.number("scale", 1.0f));
  SINEW_TRY(out.occlusion_texture, textures.read(json, "occlusionTexture"));
  SINEW_TRY(const Json occlusion, json.object("occlusionTexture"));
  SINEW_TRY(out.occlusion_strength, occlusion.number("strength", 1.0f));
  SINEW_CHECKED(json.numbers("emissiveFactor", {&out.emissive.x, 3}));
  SINEW_TRY(out.emissive_texture, textures.read(json, "emissiveTexture"));
  return {};
}

Result<void> read_alpha(const Json& json, Material& out) {
  SINEW_TRY(const std::string mode, json.text("alphaMode", "OPAQUE"));
  SINEW_TRY(out.alpha_cutoff, json.number("alphaCutoff", 0.5f));
  if (mode == "MASK") {
    out.alpha_mode = AlphaMode::mask;
  } else if (mode == "BLEND") {
    out.alpha_mode = AlphaMode::blend;
  } else if (mode != "OPAQUE") {
    return json.error("\"alphaMode\" is \"" + mode + "\", not OPAQUE, MASK or BLEND");
  }
  return {};
}

Result<void> read_reflectance(const Reader& reader, const Json& extensions, Material& out) {
  constexpr float kMirror = 999.0f;  // an index of 0 stands for one without end
  SINEW_TRY(const Json refraction, extensions.object("KHR_materials_ior"));
  SINEW_TRY(out.ior, refraction.number("ior", out.ior));
  out.ior = out.ior == 0.0f ? kMirror : glm::clamp(out.ior, 1.0f, kMirror);
  SINEW_TRY(const Json specular, extensions.object("KHR_materials_specular"));
  SINEW_TRY(out.specular, specular.number("specularFactor", out.specular));
  SINEW_CHECKED(specular.numbers("specularColorFactor", {&out.specular_color.x, 3}));
  if (specular.has("specularTexture") || specular.has("specularColorTexture")) {
    reader.warnings.add(specular.element(), "textures of KHR_materials_specular are ignored");
  }
  return {};
}

Result<void> read_transmission(const Json& extensions, TextureReader& textures, Material& out) {
  SINEW_TRY(const Json transmission, extensions.object("KHR_materials_transmission"));
  SINEW_TRY(out.transmission, transmission.number("transmissionFactor", out.transmission));
  SINEW_TRY(out.transmission_texture, textures.read(transmission, "transmissionTexture"));
  SINEW_TRY(const Json volume, extensions.object("KHR_materials_volume"));
  SINEW_TRY(const float thickness, volume.number("thicknessFactor", 0.0f));
  out.thin = !(thickness > 0.0f);
  SINEW_TRY(out.attenuation_distance,
            volume.number("attenuationDistance", out.attenuation_distance));
  SINEW_CHECKED(volume.numbers("attenuationColor", {&out.attenuation_color.x, 3}));
  return {};
}

Result<SpecularGlossiness> read_specular_glossiness(const Json& json, TextureReader& textures) {
  SpecularGlossiness result;
  SINEW_CHECKED(json.numbers("diffuseFactor", {&result.diffuse.x, 4}));
  SINEW_TRY(result.diffuse_texture, textures.read(json, "diffuseTexture"));
  SINEW_CHECKED(json.numbers("specularFactor", {&result.specular.x, 3}));
  SINEW_TRY(result.glossiness, json.number("glossinessFactor", 1.0f));
  SINEW_TRY(result.specular_texture, textures.read(json, "specularGlossinessTexture"));
  return result;
}

// Files may hold numbers that no surface has; rendering relies on the specification's ranges.
void clamp_to_range(Material& material) {
  constexpr float kBrightest = 1e6f;  // also keeps products of factors finite
  constexpr float kFarthest = 1e29f;  // metres
  material.base_color = glm::clamp(material.base_color, 0.0f, 1.0f);
  material.metallic = glm::clamp(material.metallic, 0.0f, 1.0f);
  material.roughness = glm::clamp(material.roughness, 0.0f, 1.0f);
  material.occlusion_strength = glm::clamp(material.occlusion_strength, 0.0f, 1.0f);
  material.emissive = glm::clamp(material.emissive, 0.0f, kBrightest);
  material.specular = glm::clamp(material.specular, 0.0f, 1.0f);
  material.specular_color = glm::clamp(material.specular_color, 0.0f, kBrightest);
  material.transmission = glm::clamp(material.transmission, 0.0f, 1.0f);
  material.attenuation_color = glm::clamp(material.attenuation_color, 0.0f, 1.0f);
  material.attenuation_distance = glm::clamp(material.attenuation_distance, 0.0f, kFarthest);
}

Result<Material> read_material(const Reader& reader, const Json& json, TextureReader& textures) {
  Material result = default_material();
  SINEW_TRY(result.name, json.text("name"));
  SINEW_CHECKED(read_metallic_roughness(json, textures, result));
  SINEW_CHECKED(read_detail_textures(json, textures, result));
  SINEW_CHECKED(read_alpha(json, result));
  SINEW_TRY(result.double_sided, json.boolean("doubleSided", false));
  SINEW_TRY(const Json extensions, json.object("extensions"));
  result.unlit = extensions.has("KHR_materials_unlit");
  SINEW_TRY(const Json strength, extensions.object("KHR_materials_emissive_strength"));
  SINEW_TRY(const float factor, strength.number("emissiveStrength", 1.0f));
  result.emissive *= factor;
  SINEW_CHECKED(read_reflectance(reader, extensions, result));
  SINEW_CHECKED(read_transmission(extensions, textures, result));
  clamp_to_range(result);
  return result;
}

}  // namespace

Material default_material() {
  Material result;
  result.metallic = 1.0f;
  result.roughness = 1.0f;
  result.double_sided = false;
  return result;
}

Result<void> read_materials(const Reader& reader, Scene& scene) {
  SINEW_TRY(TextureReader textures, TextureReader::create(reader));
  SINEW_TRY(const std::vector<Json> materials,
            reader.asset.root().objects("materials", "material"));
  SINEW_CHECKED(reader.budget.take(reader.asset.root(), materials.size(), sizeof(Material)));
  std::vector<Pending> pending;
  for (const Json& json : materials) {
    SINEW_TRY(Material material, read_material(reader, json, textures));
    SINEW_TRY(const Json extensions, json.object("extensions"));
    if (extensions.has("KHR_materials_pbrSpecularGlossiness")) {
      SINEW_TRY(const Json surface, extensions.object("KHR_materials_pbrSpecularGlossiness"));
      SINEW_TRY(const SpecularGlossiness values, read_specular_glossiness(surface, textures));
      pending.push_back({static_cast<uint32_t>(scene.materials.size()), values});
    }
    scene.materials.push_back(std::move(material));
  }
  SINEW_TRY(scene.images, textures.decode());
  for (const Pending& item : pending) {
    SINEW_CHECKED(reader.budget.take(materials[item.material],
                                     converted_pixels(item.surface, scene.images), 8));
    convert(item.surface, scene.materials[item.material], scene.images);
  }
  return {};
}

}  // namespace sinew::gltf
