// From AFF's fill statements (`f`, `fm`) and textures to materials.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/aff/text.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew::aff {

// What surfaces are like until the next fill statement. The reflected radiance is
// ambient * am + sum over lights of L * (diffuse * cos + specular * highlight) + specular * mirror.
struct Fill {
  vec3 ambient{0.0f};
  vec3 diffuse{0.8f};
  vec3 specular{0.0f};
  float shine = 0.0f;          // Phong exponent
  float transmittance = 0.0f;  // share of the light that passes
  float ior = 0.0f;            // index of refraction; 1 or less: light passes unbent
};

// Textures lie in the folder of the top file or in "TextureFiles" beside it.
class Materials {
 public:
  Materials(Scene& scene, const std::filesystem::path& folder);

  void set_fill(const Fill& fill) { fill_ = fill; }
  // The material of the fill with that texture ("": none), whose image may take `memory` bytes;
  // `words` say where, for errors.
  Result<uint32_t> use(const std::string& texture, uint64_t memory, const Words& words);
  // To be called at the end: `light` is the ambient light, which may come after its materials.
  void set_ambient_light(vec3 light);

 private:
  // The image's index, -1 if it is missing.
  Result<int32_t> image(const std::string& name, uint64_t memory, const Words& words);

  Scene& scene_;
  const std::filesystem::path folder_;    // canonical, of the top file
  const std::filesystem::path textures_;  // canonical
  Fill fill_;
  std::vector<Fill> fills_;                           // one a material
  std::map<std::vector<float>, uint32_t> materials_;  // by the fill's values and the image
  std::map<std::string, int32_t> images_;             // by path
  std::map<std::string, int32_t> names_;              // by name in the file
};

// A fill as a surface; emission is not set.
Material convert(const Fill& fill);

// A colour as a screen shows it (sRGB, may be above 1) to a linear one. BART's pictures were shown
// without correction, so what AFF gives as a colour to be seen, as opposed to a reflectance, is
// one.
vec3 linear_from_display(vec3 color);

}  // namespace sinew::aff
