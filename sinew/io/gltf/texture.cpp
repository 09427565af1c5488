#include "sinew/io/gltf/texture.h"

#include <fmt/format.h>

#include <span>

#include "sinew/base/parallel.h"
#include "sinew/io/image_file.h"

namespace sinew::gltf {
namespace {

constexpr uint64_t kNearest = 9728;
constexpr uint64_t kRepeat = 10497;
constexpr uint64_t kClampToEdge = 33071;
constexpr uint64_t kMirroredRepeat = 33648;
constexpr uint64_t kLargestEnum = 0xffff;

Result<Wrap> read_wrap(const Json& sampler, const char* key) {
  SINEW_TRY(const uint64_t mode, sampler.unsigned_number(key, kRepeat, kLargestEnum));
  if (mode == kRepeat) return Wrap::repeat;
  if (mode == kMirroredRepeat) return Wrap::mirror;
  if (mode == kClampToEdge) return Wrap::clamp;
  return sampler.error(fmt::format("\"{}\" {} is not a wrapping mode", key, mode));
}

std::span<const uint8_t> as_bytes(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

Result<TextureReader> TextureReader::create(const Reader& reader) {
  TextureReader result(reader);
  const Json root = reader.asset.root();
  SINEW_TRY(result.textures_, root.objects("textures", "texture"));
  SINEW_TRY(result.samplers_, root.objects("samplers", "sampler"));
  SINEW_TRY(result.images_, root.objects("images", "image"));
  result.scene_image_.assign(result.images_.size(), -1);
  return result;
}

Result<void> TextureReader::read_sampler(const Json& texture, TextureRef& out) const {
  SINEW_TRY(const auto index, texture.index("sampler", samplers_.size()));
  if (!index) return {};
  const Json& sampler = samplers_[*index];
  SINEW_TRY(out.wrap_s, read_wrap(sampler, "wrapS"));
  SINEW_TRY(out.wrap_t, read_wrap(sampler, "wrapT"));
  SINEW_TRY(const uint64_t filter, sampler.unsigned_number("magFilter", 0, kLargestEnum));
  out.nearest = filter == kNearest;
  return {};
}

// `info` is a textureInfo object.
Result<void> TextureReader::read_transform(const Json& info, TextureRef& out) const {
  SINEW_TRY(uint64_t texcoord, info.unsigned_number("texCoord", 0, kLargestEnum));
  SINEW_TRY(const Json extensions, info.object("extensions"));
  SINEW_TRY(const Json transform, extensions.object("KHR_texture_transform"));
  SINEW_CHECKED(transform.numbers("offset", {&out.offset.x, 2}));
  SINEW_CHECKED(transform.numbers("scale", {&out.scale.x, 2}));
  SINEW_TRY(out.rotation, transform.number("rotation", 0.0f));
  SINEW_TRY(texcoord, transform.unsigned_number("texCoord", texcoord, kLargestEnum));
  out.texcoord = static_cast<uint32_t>(texcoord);
  return {};
}

Result<TextureRef> TextureReader::read(const Json& owner, const char* key) {
  SINEW_TRY(const Json info, owner.object(key));
  if (!owner.has(key)) return TextureRef();
  SINEW_TRY(const uint32_t index, info.required_index("index", textures_.size()));
  const Json& texture = textures_[index];
  SINEW_TRY(const auto image, texture.index("source", images_.size()));
  if (!image) {
    reader_.warnings.add(texture.element(), "has no image in a supported format; left out");
    return TextureRef();
  }
  TextureRef result;
  SINEW_CHECKED(read_sampler(texture, result));
  SINEW_CHECKED(read_transform(info, result));
  if (result.texcoord > 1) {
    reader_.warnings.add(owner.element(), "a texture uses TEXCOORD_2 or higher; left out");
    return TextureRef();
  }
  if (scene_image_[*image] < 0) {
    scene_image_[*image] = static_cast<int32_t>(used_.size());
    used_.push_back(*image);
  }
  result.image = scene_image_[*image];
  return result;
}

Result<std::vector<Image8>> TextureReader::decode() const {
  std::vector<std::string> loaded(used_.size());  // the files behind images that have a URI
  std::vector<std::span<const uint8_t>> bytes(used_.size());
  for (size_t i = 0; i < used_.size(); ++i) {
    const Json& image = images_[used_[i]];
    if (image.has("uri")) {
      SINEW_TRY(loaded[i], load_uri(reader_.asset, image, reader_.budget));
      bytes[i] = as_bytes(loaded[i]);
    } else {
      SINEW_TRY(bytes[i], reader_.accessors.view_bytes(image, "bufferView"));
    }
  }
  std::vector<Result<Image8>> decoded(used_.size());
  parallel_for(used_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      decoded[i] = decode_image(bytes[i], images_[used_[i]].element());
    }
  });
  std::vector<Image8> result;
  for (size_t i = 0; i < used_.size(); ++i) {
    const Json& image = images_[used_[i]];
    if (!decoded[i]) return image.error(decoded[i].error().problem, decoded[i].error().remedy);
    SINEW_CHECKED(reader_.budget.take(image, decoded[i]->pixels.size(), 1));
    result.push_back(std::move(*decoded[i]));
  }
  return result;
}

}  // namespace sinew::gltf
