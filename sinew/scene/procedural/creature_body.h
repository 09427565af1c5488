// The creature's flesh: round cones along its bones, blended into one implicit surface, and the
// skin weights that follow from how near each bone's flesh is.
// Based on: J. Bloomenthal, K. Shoemake, "Convolution Surfaces", 1991 (bodies from skeletons);
// I. Quilez, "Smooth minimum", 2013 (the blend).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/math/vec.h"

namespace sinew {

// The spheres with centres from a to b whose radii go from radius_a to radius_b.
struct RoundCone {
  vec3 a{0.0f};
  float radius_a = 0.1f;
  vec3 b{0.0f};
  float radius_b = 0.1f;

  float distance(vec3 p) const;  // signed, exact
};

struct Flesh {
  uint32_t joint = 0;
  RoundCone shape;
  float blend = 0.0f;  // metres over which it melts into the flesh before it
};

struct SkinWeights {
  static constexpr uint32_t kInfluences = 4;
  std::array<uint16_t, kInfluences> joints{};
  std::array<float, kInfluences> weights{};  // sum to 1
};

class CreatureBody {
 public:
  CreatureBody();

  Box box() const;            // contains the surface
  float field(vec3 p) const;  // negative inside, nearly a distance outside
  SkinWeights skin_weights(vec3 p) const;

  // The point of the surface that a ray from inside the body leaves by.
  vec3 leave(vec3 inside, vec3 direction) const;

 private:
  void add(uint32_t joint, RoundCone shape, float blend);
  void add_trunk();
  void add_head();
  void add_leg(uint32_t leg);
  void fill_grid();
  float blend_all(vec3 p, const uint8_t* first, const uint8_t* last) const;

  std::vector<Flesh> flesh_;
  // Cells of a coarse grid over the box list the flesh that matters inside them, in order.
  Box grid_box_;
  std::vector<uint32_t> cell_start_;  // one more than there are cells
  std::vector<uint8_t> cell_flesh_;
  std::vector<uint8_t> all_flesh_;
};

}  // namespace sinew
