// A square of cloth that falls onto a ball and the ground.
// Based on: M. Muller, B. Heidelberger, M. Hennix, J. Ratcliff, "Position Based Dynamics", 2007;
// T. Jakobsen, "Advanced Character Physics", 2001 (links without square roots); M. Macklin et al.,
// "Small Steps in Physics Simulation", 2019 (many steps of one iteration each); M. Muller,
// "Hierarchical Position Based Dynamics", 2008 (coarse grids, so that fine cloth does not stretch).
#pragma once

#include <cstdint>
#include <vector>

#include "sinew/math/vec.h"

namespace sinew {

struct ClothConfig {
  uint32_t cells = 215;  // a side, at least 4
  float width = 2.4f;    // metres a side
  uint32_t frames = 94;
  double fps = 25.0;
  uint32_t steps = 12;        // a frame
  uint32_t sweeps = 2;        // over all links, a step
  uint32_t search_every = 6;  // steps from one search for parts of the cloth that meet to the next

  vec3 start{0.0f, 1.5f, 0.0f};  // of the middle
  float turn = 0.0f;             // radians around +Y
  float tilt = 0.0f;             // radians around +Z
  float ripple = 0.01f;          // metres, of the unevenness at the start

  vec3 ball{0.0f, 0.6f, 0.0f};
  float ball_radius = 0.6f;
  float clearance = 0.006f;  // between the cloth and what it lies on, metres

  float ball_friction = 0.14f;  // Coulomb's coefficients
  float ground_friction = 0.9f;
  float cloth_friction = 0.3f;  // share of the sliding of two layers that a step takes away
  float drag = 2.0f;            // share of the speed that air takes away, a second
  float shear = 0.6f;           // share of an error that a step corrects, 0 to 1
  float bend = 0.08f;           // the same, for links over two cells
};

// Positions of the (cells + 1)^2 vertices, row by row, at the frames + 1 times n / fps; key-major.
// The same bits for every thread count.
std::vector<vec3> simulate_cloth(const ClothConfig& config);

}  // namespace sinew
