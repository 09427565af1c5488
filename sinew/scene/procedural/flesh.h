// Flesh on bones: round cones, blended into one implicit surface, and the skin weights that follow
// from how near each bone's flesh is.
// Based on: J. Bloomenthal, K. Shoemake, "Convolution Surfaces", 1991 (bodies from skeletons);
// I. Quilez, "Smooth minimum", 2013 (the blend).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/math/box.h"
#include "sinew/math/vec.h"

namespace sinew {

// Quadratic smooth minimum: exactly the minimum where the two differ by `blend` or more.
float smooth_min(float a, float b, float blend);
float smooth_max(float a, float b, float blend);

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

// How skin weights fade from joint to joint.
struct SkinConfig {
  float softness = 0.36f;       // of the fading, in radii of a joint's flesh
  float most_softness = 0.16f;  // the radius that counts is at most this
  float limb_margin = 0.0f;  // metres by which a limb must be nearer than any other to count fully
};

class FleshBody {
 public:
  static constexpr int8_t kTrunk = -1;

  FleshBody() = default;
  // At most 255 pieces of flesh. `limbs`: for every joint the number of the limb it belongs to, or
  // kTrunk; a vertex follows the joints of one limb only.
  FleshBody(std::vector<Flesh> flesh, std::vector<int8_t> limbs, const SkinConfig& skin = {});

  const Box& box() const { return box_; }  // contains the surface
  float field(vec3 p) const;               // negative inside, nearly a distance outside
  SkinWeights skin_weights(vec3 p) const;
  uint32_t nearest(vec3 p) const;  // the piece of flesh

 private:
  void fill_grid();
  float blend_all(vec3 p, std::span<const uint8_t> pieces) const;
  struct NearestLimb {
    int8_t limb = kTrunk;
    float share = 1.0f;  // how fully it counts
  };
  NearestLimb nearest_limb(std::span<const float> distances) const;

  std::vector<Flesh> flesh_;
  std::vector<int8_t> limbs_;
  SkinConfig skin_;
  // Cells of a coarse grid over the box list the flesh that matters inside them, in order.
  Box box_;
  std::vector<uint32_t> cell_start_;  // one more than there are cells
  std::vector<uint8_t> cell_flesh_;
  std::vector<uint8_t> all_flesh_;
};

}  // namespace sinew
