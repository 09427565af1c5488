// FrameBoxes: where all primitives are in the representative frames of an animation, and what a
// tree costs over them. Based on: J. Bittner, D. Meister, "T-SAH: Animation Optimized Bounding
// Volume Hierarchies", 2015 (T), section 4. Names are T's: C_i is the cost in frame i, w_i its
// weight, k the exponent.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/cost.h"
#include "sinew/bvh/tree.h"
#include "sinew/math/box.h"

namespace sinew {

struct FrameBoxes {
  std::vector<std::vector<Box>> frames;  // [frame][primitive]; all finite, none empty
  std::vector<double> weights;           // of the frames, by the time that they stand for; sum 1

  uint32_t frame_count() const { return static_cast<uint32_t>(frames.size()); }
  uint32_t primitive_count() const {
    return frames.empty() ? 0 : static_cast<uint32_t>(frames.front().size());
  }
};

// Whether a box may stand in FrameBoxes.
inline bool is_there(const Box& box) {
  return !box.empty() && is_finite(box);
}

// Gives every frame the same weight. A box that is not finite, or empty, becomes that of the
// nearest frame where it is; a primitive that never is becomes a point in the middle of the others.
FrameBoxes make_frame_boxes(std::vector<std::vector<Box>> frames);

// C_i of every frame: equation 1 with the model's c_T and c_I; 0 where the root has no area.
std::vector<double> frame_costs(const Tree& tree, const FrameBoxes& frames,
                                const CostModel& model = {});

// Equation 3 with weights by time: sum v_i C_i^(k+1) / sum v_i C_i^k. 0 if all costs are.
double tsah_cost(std::span<const double> costs, std::span<const double> weights, double exponent);

// What the product minimises: (sum v_i C_i^(k+1))^(1/(k+1)), a power mean, in the units of a cost.
// Unlike tsah_cost it never falls when a frame's cost rises.
double power_cost(std::span<const double> costs, std::span<const double> weights, double exponent);

// g_i = v_i C_i^k / S(t_i), normalised to sum 1: how much an area in frame i counts when a tree
// whose frames cost `costs` is improved. 0 for frames whose root has no area.
std::vector<double> area_weights(const Tree& tree, const FrameBoxes& frames,
                                 std::span<const double> costs, double exponent);

// sum_i g_i * half area in frame i, of every node: orders the children of eight-wide nodes.
std::vector<float> weighted_areas(const Tree& tree, const FrameBoxes& frames,
                                  std::span<const double> g);

}  // namespace sinew
