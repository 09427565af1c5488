#include "sinew/render/camera_wave.h"

namespace sinew {
namespace {

uint32_t even_bits(uint32_t x) {
  x &= 0x55u;
  x = (x | (x >> 1)) & 0x33u;
  return (x | (x >> 2)) & 0x0fu;
}

// Where a pixel of the fine image lies between two drawn ones, along one axis.
struct Between {
  uint32_t low, high;
  float fraction;
};

Between place_between(size_t pixel, uint32_t drawn, uint32_t step) {
  const float at = (static_cast<float>(pixel) + 0.5f) / static_cast<float>(step) - 0.5f;
  const float inside = std::clamp(at, 0.0f, static_cast<float>(drawn - 1));
  const uint32_t low = static_cast<uint32_t>(inside);
  return {low, std::min(low + 1, drawn - 1), inside - static_cast<float>(low)};
}

// Radiance brought into [0, 1) and back. Between the two, a highlight of a thousand times white
// fades out over its neighbourhood instead of filling all of it.
vec4 compress(vec4 color) {
  const float peak = std::max({color.x, color.y, color.z, 0.0f});
  return vec4(vec3(color) / (1.0f + peak), color.w);
}
vec4 expand(vec4 color) {
  const float peak = std::max({color.x, color.y, color.z});
  return vec4(vec3(color) / std::max(1.0f - peak, 1e-6f), color.w);
}

}  // namespace

void start_wave(const DrawnPixels& pixels, uint32_t first, uint32_t last, vec2 offset, Wave& wave) {
  const TileGrid& grid = pixels.grid;
  const RayCone cone = pixels.cone();
  const size_t start = grid.first_pixel(first);
  wave.camera = true;
  wave.resize(grid.first_pixel(last) - start);
  parallel_for(last - first, 4, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const uint32_t tile = first + static_cast<uint32_t>(t);
      const uint32_t left = tile % grid.columns * kTile, top = tile / grid.columns * kTile;
      size_t next = grid.first_pixel(tile) - start;
      for (uint32_t code = 0; code < kTile * kTile; ++code) {
        const uint32_t x = left + even_bits(code), y = top + even_bits(code >> 1);
        if (x >= grid.width || y >= grid.height) continue;
        wave.rays[next] = pixels.ray(x, y, offset);
        wave.paths[next] = Path{.pixel = y * grid.width + x, .cone = cone};
        ++next;
      }
    }
  });
}

void CoarseToFine::resize(uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  order_.clear();
  level_end_.clear();
  const TileGrid grid{width, height};
  for (uint32_t step = kCoarsest; step > 0; step /= 2) {
    const auto is_coarser = [&](uint32_t x, uint32_t y) {
      return step < kCoarsest && x % (2 * step) == 0 && y % (2 * step) == 0;
    };
    for (uint32_t tile = 0; tile < grid.count(); ++tile) {
      const uint32_t left = tile % grid.columns * kTile, top = tile / grid.columns * kTile;
      for (uint32_t y = top; y < std::min(top + kTile, height); y += step) {
        for (uint32_t x = left; x < std::min(left + kTile, width); x += step) {
          if (!is_coarser(x, y)) order_.push_back(y * width + x);
        }
      }
    }
    level_end_.push_back(order_.size());
  }
}

void CoarseToFine::start_wave(const DrawnPixels& pixels, size_t begin, size_t end,
                              Wave& wave) const {
  wave.camera = true;
  wave.resize(end);
  parallel_for(end - begin, kChunk, [&](size_t chunk_begin, size_t chunk_end) {
    for (size_t i = begin + chunk_begin; i < begin + chunk_end; ++i) {
      wave.rays[i] = pixels.ray(order_[i] % width_, order_[i] / width_, vec2(0.5f));
      wave.paths[i] = Path{.pixel = order_[i], .cone = pixels.cone()};
    }
  });
}

void CoarseToFine::fill(size_t drawn, Image& image) const {
  uint32_t step = kCoarsest;
  size_t begin = 0;
  for (const size_t end : level_end_) {
    const uint32_t coarse = 2 * step;
    parallel_for(end - std::clamp(drawn, begin, end), kChunk, [&](size_t from, size_t to) {
      for (size_t i = end - to; i < end - from; ++i) {
        const uint32_t x = order_[i] % width_, y = order_[i] / width_;
        const uint32_t x0 = x - x % coarse, y0 = y - y % coarse;
        const uint32_t x1 = x == x0 || x0 + coarse >= width_ ? x0 : x0 + coarse;
        const uint32_t y1 = y == y0 || y0 + coarse >= height_ ? y0 : y0 + coarse;
        const auto at = [&](uint32_t px, uint32_t py) {
          return image.pixels[size_t{py} * width_ + px];
        };
        image.pixels[order_[i]] = 0.25f * (at(x0, y0) + at(x1, y0) + at(x0, y1) + at(x1, y1));
      }
    });
    begin = end;
    step /= 2;
  }
}

void upsample(Image& drawn, uint32_t step, Image& out) {
  parallel_for(drawn.pixels.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) drawn.pixels[i] = compress(drawn.pixels[i]);
  });
  parallel_for(out.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const Between row = place_between(y, drawn.height, step);
      const vec4* low = &drawn.pixels[size_t{row.low} * drawn.width];
      const vec4* high = &drawn.pixels[size_t{row.high} * drawn.width];
      vec4* to = &out.pixels[y * out.width];
      for (uint32_t x = 0; x < out.width; ++x) {
        const auto [left, right, fraction] = place_between(x, drawn.width, step);
        to[x] = expand(mix(mix(low[left], low[right], fraction),
                           mix(high[left], high[right], fraction), row.fraction));
      }
    }
  });
}

}  // namespace sinew
