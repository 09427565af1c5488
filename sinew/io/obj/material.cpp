#include "sinew/io/obj/material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "sinew/io/asset_folder.h"
#include "sinew/io/image_file.h"
#include "sinew/io/output_file.h"
#include "sinew/math/color.h"

namespace sinew {
namespace {

constexpr uint64_t kMostLibraryBytes = uint64_t{1} << 28;

// A Phong lobe cos^n is about as wide as a microfacet lobe of alpha^2 = 2 / (n + 2) (Walter et al.,
// "Microfacet models for refraction", 2007, section 5.1); glTF's roughness is sqrt(alpha).
float roughness_of_exponent(float exponent) {
  return std::pow(2.0f / (std::max(exponent, 0.0f) + 2.0f), 0.25f);
}

bool is_grey(const Image8& image) {
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    const uint8_t* pixel = &image.pixels[i];
    if (pixel[0] != pixel[1] || pixel[0] != pixel[2]) return false;
  }
  return true;
}

std::string at_line(const MtlTexture& map) {
  return map.line == 0 ? "" : "line " + std::to_string(map.line);
}

// illum says which terms count: 0 colour alone, 1 no highlights, 3, 5 and 8 mirror reflections.
void set_shading(const MtlMaterial& mtl, Material& out) {
  const vec3 specular = mtl.specular.value_or(vec3(0.0f));
  const bool mirror = mtl.illum == 3 || mtl.illum == 5 || mtl.illum == 8;
  const bool shines = mtl.illum >= 2 && largest(specular) > 0.0f;
  const vec3 diffuse = vec3(out.base_color);
  out.unlit = mtl.illum == 0;
  out.roughness = shines ? roughness_of_exponent(mtl.exponent.value_or(10.0f)) : 1.0f;
  if (mirror && largest(diffuse) < 0.04f && shines) {  // only metals reflect but do not scatter
    out.metallic = 1.0f;
    out.base_color = vec4(clamp(specular, 0.0f, 1.0f), out.base_color.w);
  }
  if (mtl.roughness) out.roughness = std::clamp(*mtl.roughness, 0.0f, 1.0f);
  if (mtl.metallic) out.metallic = std::clamp(*mtl.metallic, 0.0f, 1.0f);
}

}  // namespace

ObjMaterials::ObjMaterials(Scene& scene, const std::string& path, const LoadOptions& options)
    : scene_(scene), path_(path), folder_(asset_folder(path)), options_(options) {}

Result<std::vector<uint32_t>> ObjMaterials::of_parts(const PolygonModel& model) {
  for (const std::string& library : model.libraries) SINEW_CHECKED(read_library(library));
  std::vector<uint32_t> result;
  std::vector<std::string> undefined;
  for (const PolygonPart& part : model.parts) {
    const std::string name = part.material == kNoIndex ? "" : model.materials[part.material];
    const auto [entry, added] =
        materials_.try_emplace(name, static_cast<uint32_t>(scene_.materials.size()));
    if (added) {
      const auto found = definitions_.find(name);
      const bool defined = found != definitions_.end();
      if (!defined && part.material != kNoIndex) undefined.push_back(name);
      Definition otherwise{{}, path_};
      otherwise.mtl.diffuse_map.file = model.texture;
      SINEW_TRY(Material material, convert(defined ? found->second : otherwise));
      material.name = name;
      scene_.materials.push_back(std::move(material));
    }
    result.push_back(entry->second);
  }
  if (!undefined.empty()) {
    const size_t named = std::min<size_t>(undefined.size(), 4);
    scene_.warnings.push_back(fmt::format(
        "{} materials are not defined and take the default: {}{}", undefined.size(),
        fmt::join(undefined.begin(), undefined.begin() + static_cast<ptrdiff_t>(named), ", "),
        named < undefined.size() ? ", ..." : ""));
  }
  return result;
}

Result<void> ObjMaterials::read_library(const std::string& name) {
  if (!libraries_.insert(name).second) return {};
  std::string portable = name;
  std::replace(portable.begin(), portable.end(), '\\', '/');
  const auto file = within_folder(folder_, portable);
  if (!file) {
    return fail({ErrorKind::bad_input, path_, "mtllib " + name, "lies outside the asset's folder",
                 "put it beside the OBJ file"});
  }
  std::error_code ignored;
  if (!std::filesystem::exists(*file, ignored)) {
    scene_.warnings.push_back("material library \"" + name + "\" is missing");
    return {};
  }
  SINEW_TRY(const std::string text,
            read_file(file->string(), std::min(options_.memory_limit, kMostLibraryBytes)));
  SINEW_TRY(std::vector<MtlMaterial> materials,
            parse_mtl(text, file->string(), options_.strict, scene_.warnings));
  for (MtlMaterial& mtl : materials) {
    std::string key = mtl.name;
    definitions_.try_emplace(std::move(key), Definition{std::move(mtl), file->string()});
  }
  return {};
}

// Kd is taken as linear and multiplies its map; exporters that write a black Kd beside a map mean
// the map alone.
Result<Material> ObjMaterials::convert(const Definition& definition) {
  const MtlMaterial& mtl = definition.mtl;
  Material out;
  SINEW_TRY(out.base_color_texture, texture(mtl.diffuse_map, definition.library));
  const bool has_map = out.base_color_texture.image >= 0;
  vec3 diffuse = clamp(mtl.diffuse.value_or(vec3(has_map ? 1.0f : 0.8f)), 0.0f, 1.0f);
  if (has_map && largest(diffuse) == 0.0f) diffuse = vec3(1.0f);
  out.base_color = vec4(diffuse, std::clamp(mtl.opacity, 0.0f, 1.0f));
  if (out.base_color.w < 1.0f) out.alpha_mode = AlphaMode::blend;
  set_shading(mtl, out);

  SINEW_TRY(out.emissive_texture, texture(mtl.emission_map, definition.library));
  const vec3 emission = max(mtl.emission, vec3(0.0f));
  const bool map_alone = out.emissive_texture.image >= 0 && largest(emission) == 0.0f;
  out.emissive = map_alone ? vec3(1.0f) : emission;
  SINEW_CHECKED(add_opacity_map(definition, out));
  SINEW_CHECKED(add_bump(definition, out));
  return out;
}

// The common use of map_d is to say that the alpha of the colour's own image counts.
Result<void> ObjMaterials::add_opacity_map(const Definition& definition, Material& out) {
  const MtlTexture& map = definition.mtl.opacity_map;
  if (map.file.empty()) return {};
  if (map.file == definition.mtl.diffuse_map.file) {
    if (out.alpha_mode == AlphaMode::opaque) out.alpha_mode = AlphaMode::mask;
    return {};
  }
  return unsupported({ErrorKind::bad_input, definition.library, at_line(map),
                      "opacity maps of their own (map_d) are not supported", ""});
}

Result<void> ObjMaterials::add_bump(const Definition& definition, Material& out) {
  const bool is_normal_map = !definition.mtl.normal_map.file.empty();
  const MtlTexture& map = is_normal_map ? definition.mtl.normal_map : definition.mtl.bump_map;
  SINEW_TRY(const TextureRef found, texture(map, definition.library));
  if (found.image < 0) return {};
  if (!is_normal_map && is_grey(scene_.images[found.image])) {
    return unsupported({ErrorKind::bad_input, definition.library, at_line(map),
                        "bump maps of heights are not supported, normal maps are", ""});
  }
  out.normal_texture = found;
  out.normal_scale = map.bump_scale;
  return {};
}

// OBJ: uv' = offset + scale * uv with v up; here v goes down, v_down = 1 - v_up.
Result<TextureRef> ObjMaterials::texture(const MtlTexture& map, const std::string& library) {
  TextureRef result;
  if (map.file.empty()) return result;
  SINEW_TRY(result.image, image(map, library));
  result.scale = map.scale;
  result.offset = vec2(map.offset.x, 1.0f - map.scale.y - map.offset.y);
  result.wrap_s = result.wrap_t = map.clamp ? Wrap::clamp : Wrap::repeat;
  return result;
}

Result<int32_t> ObjMaterials::image(const MtlTexture& map, const std::string& library) {
  const auto file = within_folder(folder_, map.file);
  if (!file) {
    return fail({ErrorKind::bad_input, library, at_line(map),
                 "map \"" + map.file + "\" lies outside the asset's folder",
                 "put it beside the mesh and name it by its relative path"});
  }
  const auto [entry, added] = images_.try_emplace(file->string(), -1);
  if (!added) return entry->second;
  std::error_code ignored;
  if (!std::filesystem::exists(*file, ignored)) {
    scene_.warnings.push_back("map \"" + map.file + "\" is missing");
    return -1;
  }
  const uint64_t left = options_.memory_limit - std::min(options_.memory_limit, image_bytes_);
  SINEW_TRY(const std::string text, read_file(file->string(), left));
  const std::span bytes(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  if (!is_image(bytes)) {
    SINEW_CHECKED(unsupported({ErrorKind::bad_input, library, at_line(map),
                               "map \"" + map.file + "\" is neither PNG nor JPEG", ""}));
    return -1;
  }
  SINEW_TRY(const ImageSize size, image_size(bytes, file->string()));
  const uint64_t needed = uint64_t{4} * size.width * size.height;
  if (needed > left) {
    return fail({ErrorKind::bad_input, file->string(), "",
                 "the images take more than the memory limit", "raise the memory limit"});
  }
  SINEW_TRY(Image8 decoded, decode_image(bytes, file->string()));
  image_bytes_ += needed;
  entry->second = static_cast<int32_t>(scene_.images.size());
  scene_.images.push_back(std::move(decoded));
  return entry->second;
}

Result<void> ObjMaterials::unsupported(const Error& problem) {
  if (options_.strict) {
    Error error = problem;
    error.remedy = "load it without strict";
    return fail(std::move(error));
  }
  scene_.warnings.push_back(problem.message() + ": ignored");
  return {};
}

}  // namespace sinew
