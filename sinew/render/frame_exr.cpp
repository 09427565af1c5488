#include "sinew/render/frame_exr.h"

#include <cmath>

#include "sinew/base/check.h"

namespace sinew {
namespace {

mat4 world_to_camera(const CameraView& camera) {
  const Affine inverse = inverse_affine(camera.to_world);
  mat4 m(vec4(inverse[0], 0.0f), vec4(inverse[1], 0.0f), vec4(inverse[2], 0.0f),
         vec4(inverse[3], 1.0f));
  for (int column = 0; column < 4; ++column) m[column].z = -m[column].z;  // left-handed
  return m;
}

// Camera space of the file to 0..1 in the picture; z grows with the distance.
mat4 camera_to_ndc(const CameraView& camera, ImageSize size) {
  const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
  const float half_width =
      half_height * static_cast<float>(size.width) / static_cast<float>(size.height);
  mat4 m(0.0f);
  m[0].x = 0.5f / half_width;
  m[1].y = -0.5f / half_height;
  m[2].z = 1.0f;
  m[3].z = -camera.znear;
  // The middle of the picture is at (0.5, 0.5) after division by w.
  const int w_column = camera.orthographic ? 3 : 2;
  m[w_column].w = 1.0f;
  m[w_column].x = m[w_column].y = 0.5f;
  return m;
}

// Indices as the file has them; none (kNoObject) becomes 0.
std::vector<uint32_t> from_one(const std::vector<uint32_t>& indices) {
  static_assert(kNoObject + 1u == 0u);
  std::vector<uint32_t> ids(indices);
  for (uint32_t& id : ids) ++id;
  return ids;
}

}  // namespace

Result<void> write_frame_exr(const std::string& path, const Image& color, const FrameLayers& layers,
                             const LayerChoice& choice, const CameraView& camera,
                             const ImageMetadata& texts) {
  const ImageSize size = choice.any_traced() ? ImageSize{layers.width, layers.height}
                                             : ImageSize{color.width, color.height};
  const size_t pixels = size_t{size.width} * size.height;
  std::vector<ExrChannel> channels;
  if (choice.color) {
    SINEW_CHECK(color.pixels.size() == pixels);
    const float* const first = &color.pixels[0].x;
    for (size_t i = 0; i < 4; ++i) {
      channels.push_back({std::string(1, "RGBA"[i]), ExrType::half, first + i, 4});
    }
  }
  if (choice.depth) {
    SINEW_CHECK(layers.depth.size() == pixels);
    channels.push_back({"depth.Z", ExrType::float32, layers.depth.data()});
  }
  if (choice.normal) {
    SINEW_CHECK(layers.normal.size() == pixels);
    const float* const first = &layers.normal[0].x;
    for (size_t i = 0; i < 3; ++i) {
      channels.push_back({std::string("normal.") + "XYZ"[i], ExrType::half, first + i, 3});
    }
  }
  const std::vector<uint32_t> objects = from_one(layers.object);
  const std::vector<uint32_t> primitives = from_one(layers.primitive);
  const auto add_integers = [&](const char* name, const std::vector<uint32_t>& values) {
    SINEW_CHECK(values.size() == pixels);
    channels.push_back({name, ExrType::uint32, values.data()});
  };
  if (choice.object) add_integers("object.id", objects);
  if (choice.primitive) add_integers("primitive.id", primitives);
  if (choice.traversal) add_integers("traversal.steps", layers.traversal);

  const mat4 to_camera = world_to_camera(camera);
  return write_exr(path, size, channels,
                   {texts, to_camera, camera_to_ndc(camera, size) * to_camera});
}

}  // namespace sinew
