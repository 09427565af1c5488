#include "sinew/bvh/frames/camera_frames.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"

namespace sinew {
namespace {

constexpr size_t kTrianglesPerTask = 4096;

// A triangle cut at two planes has at most five corners.
struct Polygon {
  std::array<vec4, 5> corners;
  size_t count = 0;

  void add(vec4 corner) { corners[count++] = corner; }
};

// Keeps the side where distance(corner), linear in it, is positive. (Sutherland and Hodgman 1974.)
template <class Distance>
Polygon cut(const Polygon& polygon, const Distance& distance) {
  Polygon out;
  for (size_t i = 0; i < polygon.count; ++i) {
    const vec4 a = polygon.corners[i], b = polygon.corners[(i + 1) % polygon.count];
    const float at_a = distance(a), at_b = distance(b);
    if (at_a > 0.0f) out.add(a);
    if ((at_a > 0.0f) != (at_b > 0.0f)) out.add(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return out;
}

// Where a ray from the middle of the screen towards (x, y) leaves it.
vec2 border_point(vec2 direction) {
  const float reach = std::max(std::abs(direction.x), std::abs(direction.y));
  return reach > 0.0f ? direction / reach : vec2(1.0f, 0.0f);
}

Box screen_rectangle(const std::array<vec4, 3>& triangle) {
  Polygon polygon;
  float largest_w = 0.0f;
  for (const vec4& corner : triangle) {
    polygon.add(corner);
    largest_w = std::max(largest_w, std::abs(corner.w));
  }
  polygon = cut(polygon, [](const vec4& c) { return c.z + c.w; });
  // Some projections (reversed depth) have their near plane elsewhere, and nothing may be divided
  // by zero.
  const float least_w = 1e-6f * largest_w;
  polygon = cut(polygon, [&](const vec4& c) { return c.w - least_w; });

  Box box;
  if (polygon.count == 0) {
    const vec2 point = border_point(vec2(triangle[0] + triangle[1] + triangle[2]));
    box.extend(vec3(point, 0.0f));
    return box;
  }
  for (size_t i = 0; i < polygon.count; ++i) {
    const vec2 point = vec2(polygon.corners[i]) / polygon.corners[i].w;
    box.extend(vec3(glm::clamp(point, -1.0f, 1.0f), 0.0f));
  }
  return box;
}

}  // namespace

void view_boxes(std::span<const vec3> positions, std::span<const uvec3> triangles,
                const mat4& world_to_clip, std::span<Box> out) {
  SINEW_CHECK(out.size() == triangles.size());
  parallel_for(triangles.size(), kTrianglesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      std::array<vec4, 3> corners;
      vec4 sum(0.0f);
      for (int k = 0; k < 3; ++k) {
        corners[k] = world_to_clip * vec4(positions[triangles[i][k]], 1.0f);
        sum += corners[k];
      }
      const bool finite = std::isfinite(sum.x + sum.y + sum.z + sum.w);
      out[i] = finite ? screen_rectangle(corners) : Box();
    }
  });
}

double screen_share(std::span<const Box> view_boxes) {
  Box root;
  for (const Box& box : view_boxes) root.extend(box);
  return double(half_area(root)) / 4.0;
}

void append_view_frames(FrameBoxes& frames, std::vector<ViewFrame> views, double share) {
  SINEW_CHECK(share >= 0.0 && share <= 1.0);
  std::vector<double> weights;
  std::vector<std::vector<Box>> boxes;
  double sum = 0.0;
  for (ViewFrame& view : views) {
    SINEW_CHECK(frames.frames.empty() || view.boxes.size() == frames.primitive_count());
    const double weight = view.weight * screen_share(view.boxes);
    if (!(weight > 0.0)) continue;
    weights.push_back(weight);
    boxes.push_back(std::move(view.boxes));
    sum += weight;
  }
  if (boxes.empty() || share == 0.0) return;
  FrameBoxes finite = make_frame_boxes(std::move(boxes));
  const double rest = frames.frames.empty() ? 0.0 : 1.0 - share;
  for (double& weight : frames.weights) weight *= rest;
  for (size_t v = 0; v < weights.size(); ++v) {
    frames.frames.push_back(std::move(finite.frames[v]));
    frames.weights.push_back((1.0 - rest) * weights[v] / sum);
  }
}

}  // namespace sinew
