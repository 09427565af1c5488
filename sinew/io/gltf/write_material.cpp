#include "sinew/io/gltf/write_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "sinew/base/parallel.h"
#include "sinew/io/image_file.h"
#include "sinew/math/box.h"

namespace sinew::gltf {
namespace {

int wrap_mode(Wrap wrap) {
  switch (wrap) {
    case Wrap::repeat:
      return 10497;
    case Wrap::mirror:
      return 33648;
    case Wrap::clamp:
      return 33071;
  }
  return 10497;
}

class MaterialWriter {
 public:
  explicit MaterialWriter(const WriteContext& context) : context_(context) {}

  JsonOut write(const Material& material, uint32_t index);

 private:
  void add_texture(JsonOut& owner, const char* key, const TextureRef& texture);
  uint32_t texture_index(const TextureRef& texture);
  uint32_t sampler_index(const TextureRef& texture);
  void add_metallic_roughness(const Material& material, JsonOut& out);
  void add_details(const Material& material, JsonOut& out);
  void add_extensions(const Material& material, uint32_t index, JsonOut& out);
  void add_transmission(const Material& material, uint32_t index, JsonOut& out);
  JsonOut& extension(JsonOut& owner, const char* name);
  float thickness(uint32_t material) const;
  // The value within the range that glTF allows; warns if that changes it.
  template <class T>
  T in_range(const Material& material, const char* what, const T& value, float low, float high);

  const WriteContext& context_;
  std::map<std::tuple<Wrap, Wrap, bool>, uint32_t> samplers_;
  std::map<std::pair<int32_t, uint32_t>, uint32_t> textures_;  // by image and sampler
};

template <class T>
T MaterialWriter::in_range(const Material& material, const char* what, const T& value, float low,
                           float high) {
  const T result = glm::clamp(value, low, high);
  if (result != value) {
    context_.warnings.add(element("material", material.name),
                          fmt::format("its {} is outside glTF's range; clamped", what));
  }
  return result;
}

JsonOut& MaterialWriter::extension(JsonOut& owner, const char* name) {
  context_.asset.use_extension(name);
  JsonOut& result = owner["extensions"][name];
  result = JsonOut::object();
  return result;
}

uint32_t MaterialWriter::sampler_index(const TextureRef& texture) {
  constexpr int kNearest = 9728, kLinear = 9729, kLinearMipmaps = 9987;
  const auto [place, is_new] =
      samplers_.try_emplace({texture.wrap_s, texture.wrap_t, texture.nearest}, 0);
  if (is_new) {
    place->second =
        context_.asset.add("samplers", {{"magFilter", texture.nearest ? kNearest : kLinear},
                                        {"minFilter", texture.nearest ? kNearest : kLinearMipmaps},
                                        {"wrapS", wrap_mode(texture.wrap_s)},
                                        {"wrapT", wrap_mode(texture.wrap_t)}});
  }
  return place->second;
}

uint32_t MaterialWriter::texture_index(const TextureRef& texture) {
  const uint32_t sampler = sampler_index(texture);
  const auto [place, is_new] = textures_.try_emplace({texture.image, sampler}, 0);
  if (is_new) {
    place->second =
        context_.asset.add("textures", {{"sampler", sampler}, {"source", texture.image}});
  }
  return place->second;
}

// Sets owner[key] to a textureInfo, if there is a texture.
void MaterialWriter::add_texture(JsonOut& owner, const char* key, const TextureRef& texture) {
  if (texture.image < 0) return;
  JsonOut info = {{"index", texture_index(texture)}};
  if (texture.texcoord > 0) info["texCoord"] = texture.texcoord;
  const TextureRef plain;
  const bool transformed = texture.offset != plain.offset || texture.scale != plain.scale ||
                           texture.rotation != plain.rotation;
  if (transformed) {
    JsonOut& transform = extension(info, "KHR_texture_transform");
    transform["offset"] = json_of(texture.offset);
    transform["rotation"] = double{texture.rotation};
    transform["scale"] = json_of(texture.scale);
  }
  owner[key] = std::move(info);
}

void MaterialWriter::add_metallic_roughness(const Material& material, JsonOut& out) {
  JsonOut surface = JsonOut::object();
  surface["baseColorFactor"] =
      json_of(in_range(material, "base colour", material.base_color, 0.0f, 1.0f));
  surface["metallicFactor"] =
      double{in_range(material, "metalness", material.metallic, 0.0f, 1.0f)};
  surface["roughnessFactor"] =
      double{in_range(material, "roughness", material.roughness, 0.0f, 1.0f)};
  add_texture(surface, "baseColorTexture", material.base_color_texture);
  add_texture(surface, "metallicRoughnessTexture", material.metallic_roughness_texture);
  out["pbrMetallicRoughness"] = std::move(surface);
}

void MaterialWriter::add_details(const Material& material, JsonOut& out) {
  add_texture(out, "normalTexture", material.normal_texture);
  if (out.contains("normalTexture") && material.normal_scale != 1.0f) {
    out["normalTexture"]["scale"] = double{material.normal_scale};
  }
  add_texture(out, "occlusionTexture", material.occlusion_texture);
  if (out.contains("occlusionTexture") && material.occlusion_strength != 1.0f) {
    out["occlusionTexture"]["strength"] =
        double{in_range(material, "occlusion", material.occlusion_strength, 0.0f, 1.0f)};
  }
  add_texture(out, "emissiveTexture", material.emissive_texture);
  const vec3 emissive = glm::max(material.emissive, vec3(0.0f));
  const float strongest = std::max({emissive.x, emissive.y, emissive.z});
  if (strongest > 0.0f) {
    const float strength = std::max(strongest, 1.0f);
    out["emissiveFactor"] = json_of(glm::min(emissive / strength, vec3(1.0f)));
    if (strength > 1.0f) {
      extension(out, "KHR_materials_emissive_strength")["emissiveStrength"] = double{strength};
    }
  }
  if (material.alpha_mode == AlphaMode::mask) {
    out["alphaMode"] = "MASK";
    out["alphaCutoff"] = double{std::max(material.alpha_cutoff, 0.0f)};
  } else if (material.alpha_mode == AlphaMode::blend) {
    out["alphaMode"] = "BLEND";
  }
  if (material.double_sided) out["doubleSided"] = true;
}

// A thickness for programs that cannot trace the light through a solid: the smallest extent of the
// first mesh that is made of the material, or a metre.
float MaterialWriter::thickness(uint32_t material) const {
  for (const Mesh& mesh : context_.scene.meshes) {
    const bool uses = std::any_of(mesh.parts.begin(), mesh.parts.end(),
                                  [&](const MeshPart& part) { return part.material == material; });
    if (!uses) continue;
    Box box;
    for (const vec3& p : mesh.positions) box.extend(p);
    const vec3 extent = box.empty() ? vec3(0.0f) : box.extent();
    const float least = std::min({extent.x, extent.y, extent.z});
    if (least > 0.0f) return least;
  }
  return 1.0f;
}

void MaterialWriter::add_transmission(const Material& material, uint32_t index, JsonOut& out) {
  if (!(material.transmission > 0.0f)) return;
  JsonOut& transmission = extension(out, "KHR_materials_transmission");
  transmission["transmissionFactor"] = double{material.transmission};
  add_texture(transmission, "transmissionTexture", material.transmission_texture);
  if (material.thin) return;
  JsonOut& volume = extension(out, "KHR_materials_volume");
  volume["thicknessFactor"] = double{thickness(index)};
  if (material.attenuation_distance > 0.0f) {
    volume["attenuationDistance"] = double{material.attenuation_distance};
    volume["attenuationColor"] =
        json_of(in_range(material, "attenuation colour", material.attenuation_color, 0.0f, 1.0f));
  }
}

void MaterialWriter::add_extensions(const Material& material, uint32_t index, JsonOut& out) {
  const Material plain;
  if (material.unlit) extension(out, "KHR_materials_unlit");
  if (material.ior != plain.ior) {
    extension(out, "KHR_materials_ior")["ior"] = double{material.ior};
  }
  if (material.specular != plain.specular || material.specular_color != plain.specular_color) {
    JsonOut& specular = extension(out, "KHR_materials_specular");
    specular["specularFactor"] =
        double{in_range(material, "specular factor", material.specular, 0.0f, 1.0f)};
    specular["specularColorFactor"] = json_of(glm::max(material.specular_color, vec3(0.0f)));
  }
  add_transmission(material, index, out);
}

JsonOut MaterialWriter::write(const Material& material, uint32_t index) {
  JsonOut out = named(material.name);
  add_metallic_roughness(material, out);
  add_details(material, out);
  add_extensions(material, index, out);
  return out;
}

Result<void> write_images(const WriteContext& context) {
  const std::vector<Image8>& images = context.scene.images;
  std::vector<Result<std::vector<uint8_t>>> encoded(images.size());
  parallel_for(images.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      encoded[i] = encode_png(images[i], fmt::format("image {}", i));
    }
  });
  for (Result<std::vector<uint8_t>>& png : encoded) {
    SINEW_TRY(std::vector<uint8_t> bytes, std::move(png));
    const uint32_t view = context.asset.add_bytes(std::move(bytes));
    context.asset.add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  }
  return {};
}

}  // namespace

Result<void> write_materials(const WriteContext& context) {
  SINEW_CHECKED(write_images(context));
  MaterialWriter writer(context);
  for (uint32_t i = 0; i < context.scene.materials.size(); ++i) {
    context.asset.add("materials", writer.write(context.scene.materials[i], i));
  }
  return {};
}

}  // namespace sinew::gltf
