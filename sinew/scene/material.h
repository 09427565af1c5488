// Surfaces: glTF 2.0's metallic-roughness material with its extensions KHR_materials_specular,
// _ior, _transmission and _volume, and the textures it refers to.
#pragma once

#include <cstdint>
#include <string>

#include "sinew/math/vec.h"

namespace sinew {

enum class Wrap : uint8_t { repeat, mirror, clamp };

struct TextureRef {
  int32_t image = -1;     // index into Scene::images; -1: no texture
  uint32_t texcoord = 0;  // which set of Mesh::texcoords
  Wrap wrap_s = Wrap::repeat;
  Wrap wrap_t = Wrap::repeat;
  bool nearest = false;  // else bilinear
  // KHR_texture_transform: uv' = offset + rotation * (scale * uv)
  vec2 offset{0.0f};
  float rotation = 0.0f;  // radians, counter-clockwise as the extension defines it
  vec2 scale{1.0f};
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

struct Material {
  std::string name;
  vec4 base_color{1.0f};          // linear
  TextureRef base_color_texture;  // sRGB colour, linear alpha
  float metallic = 0.0f;
  float roughness = 0.8f;
  TextureRef metallic_roughness_texture;  // linear: roughness in G, metallic in B
  TextureRef normal_texture;              // linear, tangent space, +Y up
  float normal_scale = 1.0f;
  TextureRef occlusion_texture;  // linear: occlusion in R
  float occlusion_strength = 1.0f;
  vec3 emissive{0.0f};
  TextureRef emissive_texture;  // sRGB
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = true;
  bool unlit = false;

  // Reflectance at normal incidence of what is not metal:
  // min(((ior - 1) / (ior + 1))^2 * specular_color, 1) * specular. At grazing incidence: specular.
  float ior = 1.5f;  // index of refraction, >= 1
  float specular = 1.0f;
  vec3 specular_color{1.0f};  // linear; may be above 1

  // Share of the light that is neither reflected nor absorbed by metal which passes through, tinted
  // by the base colour; the rest is diffuse.
  float transmission = 0.0f;
  TextureRef transmission_texture;  // linear: transmission in R
  bool thin = true;              // a sheet, which light passes unbent; else the surface of a solid
                                 // that bends light by `ior`
  vec3 attenuation_color{1.0f};  // what of white light is left after attenuation_distance inside
  float attenuation_distance = 0.0f;  // metres; 0: the inside is clear

  // Whether rays that come from behind see the surface: a solid's inside has to be left again.
  bool has_back() const { return double_sided || (transmission > 0.0f && !thin); }
};

}  // namespace sinew
