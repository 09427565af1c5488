// KHR_materials_pbrSpecularGlossiness (archived) as a metallic-roughness material. Based on: the
// conversion in that extension's appendix (metallic from the brightness of diffuse and specular
// colour, dielectrics reflecting 4%). Where there are textures, both are converted pixel by pixel
// at the diffuse texture's size; they are taken to share texture coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/scene/image.h"
#include "sinew/scene/material.h"

namespace sinew::gltf {

struct SpecularGlossiness {
  vec4 diffuse{1.0f};          // linear
  TextureRef diffuse_texture;  // sRGB, linear alpha
  vec3 specular{1.0f};         // linear
  float glossiness = 1.0f;
  TextureRef specular_texture;  // sRGB specular, linear glossiness in alpha
};

// How many pixels each of the two images that convert() appends will have; 0: it appends none.
uint64_t converted_pixels(const SpecularGlossiness& surface, const std::vector<Image8>& images);

// Sets the colour, metalness and roughness of `out`; may append images.
void convert(const SpecularGlossiness& surface, Material& out, std::vector<Image8>& images);

}  // namespace sinew::gltf
