#include "sinew/bvh/tsah/tsah_search.h"

#include <algorithm>
#include <numeric>

namespace sinew {
namespace {

double area_of_union(const Box& a, const Box& b) {
  Box both = a;
  both.extend(b);
  return exact_half_area(both);
}

}  // namespace

std::vector<double> area_factors(const MovableTree& tree, std::span<const double> weights,
                                 float traversal_cost) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> factors(weights.size(), 0.0);
  for (size_t f = 0; f < weights.size(); ++f) {
    const double area = exact_half_area(tree.boxes(tree.root())[f]);
    if (area > 0.0 && sum > 0.0) factors[f] = traversal_cost * (weights[f] / sum) / area;
  }
  return factors;
}

double evaluate_areas(std::span<const double> areas, std::span<const double> factors) {
  return std::inner_product(areas.begin(), areas.end(), factors.begin(), 0.0);
}

double InsertionSearch::cost_at(const MovableTree& tree, std::span<const double> factors,
                                uint32_t node, uint32_t at) const {
  const std::span<const Box> own = tree.boxes(node);
  double cost = 0.0;
  for (size_t f = 0; f < own.size(); ++f) {
    cost += factors[f] * area_of_union(tree.boxes(at)[f], own[f]);
  }
  for (uint32_t n = tree.parent(at); n != MovableTree::kNone; n = tree.parent(n)) {
    const std::span<const Box> boxes = tree.boxes(n);
    for (size_t f = 0; f < own.size(); ++f) {
      cost += factors[f] * (area_of_union(boxes[f], own[f]) - exact_half_area(boxes[f]));
    }
  }
  return cost;
}

InsertPosition InsertionSearch::find(const MovableTree& tree, std::span<const double> factors,
                                     uint32_t node, InsertPosition known) {
  const std::span<const Box> own = tree.boxes(node);
  const size_t frames = own.size();
  direct_.resize(frames);
  for (size_t f = 0; f < frames; ++f) direct_[f] = exact_half_area(own[f]);
  const double own_cost = evaluate_areas(direct_, factors);  // no new parent is smaller

  InsertPosition best = known;
  queue_.clear();
  induced_.assign(frames, 0.0);
  push({0.0, tree.root(), 0});
  while (!queue_.empty()) {
    const Entry entry = pop();
    if (entry.induced + own_cost >= best.cost) break;
    ++visited_;
    const auto below = static_cast<uint32_t>(induced_.size());
    induced_.resize(below + frames);
    const std::span<const Box> boxes = tree.boxes(entry.node);
    for (size_t f = 0; f < frames; ++f) {
      direct_[f] = area_of_union(boxes[f], own[f]);
      induced_[below + f] = induced_[entry.vector + f] + (direct_[f] - exact_half_area(boxes[f]));
    }
    const double cost = entry.induced + evaluate_areas(direct_, factors);
    if (cost < best.cost) best = {entry.node, cost};
    const double induced_below = evaluate_areas({induced_.data() + below, frames}, factors);
    if (tree.is_leaf(entry.node) || induced_below + own_cost >= best.cost) {
      induced_.resize(below);
      continue;
    }
    push({induced_below, tree.child(entry.node, 0), below});
    push({induced_below, tree.child(entry.node, 1), below});
  }
  return best;
}

void InsertionSearch::push(const Entry& entry) {
  queue_.push_back(entry);
  std::push_heap(queue_.begin(), queue_.end());
}

InsertionSearch::Entry InsertionSearch::pop() {
  std::pop_heap(queue_.begin(), queue_.end());
  const Entry entry = queue_.back();
  queue_.pop_back();
  return entry;
}

}  // namespace sinew
