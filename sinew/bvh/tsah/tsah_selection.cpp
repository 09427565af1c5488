#include "sinew/bvh/tsah/tsah_selection.h"

#include <algorithm>

namespace sinew {

void NodeSelector::start_batch(std::span<const double> weights, uint32_t size) {
  if (selection_ != TsahSelection::sorted_batch) return;
  sorted_.clear();
  for (uint32_t n = 0; n < tree_.node_count(); ++n) {
    if (movable(n)) sorted_.emplace_back(contribution(tree_.boxes(n), weights), n);
  }
  if (sorted_.size() > size) {
    const auto first = sorted_.end() - size;
    std::nth_element(sorted_.begin(), first, sorted_.end());
    sorted_.erase(sorted_.begin(), first);
  }
  std::sort(sorted_.begin(), sorted_.end());
}

uint32_t NodeSelector::next(std::span<const double> weights) {
  if (selection_ == TsahSelection::random) return draw();
  if (selection_ == TsahSelection::metropolis_hastings) return next_of_chain(weights);
  while (!sorted_.empty()) {
    const uint32_t node = sorted_.back().second;
    sorted_.pop_back();
    if (movable(node)) return node;  // an earlier move may have made it the root
  }
  return MovableTree::kNone;
}

bool NodeSelector::batch_ended(uint32_t without_gain) {
  if (selection_ != TsahSelection::sorted_batch || config_.random_after == 0) return false;
  if (without_gain < config_.random_after) return false;
  selection_ = TsahSelection::random;
  return true;
}

uint32_t NodeSelector::draw() {
  for (;;) {
    const auto node = static_cast<uint32_t>((uint64_t{random_.next()} * tree_.node_count()) >> 32);
    if (movable(node)) return node;
  }
}

uint32_t NodeSelector::next_of_chain(std::span<const double> weights) {
  if (accepted_ == MovableTree::kNone) return accepted_ = draw();
  const double before = contribution(tree_.boxes(accepted_), weights);
  uint32_t node = draw();
  for (uint64_t tries = 4 * uint64_t{tree_.node_count()}; tries > 0; --tries) {
    const double ratio = contribution(tree_.boxes(node), weights) / before;
    // Where nothing has an area the ratio is no number, and any node will do.
    if (node != accepted_ && !(random_.uniform() >= ratio)) break;
    node = draw();
  }
  return accepted_ = node;
}

}  // namespace sinew
