// Reading texture images: wrap modes, bilinear or nearest, sRGB decoding by table.
// Based on: glTF 2.0, section 3.8 ((0, 0) is the upper left corner of the image) and
// KHR_texture_transform. No mip maps: minified textures rely on the camera's samples.
#pragma once

#include <span>

#include "sinew/scene/image.h"
#include "sinew/scene/material.h"

namespace sinew {

// sRGB code to linear, IEC 61966-2-1.
float srgb_to_linear(uint8_t code);

// Where the texture is read for the mesh's coordinate. Rotation is counter-clockwise in the space
// of the coordinates, whose v points down: u' = cos u + sin v (as the Khronos viewer does; the
// extension's GLSL listing has the other sign).
vec2 transform_texcoord(const TextureRef& texture, vec2 uv);

// RGBA in 0..1, colours decoded from sRGB. `uv` is the mesh's coordinate; the image must not be
// empty.
vec4 sample_srgb(const Image8& image, const TextureRef& texture, vec2 uv);

// RGBA in 0..1 as stored.
vec4 sample_linear(const Image8& image, const TextureRef& texture, vec2 uv);

// The image that the reference means, or null if it means none or an empty one.
const Image8* texture_image(std::span<const Image8> images, const TextureRef& texture);

}  // namespace sinew
