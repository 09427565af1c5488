// FLIP: how large the difference looks when one flips between two pictures.
#pragma once

#include <vector>

#include "sinew/base/error.h"
#include "sinew/scene/image.h"

namespace sinew {

struct FlipConfig {
  // How finely the viewer sees the picture. 67: a screen 0.7 m wide of 3840 pixels, 0.7 m away.
  // From 1 to 1000.
  float pixels_per_degree = 67.0f;
};

// The error at every pixel, 0 (none) to 1, rows from the top. Colours are laid over black by their
// alpha. Symmetric in the two pictures up to rounding. See check_same_size.
Result<std::vector<float>> flip_errors(const Image8& a, const Image8& b,
                                       const FlipConfig& config = {});

// The mean of the errors, which is what papers state; 0 for none.
double mean_error(const std::vector<float>& errors);

}  // namespace sinew
