#include "sinew/render/raster_view.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr float kNearest = 1e-4f;     // as clip_from_world()
constexpr float kBorder = 4.0f;       // pixels at each edge that the filter may reach into
constexpr float kWidestCone = 1.05f;  // radians, half angle of a spot light that one view sees
constexpr float kScaleStep = 1.1f;    // between two sizes of a directional light's pixels

// Rows of the map from the world to the frame, each a linear function of (p, 1).
struct FrameRows {
  vec4 x, y, z;
};

FrameRows rows_of(const Affine& frame) {
  const auto row = [&](vec3 axis) { return vec4(axis, -dot(axis, frame[3])); };
  return {row(frame[0]), row(frame[1]), row(frame[2])};
}

// x and y are pixels on the plane at unit depth.
RasterView view_of(const FrameRows& rows, bool orthographic, float pixel, vec2 center) {
  RasterView out;
  out.depth = -rows.z;
  out.w = orthographic ? vec4(0.0f, 0.0f, 0.0f, 1.0f) : out.depth;
  out.x = rows.x / pixel + center.x * out.w;
  out.y = -rows.y / pixel + center.y * out.w;
  return out;
}

// A frame that looks along `direction`.
Affine frame_along(vec3 direction, vec3 eye) {
  const vec3 z = -direction;
  const vec3 up = std::abs(z.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
  const vec3 x = normalize(cross(up, z));
  return Affine(x, cross(z, x), z, eye);
}

// Contains the boxes as the axes see them.
Box extent_along(const Affine& axes, std::span<const Box> boxes) {
  Box out;
  for (const Box& box : boxes) {
    const vec3 center = box.center(), half = 0.5f * box.extent();
    vec3 at, reach;
    for (int i = 0; i < 3; ++i) {
      at[i] = dot(axes[i], center);
      reach[i] = dot(abs(axes[i]), half);
    }
    out.extend(Box{at - reach, at + reach});
  }
  return out;
}

}  // namespace

RasterView camera_raster_view(const CameraView& camera, uint32_t width, uint32_t height,
                              uint32_t step, vec2 offset) {
  const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
  const float pixel = 2.0f * half_height / static_cast<float>(height) * static_cast<float>(step);
  const vec2 center = 0.5f * vec2(width, height) / static_cast<float>(step) - offset + 0.5f;
  RasterView out = view_of(rows_of(camera.to_world), camera.orthographic, pixel, center);
  out.near = std::max(camera.znear, kNearest);
  out.width = (width + step - 1) / step;
  out.height = (height + step - 1) / step;
  return out;
}

RasterView perspective_view(const Affine& frame, float pixel, uint32_t width, uint32_t height,
                            float near) {
  RasterView out = view_of(rows_of(frame), false, pixel, 0.5f * vec2(width, height));
  out.near = near;
  out.width = width;
  out.height = height;
  return out;
}

RasterView directional_view(vec3 direction, std::span<const Box> boxes, uint32_t size) {
  Affine frame = frame_along(direction, vec3(0.0f));
  const Box box = extent_along(frame, boxes);
  const vec3 extent = max(box.extent(), vec3(1e-6f));
  const float needed = std::max(extent.x, extent.y) / (static_cast<float>(size) - 2.0f * kBorder);
  // The next of a few sizes, and a corner that is a whole number of pixels from the world's origin.
  const float pixel = std::pow(kScaleStep, std::ceil(std::log(needed) / std::log(kScaleStep)));
  const vec2 middle = 0.5f * vec2(box.min + box.max);
  const vec2 snapped = glm::round(middle / pixel) * pixel;
  frame[3] = frame[0] * snapped.x + frame[1] * snapped.y + frame[2] * (box.max.z + extent.z);
  RasterView out = view_of(rows_of(frame), true, pixel, vec2(0.5f * static_cast<float>(size)));
  out.near = 0.5f * extent.z;
  out.width = out.height = size;
  return out;
}

uint32_t light_views(const ShadingLight& light, float near, uint32_t size, RasterView (&out)[6]) {
  if (light.type == LightType::directional) return 0;
  const float pixels = static_cast<float>(size) - 2.0f * kBorder;
  const float outer =
      light.type == LightType::spot
          ? std::acos(std::clamp(-light.cone_offset / light.cone_scale, -1.0f, 1.0f))
          : kWidestCone + 1.0f;
  if (outer <= kWidestCone) {
    out[0] = perspective_view(frame_along(light.direction, light.position),
                              2.0f * std::tan(outer) / pixels, size, size, near);
    return 1;
  }
  for (int i = 0; i < 6; ++i) {
    vec3 direction(0.0f);
    direction[i / 2] = i % 2 == 0 ? 1.0f : -1.0f;
    out[i] =
        perspective_view(frame_along(direction, light.position), 2.0f / pixels, size, size, near);
  }
  return 6;
}

}  // namespace sinew
