#include "sinew/render/views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/render/color_map.h"

namespace sinew {
namespace {

// Fills an opaque picture with color(pixel index).
template <class Color>
void paint(const FrameLayers& layers, size_t layer_size, Image8& out, const Color& color) {
  const size_t pixels = size_t{layers.width} * layers.height;
  SINEW_CHECK(layer_size == pixels);
  out.width = layers.width;
  out.height = layers.height;
  out.pixels.resize(4 * pixels);
  parallel_for(pixels, 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Color8 c = color(i);
      std::copy(c.begin(), c.end(), &out.pixels[4 * i]);
      out.pixels[4 * i + 3] = 255;
    }
  });
}

uint8_t byte_of(float x) {
  return static_cast<uint8_t>(std::clamp(x, 0.0f, 1.0f) * 255.0f + 0.5f);
}

}  // namespace

StepSummary summarize_steps(std::span<const uint32_t> steps) {
  StepSummary summary;
  uint64_t sum = 0;
  for (const uint32_t step : steps) {
    sum += step;
    summary.largest = std::max(summary.largest, step);
  }
  if (steps.empty()) return summary;
  summary.mean = static_cast<double>(sum) / static_cast<double>(steps.size());
  std::vector<uint32_t> sorted(steps.begin(), steps.end());
  const auto rank =
      sorted.begin() + static_cast<ptrdiff_t>(sorted.size() - 1 - sorted.size() / 200);
  std::nth_element(sorted.begin(), rank, sorted.end());
  summary.high = *rank;
  return summary;
}

uint32_t round_scale(uint32_t steps) {
  uint64_t tenth = 1;
  for (;; tenth *= 10) {
    for (const uint64_t tenths : {10, 12, 15, 20, 25, 30, 40, 50, 60, 80}) {
      if (tenths * tenth < steps) continue;
      return static_cast<uint32_t>(std::min<uint64_t>(tenths * tenth, UINT32_MAX));
    }
  }
}

void draw_heatmap(const FrameLayers& layers, uint32_t scale, Image8& out) {
  SINEW_CHECK(scale > 0);
  paint(layers, layers.traversal.size(), out, [&](size_t i) {
    return heat_color(static_cast<float>(layers.traversal[i]) / static_cast<float>(scale));
  });
}

void draw_normals(const FrameLayers& layers, Image8& out) {
  paint(layers, layers.normal.size(), out, [&](size_t i) {
    const vec3 n = layers.normal[i];
    if (n == vec3(0.0f)) return Color8{0, 0, 0};
    return Color8{byte_of(0.5f + 0.5f * n.x), byte_of(0.5f + 0.5f * n.y),
                  byte_of(0.5f + 0.5f * n.z)};
  });
}

void draw_depth(const FrameLayers& layers, Image8& out) {
  constexpr float kDarkest = 0.12f;
  float nearest = std::numeric_limits<float>::infinity(), farthest = -nearest;
  for (const float depth : layers.depth) {
    if (!std::isfinite(depth)) continue;
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  const float range = std::max(farthest - nearest, 1e-30f);
  paint(layers, layers.depth.size(), out, [&](size_t i) {
    if (!std::isfinite(layers.depth[i])) return Color8{0, 0, 0};
    const float share = (layers.depth[i] - nearest) / range;
    const uint8_t grey = byte_of(1.0f - (1.0f - kDarkest) * share);
    return Color8{grey, grey, grey};
  });
}

void draw_objects(const FrameLayers& layers, const CameraView& camera, Image8& out) {
  SINEW_CHECK(layers.normal.size() == layers.object.size());
  const vec3 to_eye = camera.to_world[2];
  paint(layers, layers.object.size(), out, [&](size_t i) {
    Color8 color{0, 0, 0};
    if (layers.object[i] == kNoObject) return color;
    color = index_color(layers.object[i]);
    const float shade = 0.55f + 0.45f * std::max(0.0f, dot(layers.normal[i], to_eye));
    for (uint8_t& channel : color) {
      channel = static_cast<uint8_t>(static_cast<float>(channel) * shade);
    }
    return color;
  });
}

}  // namespace sinew
