// Where in a tree a node is best put: branch and bound over all positions, with cost vectors.
// Based on: J. Bittner, D. Meister, "T-SAH", 2015, section 5.1; J. Bittner, M. Hapala, V. Havran,
// "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", 2013, section 3.
//
// Put at a node X, a node N gets a new parent of both in X's place:
//   direct cost   the areas of the new parent's boxes, one component a frame
//   induced cost  by how much the areas of all nodes above grow, likewise
// Both are evaluated by equation 2 with weights that stay as they are during a batch.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/bvh/tsah/tsah_tree.h"

namespace sinew {

// c_T * w_i / (S(t_i) * sum w): what a unit of inner area in frame i adds to equation 2. S is the
// area of the whole tree's root, half as all areas here; 0 where it has none.
std::vector<double> area_factors(const MovableTree& tree, std::span<const double> weights,
                                 float traversal_cost);

// A cost vector, evaluated.
double evaluate_areas(std::span<const double> areas, std::span<const double> factors);

struct InsertPosition {
  uint32_t at = MovableTree::kNone;
  double cost = 0.0;  // induced and direct: what the insertion adds to equation 2
};

class InsertionSearch {
 public:
  // What it costs to put the removed `node` at `at`.
  double cost_at(const MovableTree& tree, std::span<const double> factors, uint32_t node,
                 uint32_t at) const;

  // The cheapest position for the removed `node`; `known` unless one is cheaper.
  InsertPosition find(const MovableTree& tree, std::span<const double> factors, uint32_t node,
                      InsertPosition known);

  // Nodes looked at by all searches so far.
  uint64_t visited() const { return visited_; }

 private:
  struct Entry {
    double induced;  // evaluated: a lower bound but for the direct cost
    uint32_t node;
    uint32_t vector;  // its induced costs start at this of induced_

    // Later in the queue. Equal costs leave it in an order of their own, whatever the heap does.
    bool operator<(const Entry& o) const {
      if (induced != o.induced) return induced > o.induced;
      return vector != o.vector ? vector > o.vector : node > o.node;
    }
  };
  void push(const Entry& entry);
  Entry pop();

  std::vector<Entry> queue_;     // a heap, the least induced cost on top
  std::vector<double> induced_;  // vectors of induced costs, shared by two siblings
  std::vector<double> direct_;   // the vector of the node looked at
  uint64_t visited_ = 0;
};

}  // namespace sinew
