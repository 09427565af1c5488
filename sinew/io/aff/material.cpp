// AFF shades classically: L * Kd * cos for a light L, mirrors with weight Ks at every angle, and
// adds Ka * am whatever lights there are. Here: base colour and transmission share Kd + T,
// reflectance at normal incidence is Ks (Schlick's term raises it towards grazing angles), and Ka *
// am is emission, since Ka has nothing to do with Kd. Highlights are energy-normalised, so they are
// narrower and brighter than Phong's.
#include "sinew/io/aff/material.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "sinew/io/asset_folder.h"
#include "sinew/io/image_file.h"
#include "sinew/io/image_ppm.h"
#include "sinew/io/output_file.h"
#include "sinew/io/text.h"
#include "sinew/math/color.h"
#include "sinew/math/srgb.h"

namespace sinew::aff {
namespace {

constexpr std::string_view kTextureFolder = "TextureFiles";
constexpr float kOpaqueIor = 1.5f;        // only the product with specular_color counts
constexpr float kLeastMirror = 0.1f;      // of Ks: below, the surface only has a highlight
constexpr float kMirrorRoughness = 0.2f;  // the roughest that mirrors sharply (render/shade.h)

// BART's surfaces mirror sharply whatever their highlight's exponent; for the others the inverse of
// phong_exponent (render/shade.h).
float roughness_of(const Fill& fill) {
  const float from_shine = std::pow(2.0f / (std::max(fill.shine, 0.0f) + 2.0f), 0.25f);
  const bool mirrors = largest(fill.specular) >= kLeastMirror || fill.transmittance > 0.0f;
  if (largest(fill.specular) <= 0.0f && !mirrors) return 1.0f;
  return mirrors ? std::min(from_shine, kMirrorRoughness) : from_shine;
}

std::vector<float> values_of(const Fill& fill, int32_t image) {
  return {fill.ambient.x,           fill.ambient.y, fill.ambient.z,     fill.diffuse.x,
          fill.diffuse.y,           fill.diffuse.z, fill.specular.x,    fill.specular.y,
          fill.specular.z,          fill.shine,     fill.transmittance, fill.ior,
          static_cast<float>(image)};
}

// The folder beside the files' own, if there is one; else the files' own.
std::filesystem::path texture_folder(const std::filesystem::path& folder) {
  const std::filesystem::path beside = folder.parent_path() / kTextureFolder;
  std::error_code failed;
  const std::filesystem::path canonical = std::filesystem::canonical(beside, failed);
  return failed ? folder : canonical;
}

}  // namespace

vec3 linear_from_display(vec3 color) {
  color = max(color, vec3(0.0f));
  return {srgb_to_linear(color.x), srgb_to_linear(color.y), srgb_to_linear(color.z)};
}

Material convert(const Fill& fill) {
  Material out;
  const vec3 diffuse = clamp(fill.diffuse, 0.0f, 1.0f);
  const float passes = std::clamp(fill.transmittance, 0.0f, 1.0f);
  const vec3 base = min(diffuse + passes, vec3(1.0f));
  out.base_color = vec4(base, 1.0f);
  out.roughness = roughness_of(fill);
  out.thin = fill.ior <= 1.0f;
  out.ior = out.thin ? kOpaqueIor : std::min(fill.ior, 100.0f);
  if (passes > 0.0f) {
    const float mean = (base.x + base.y + base.z) / 3.0f;
    out.transmission = std::min(passes / mean, 1.0f);
  }
  const float grazing = (out.ior - 1.0f) / (out.ior + 1.0f);
  out.specular_color = clamp(fill.specular, 0.0f, 1.0f) / (grazing * grazing);
  return out;
}

Materials::Materials(Scene& scene, const std::filesystem::path& folder)
    : scene_(scene), folder_(folder), textures_(texture_folder(folder)) {}

Result<uint32_t> Materials::use(const std::string& texture, uint64_t memory, const Words& words) {
  int32_t found = -1;
  if (!texture.empty()) {
    SINEW_TRY(found, image(texture, memory, words));
  }
  const auto [entry, added] = materials_.try_emplace(
      values_of(fill_, found), static_cast<uint32_t>(scene_.materials.size()));
  if (!added) return entry->second;
  Material material = convert(fill_);
  material.name = "material " + std::to_string(entry->second);
  if (found >= 0) material.name += " " + texture;
  material.base_color_texture.image = found;
  fills_.push_back(fill_);
  scene_.materials.push_back(std::move(material));
  return entry->second;
}

void Materials::set_ambient_light(vec3 light) {
  for (size_t i = 0; i < fills_.size(); ++i) {
    Material& material = scene_.materials[i];
    material.emissive = linear_from_display(fills_[i].ambient * light);
    material.emissive_texture = material.base_color_texture;
  }
  scene_.environment.ambient = vec3(0.0f);
}

Result<int32_t> Materials::image(const std::string& name, uint64_t memory, const Words& words) {
  if (const auto known = names_.find(name); known != names_.end()) return known->second;
  const auto error = [&](std::string problem, std::string remedy) {
    return words.error("texture \"" + printable(name) + "\" " + std::move(problem),
                       std::move(remedy));
  };
  const auto own = within_folder(folder_, name), shared = within_folder(textures_, name);
  if (!own && !shared) {
    return error("lies outside the scene's folders", "put it into " + std::string(kTextureFolder));
  }
  std::error_code ignored;
  const bool beside = own && std::filesystem::exists(*own, ignored);
  if (!beside && !(shared && std::filesystem::exists(*shared, ignored))) {
    if (scene_.warnings.size() >= kMostWarnings) {
      return error("is missing, as many others are",
                   "put them into " + std::string(kTextureFolder));
    }
    scene_.warnings.push_back(words.path() + ": line " + std::to_string(words.line()) +
                              ": texture \"" + printable(name) + "\" is missing");
    return names_[name] = -1;
  }
  const std::string path = beside ? own->string() : shared->string();
  if (const auto known = images_.find(path); known != images_.end()) {
    return names_[name] = known->second;
  }
  SINEW_TRY(const std::string text, read_file(path, memory));
  const std::span bytes(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  const bool ppm = is_ppm(bytes);
  if (!ppm && !is_image(bytes)) {
    return error("is neither PPM (P6) nor PNG nor JPEG", "convert it to PNG");
  }
  SINEW_TRY(const ImageSize size, ppm ? ppm_size(bytes, path) : image_size(bytes, path));
  const uint64_t needed = uint64_t{4} * size.width * size.height;
  if (needed > memory) return error("takes more than the memory limit", "raise the memory limit");
  SINEW_TRY(Image8 decoded, ppm ? decode_ppm(bytes, path) : decode_image(bytes, path));
  const auto index = static_cast<int32_t>(scene_.images.size());
  scene_.images.push_back(std::move(decoded));
  images_[path] = index;
  return names_[name] = index;
}

}  // namespace sinew::aff
