#include "sinew/bvh/builders/collapse.h"

namespace sinew {

void WideCollapse::add_inner(uint32_t node, float area) {
  const uint32_t left = tree_.nodes[node].left(), right = tree_.nodes[node].right();
  Subtree& own = subtrees_[node];
  for (uint32_t children = 2; children <= kWidth; ++children) {
    float& least = own.cost[children - 1];
    for (uint32_t of_left = 1; of_left < children; ++of_left) {
      const float cost = cost_of(left, of_left) + cost_of(right, children - of_left);
      if (of_left > 1 && !(cost < least)) continue;
      least = cost;
      own.left[children - 1] = static_cast<uint8_t>(of_left);
    }
  }
  own.cost[0] = area + own.cost[kWidth - 1];
  for (uint32_t i = 1; i + 1 < kWidth; ++i) {
    if (own.cost[i] < own.cost[0]) continue;
    own.cost[i] = own.cost[0];
    own.left[i] = 0;
  }
}

WideChildren WideCollapse::children_of(uint32_t node) const {
  WideChildren out;
  const uint32_t of_left = subtrees_[node].left[kWidth - 1];
  collect(tree_.nodes[node].left(), of_left, out);
  collect(tree_.nodes[node].right(), kWidth - of_left, out);
  return out;
}

void WideCollapse::collect(uint32_t node, uint32_t children, WideChildren& out) const {
  const Subtree& subtree = subtrees_[node];
  const uint32_t of_left = subtree.closed ? 0 : subtree.left[children - 1];
  if (of_left == 0) return out.add(node);
  collect(tree_.nodes[node].left(), of_left, out);
  collect(tree_.nodes[node].right(), children - of_left, out);
}

}  // namespace sinew
