// Reading texture images: wrap modes, bilinear or nearest, sRGB decoding by table.
// Based on: glTF 2.0, section 3.8 ((0, 0) is the upper left corner of the image) and
// KHR_texture_transform; L. Williams, "Pyramidal Parametrics", SIGGRAPH 1983 (mip maps). Textures
// seen aslant are read several times along the longer axis of what a ray covers.
#pragma once

#include <span>
#include <vector>

#include "sinew/scene/image.h"
#include "sinew/scene/scene.h"

namespace sinew {

// Where the texture is read for the mesh's coordinate. Rotation is counter-clockwise in the space
// of the coordinates, whose v points down: u' = cos u + sin v (as the Khronos viewer does; the
// extension's GLSL listing has the other sign).
vec2 transform_texcoord(const TextureRef& texture, vec2 uv);

// Where a texture is read: the mesh's coordinate, and the half axes of the ellipse that the ray
// covers there. Zero: a point.
struct TexturePoint {
  vec2 uv{0.0f};
  vec2 major{0.0f};
  vec2 minor{0.0f};
};

// An image and copies of half its size, a quarter, ... down to one texel.
struct MipMap {
  const Image8* image = nullptr;
  std::vector<Image8> smaller;

  const Image8& level(size_t i) const { return i == 0 ? *image : smaller[i - 1]; }
};
// Texels are averaged as light; colours by their alpha, so that what is transparent leaves no
// fringe. `srgb`: colours are decoded for that and encoded again. The image must not be empty and
// must outlive the result.
MipMap make_mip_map(const Image8& image, bool srgb);

// The mip maps of a scene's textures, each made for what its materials use it for.
class TextureTable {
 public:
  void build(const Scene& scene);

  // The image that the reference means, as colours or as data; null if it means none.
  const MipMap* colors(const TextureRef& texture) const { return find(colors_, texture); }
  const MipMap* data(const TextureRef& texture) const { return find(data_, texture); }

 private:
  static const MipMap* find(std::span<const MipMap> maps, const TextureRef& texture);

  std::vector<MipMap> colors_, data_;  // one a Scene::images; without an image if not used so
};

// RGBA in 0..1, colours decoded from sRGB, averaged over what the point covers.
vec4 sample_srgb(const MipMap& map, const TextureRef& texture, const TexturePoint& point);
// RGBA in 0..1 as stored, averaged over what the point covers.
vec4 sample_linear(const MipMap& map, const TextureRef& texture, const TexturePoint& point);

// RGBA in 0..1, colours decoded from sRGB. `uv` is the mesh's coordinate; the image must not be
// empty.
vec4 sample_srgb(const Image8& image, const TextureRef& texture, vec2 uv);

// The image that the reference means, or null if it means none or an empty one.
const Image8* texture_image(std::span<const Image8> images, const TextureRef& texture);

}  // namespace sinew
