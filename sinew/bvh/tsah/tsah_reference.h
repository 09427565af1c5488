// T-SAH as published: one tree for an animation by moving nodes of the first frame's tree, with one
// thread and no SIMD. The slow twin of optimize.h, which tests and benches compare it with.
// Based on: J. Bittner, D. Meister, "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015
// (T), sections 4 and 5; J. Bittner, M. Hapala, V. Havran, "Fast Insertion-Based Optimization of
// Bounding Volume Hierarchies", 2013 (BHH13).
//
//   weights w_i = C_i^k
//   repeat a batch (2% of the nodes):
//     repeat: select a node, take it out, put it at the position with the least cost (eq. 2)
//     weights w_i = C_i^k
//   until three batches in a row have not lowered the cost (eq. 3)
//
// What T leaves open, and what is done here:
// - Which nodes move. T speaks of "removing a node from the BVH and reinserting it back" and leaves
//   the rest to BHH13, which dissolves an inner node and its parent and puts the node's two
//   children back one by one, the larger first. That is TsahMove::children, the default: with it
//   Metropolis-Hastings beats random selection, and some fifty batches suffice, as T reports.
//   TsahMove::node moves any node but the root as a whole. It takes several times the batches,
//   often ends lower on moderate animations, and with Metropolis-Hastings on scattering ones may
//   not end well at all, since large nodes as a whole have nowhere to go.
// - "A position reducing the global tree cost": what finds no cheaper position than where it was
//   stays there, so with TsahMove::node no move raises the cost. Children are put back one after
//   the other, so both together may cost more than before; that is kept, as in BHH13.
// - Cost vectors have areas as components. Evaluated by eq. 2 these are divided by the root's area
//   in their frame, as C_i is. The contribution Delta_N, used for selection only, is as printed,
//   without that division.
// - w_i is multiplied by the frame's weight of FrameBoxes; T's frames all weigh the same.
// - "No reduction of the cost" is measured by eq. 3 against the least so far. The tree with the
//   least cost is returned, which need not be the last one.
// - Metropolis-Hastings: the chain goes on over batches; after 4 proposals per node of the tree
//   without another node accepted the last one proposed is taken.
// - Sorted batch: priorities are taken at the start of a batch. random_after turns to random
//   selection, as T's figure 3 does "after couple of initial optimization passes".
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sinew/bvh/frames/frames.h"
#include "sinew/bvh/tree.h"

namespace sinew {

enum class TsahSelection : uint8_t {
  metropolis_hastings,  // in proportion to Delta_N, roughly; T's choice
  sorted_batch,         // those with the highest Delta_N (BHH13)
  random,
};

enum class TsahMove : uint8_t {
  node,      // a node moves as it is (T's words)
  children,  // an inner node is dissolved, its children are put back one by one (BHH13)
};

struct TsahStep {
  double seconds = 0.0;       // since the start
  uint32_t batch = 0;         // batches done; 0: the tree at the start
  uint64_t moved = 0;         // nodes that found a better position, so far
  std::vector<double> costs;  // C_i of every frame
  double cost = 0.0;          // T-SAH cost, equation 3
};

struct TsahConfig {
  double exponent = 0.0;  // k, at least 0; T: 0, 2, 4
  TsahSelection selection = TsahSelection::metropolis_hastings;
  TsahMove move = TsahMove::children;
  double batch = 0.02;        // of the nodes of the tree; at least one node
  uint32_t patience = 3;      // batches without gain before the end
  double least_gain = 0.0;    // of the cost; a batch that wins no more has not reduced it
  uint32_t random_after = 0;  // sorted batches without gain before random selection; 0: never
  uint32_t seed = 1;
  CostModel cost{};
  // Called at the start and after each batch; returning false ends the optimisation with the best
  // tree so far.
  std::function<bool(const TsahStep&)> on_batch{};
};

// Improves a tree that has one primitive a leaf. The result is never dearer by equation 3, has one
// primitive a leaf and nodes in depth-first order. An empty tree stays empty.
Tree optimize_tsah(const Tree& start, const FrameBoxes& frames, const TsahConfig& config = {});

// T's whole construction but for the leaves (collapse_leaves): full-sweep SAH over the first frame
// with one primitive a leaf, then optimize_tsah().
Tree build_tsah(const FrameBoxes& frames, const TsahConfig& config = {});

// BHH13 itself: the same with a single frame, where exponents make no difference. Boxes must be
// finite and not empty.
Tree optimize_insertion(const Tree& start, std::span<const Box> boxes,
                        const TsahConfig& config = {});

// Delta_N = sum_i w_i S_N(t_i): what a node adds to the cost (T, section 5.2), with half areas.
// boxes: of the node, one a frame.
double contribution(std::span<const Box> boxes, std::span<const double> weights);

}  // namespace sinew
