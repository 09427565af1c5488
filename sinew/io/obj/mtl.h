// The statements of a material library (.mtl), as the file says them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/math/vec.h"

namespace sinew {

struct MtlTexture {
  std::string file;  // empty: none
  vec2 scale{1.0f};  // uv' = offset + scale * uv, with v up
  vec2 offset{0.0f};
  float bump_scale = 1.0f;
  bool clamp = false;
  uint64_t line = 0;
};

struct MtlMaterial {
  std::string name;
  std::optional<vec3> diffuse;    // Kd
  std::optional<vec3> specular;   // Ks
  std::optional<float> exponent;  // Ns
  vec3 emission{0.0f};            // Ke
  float opacity = 1.0f;           // d, or 1 - Tr
  int illum = 2;
  std::optional<float> roughness;  // Pr
  std::optional<float> metallic;   // Pm
  MtlTexture diffuse_map;          // map_Kd
  MtlTexture opacity_map;          // map_d
  MtlTexture emission_map;         // map_Ke
  MtlTexture bump_map;             // map_Bump, bump: heights, or often in truth a normal map
  MtlTexture normal_map;           // norm
};

// `path` stands in errors; warnings name it too.
Result<std::vector<MtlMaterial>> parse_mtl(std::string_view text, const std::string& path,
                                           bool strict, std::vector<std::string>& warnings);

}  // namespace sinew
