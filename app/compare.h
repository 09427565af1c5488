// What `sinew compare` is asked to do, and what it finds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/image_exr.h"
#include "sinew/io/image_file.h"

namespace sinew::app {

struct CompareJob {
  std::string first, second;
  std::string layer;                      // of .exr files; empty or "color": the picture
  std::optional<double> least_psnr;       // dB
  std::optional<double> most_flip;        // 0..1, of the mean
  std::optional<double> most_difference;  // of any channel: 0..1, or in the layer's unit
  std::optional<uint64_t> most_pixels;
  std::optional<double> tolerance;  // of pixels that count: of 255 (default 2), or in the layer's
                                    // unit (default 0)
  double pixels_per_degree = 67.0;
  double exposure = 0.0;   // of .exr pictures, stops
  std::string difference;  // a .png to be written; empty: none
  bool json = false;

  bool of_layer() const { return !layer.empty() && layer != "color"; }
  double tolerance_or_default() const { return tolerance.value_or(of_layer() ? 0.0 : 2.0); }
};

// Of pictures of two sizes only the sizes are known.
struct Comparison {
  ImageSize first_size, second_size;
  std::optional<double> psnr, flip, largest_flip;  // of pictures
  double mean = 0.0, largest = 0.0;                // absolute differences
  uint64_t pixels_over = 0;
  Image8 difference;  // if the job wants it

  bool same_size() const {
    return first_size.width == second_size.width && first_size.height == second_size.height;
  }
};

Result<Comparison> compare_pictures(const CompareJob& job);  // finished or linear ones
Result<Comparison> compare_layers(const CompareJob& job);

}  // namespace sinew::app
