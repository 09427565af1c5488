// Textures, samplers and images of a glTF file. Only images that a supported material slot uses are
// decoded.
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/io/gltf/reader.h"
#include "sinew/scene/image.h"
#include "sinew/scene/material.h"

namespace sinew::gltf {

class TextureReader {
 public:
  static Result<TextureReader> create(const Reader& reader);

  // The texture that the member `key` of `owner` (a material or a part of one) means, with its
  // KHR_texture_transform. No member, or nothing that can be decoded: no texture.
  Result<TextureRef> read(const Json& owner, const char* key);

  // The images that read() met, in the order of TextureRef::image; decoded in parallel.
  Result<std::vector<Image8>> decode() const;

 private:
  explicit TextureReader(const Reader& reader) : reader_(reader) {}
  Result<void> read_sampler(const Json& texture, TextureRef& out) const;
  Result<void> read_transform(const Json& info, TextureRef& out) const;

  const Reader& reader_;
  std::vector<Json> textures_;
  std::vector<Json> samplers_;
  std::vector<Json> images_;
  std::vector<int32_t> scene_image_;  // JSON image -> index into used_, or -1
  std::vector<uint32_t> used_;        // JSON images to decode
};

}  // namespace sinew::gltf
