// Lines are clipped in front of the eye and to the picture, then drawn one pixel wide with two
// pixels a step along the longer axis.
// Based on: X. Wu, "An Efficient Antialiasing Technique", SIGGRAPH 1991; Y.-D. Liang, B. A. Barsky,
// "A New Concept and Method for Line Clipping", ACM TOG 1984.
#include "sinew/render/box_lines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/render/color_map.h"

namespace sinew {
namespace {

constexpr float kFaint = 0.2f;         // opacity of what lies behind a surface
constexpr float kDepthSlack = 0.002f;  // relative: boxes touch the surfaces that they enclose

// On the picture: x, y in pixels, and what is linear in the picture: 1 / depth in perspective, else
// the depth.
using ScreenPoint = vec3;

class LinePainter {
 public:
  LinePainter(const CameraView& camera, std::span<const float> depth, Image8& picture)
      : camera_(camera), depth_(depth), picture_(picture), size_(picture.width, picture.height) {
    world_to_camera_ = inverse_affine(camera.to_world);
    const float half_height = camera.orthographic ? camera.ymag : std::tan(0.5f * camera.yfov);
    pixels_ = 0.5f * size_.y / half_height;
  }

  vec3 to_camera(vec3 world) const { return transform_point(world_to_camera_, world); }

  // Between two points in camera space.
  void draw(vec3 a, vec3 b, Color8 color) {
    float nearest = camera_.znear;
    if (!camera_.orthographic) nearest = std::max(nearest, 1e-6f * std::max(-a.z, -b.z));
    if (-a.z < nearest && -b.z < nearest) return;
    if (-a.z < nearest) a = mix(b, a, (b.z + nearest) / (b.z - a.z));
    if (-b.z < nearest) b = mix(a, b, (a.z + nearest) / (a.z - b.z));
    ScreenPoint p = project(a), q = project(b);
    if (clip(p, q)) draw_on_screen(p, q, color);
  }

 private:
  ScreenPoint project(vec3 p) const {
    const float depth = -p.z;
    const float scale = camera_.orthographic ? pixels_ : pixels_ / depth;
    return {0.5f * size_.x + p.x * scale, 0.5f * size_.y - p.y * scale,
            camera_.orthographic ? depth : 1.0f / depth};
  }

  // To the picture; false if nothing is left.
  bool clip(ScreenPoint& p, ScreenPoint& q) const {
    float first = 0.0f, last = 1.0f;
    for (int axis = 0; axis < 2; ++axis) {
      const float step = q[axis] - p[axis];
      if (step == 0.0f) {
        if (!(p[axis] >= 0.0f && p[axis] <= size_[axis])) return false;
        continue;
      }
      const float at_low = -p[axis] / step, at_high = (size_[axis] - p[axis]) / step;
      first = std::max(first, std::min(at_low, at_high));
      last = std::min(last, std::max(at_low, at_high));
    }
    if (!(first <= last)) return false;
    const ScreenPoint start = p, way = q - p;
    p = start + first * way;
    q = start + last * way;
    return std::isfinite(dot(p, p) + dot(q, q));
  }

  void draw_on_screen(ScreenPoint p, ScreenPoint q, Color8 color) {
    const int major = std::abs(q.x - p.x) >= std::abs(q.y - p.y) ? 0 : 1;
    const int minor = 1 - major;
    if (p[major] > q[major]) std::swap(p, q);
    const float length = q[major] - p[major];
    const int first = static_cast<int>(p[major]), last = static_cast<int>(q[major]);
    for (int at = first; at <= last; ++at) {
      const float begin = std::max(static_cast<float>(at), p[major]);
      const float end = std::min(static_cast<float>(at) + 1.0f, q[major]);
      const float share = length > 0.0f ? (0.5f * (begin + end) - p[major]) / length : 0.5f;
      const ScreenPoint here = mix(p, q, std::clamp(share, 0.0f, 1.0f));
      const float covered = length > 1.0f ? end - begin : 1.0f;  // of this column
      const float low = std::floor(here[minor] - 0.5f);
      const float upper_share = here[minor] - 0.5f - low;
      for (int side = 0; side < 2; ++side) {
        const int across = static_cast<int>(low) + side;
        const float weight = covered * (side == 0 ? 1.0f - upper_share : upper_share);
        blend(major == 0 ? at : across, major == 0 ? across : at, here.z, weight, color);
      }
    }
  }

  void blend(int x, int y, float depth_or_inverse, float opacity, Color8 color) {
    if (x < 0 || y < 0 || x >= static_cast<int>(picture_.width) ||
        y >= static_cast<int>(picture_.height)) {
      return;
    }
    const size_t pixel = static_cast<size_t>(y) * picture_.width + static_cast<size_t>(x);
    const float depth = camera_.orthographic ? depth_or_inverse : 1.0f / depth_or_inverse;
    if (depth > depth_[pixel] * (1.0f + kDepthSlack)) opacity *= kFaint;
    uint8_t* const out = &picture_.pixels[4 * pixel];
    for (size_t c = 0; c < 3; ++c) {
      const float under = static_cast<float>(out[c]) * (static_cast<float>(out[3]) / 255.0f);
      out[c] =
          static_cast<uint8_t>(under + opacity * (static_cast<float>(color[c]) - under) + 0.5f);
    }
    out[3] = 255;
  }

  const CameraView& camera_;
  const std::span<const float> depth_;
  Image8& picture_;
  const vec2 size_;
  Affine world_to_camera_;
  float pixels_ = 0.0f;  // a unit at depth 1
};

}  // namespace

size_t draw_boxes(const World& world, uint32_t level, const CameraView& camera,
                  std::span<const float> depth, Image8& picture) {
  SINEW_CHECK(depth.size() == size_t{picture.width} * picture.height);
  SINEW_CHECK(picture.pixels.size() == 4 * depth.size());
  LinePainter painter(camera, depth, picture);
  const std::vector<TreeBox> boxes = world.boxes(level);
  for (const TreeBox& box : boxes) {
    const bool of_top = box.object == kNoObject;
    const Affine placement = of_top ? identity_affine() : world.placement(box.object);
    const Color8 color = of_top ? Color8{255, 255, 255} : index_color(box.object);
    std::array<vec3, 8> corner;
    for (uint32_t i = 0; i < 8; ++i) {
      const vec3 at(i & 1 ? box.box.max.x : box.box.min.x, i & 2 ? box.box.max.y : box.box.min.y,
                    i & 4 ? box.box.max.z : box.box.min.z);
      corner[i] = painter.to_camera(transform_point(placement, at));
    }
    for (uint32_t i = 0; i < 8; ++i) {
      for (const uint32_t axis : {1u, 2u, 4u}) {
        if ((i & axis) == 0) painter.draw(corner[i], corner[i | axis], color);
      }
    }
  }
  return boxes.size();
}

}  // namespace sinew
