// Which node is moved next (T-SAH, section 5.2): Metropolis-Hastings, sorted batch, or random.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/tsah/tsah_reference.h"
#include "sinew/bvh/tsah/tsah_tree.h"
#include "sinew/math/random.h"

namespace sinew {

class NodeSelector {
 public:
  // Keeps a reference to the tree, which changes between calls.
  NodeSelector(const MovableTree& tree, const TsahConfig& config)
      : tree_(tree), config_(config), selection_(config.selection), random_(config.seed) {}

  // Whether there is a node that may be moved, and another place for it.
  bool can_select() const { return tree_.node_count() > 3; }

  void start_batch(std::span<const double> weights, uint32_t size);

  // The next node of the batch, movable as the tree is now; kNone: the batch has no more.
  uint32_t next(std::span<const double> weights);

  // Whether the selection turned to random now, because too many batches were without gain.
  bool batch_ended(uint32_t without_gain);

 private:
  bool movable(uint32_t node) const {
    const bool whole = config_.move == TsahMove::node;
    return node != tree_.root() && (whole || !tree_.is_leaf(node));
  }
  uint32_t draw();
  uint32_t next_of_chain(std::span<const double> weights);

  const MovableTree& tree_;
  const TsahConfig& config_;
  TsahSelection selection_;
  Random random_;
  uint32_t accepted_ = MovableTree::kNone;           // state of the Metropolis-Hastings chain
  std::vector<std::pair<double, uint32_t>> sorted_;  // Delta_N and node, the highest last
};

}  // namespace sinew
