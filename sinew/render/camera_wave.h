// Which pixels an image is drawn in, and in which order: tile by tile, or coarse to fine.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sinew/render/camera.h"
#include "sinew/render/wave.h"
#include "sinew/scene/image.h"

namespace sinew {

inline constexpr uint32_t kTile = 16;  // pixels; within a tile they follow Morton's order

// The tiles of an image, row by row. Those at the right and lower edge may be smaller.
struct TileGrid {
  uint32_t width, height;
  uint32_t columns = (width + kTile - 1) / kTile;
  uint32_t rows = (height + kTile - 1) / kTile;

  uint32_t count() const { return columns * rows; }
  // Pixels in the tiles before `tile`.
  size_t first_pixel(uint32_t tile) const {
    const uint32_t row = tile / columns, column = tile % columns;
    const size_t above = size_t{width} * std::min(row * kTile, height);
    const size_t tile_height = std::min(kTile, height - std::min(row * kTile, height));
    return above + std::min(column * kTile, width) * tile_height;
  }
};

// Camera rays through the drawn pixels of an image, each of which stands for `step` x `step` of the
// finished one.
struct DrawnPixels {
  CameraRays rays;
  TileGrid grid;
  float step = 1.0f;
  float share = 1.0f;  // of the pixel's width that one ray stands for

  RayCone cone() const {
    return {step * share * rays.pixel_width(), step * share * rays.pixel_spread()};
  }
  Ray ray(uint32_t x, uint32_t y, vec2 offset) const {
    return rays(step * (static_cast<float>(x) + offset.x),
                step * (static_cast<float>(y) + offset.y));
  }
};

// One camera ray through each pixel of the tiles [first, last), at `offset` (0..1) in it.
void start_wave(const DrawnPixels& pixels, uint32_t first, uint32_t last, vec2 offset, Wave& wave);

// All pixels of an image, those of coarser lattices first: every 8th of every 8th row, then what is
// missing of every 4th, every 2nd, all.
class CoarseToFine {
 public:
  void resize(uint32_t width, uint32_t height);

  size_t count() const { return order_.size(); }
  size_t coarsest() const { return level_end_[0]; }  // pixels of the coarsest lattice

  // Puts rays through the pixels [begin, end) of the order, at their centres, into the wave.
  void start_wave(const DrawnPixels& pixels, size_t begin, size_t end, Wave& wave) const;
  // Fills the pixels from `drawn` on from those of the next coarser lattice.
  void fill(size_t drawn, Image& image) const;

 private:
  static constexpr uint32_t kCoarsest = 8;  // pixels
  uint32_t width_ = 0, height_ = 0;
  std::vector<uint32_t> order_;  // y * width + x
  std::vector<size_t> level_end_;
};

// Interpolates bilinearly between the drawn pixels, each of which stands at the centre of a square
// of `step` x `step`; `out` has its size already. Beyond the outermost centres the image goes on
// unchanged. Spoils `drawn`.
void upsample(Image& drawn, uint32_t step, Image& out);

}  // namespace sinew
