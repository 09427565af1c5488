// T-SAH as published: its formulas by hand, the search against brute force, and what the optimiser
// must keep.
#include "sinew/bvh/tsah/tsah_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/tsah/tsah_search.h"
#include "sinew/bvh/tsah/tsah_tree.h"
#include "sinew/math/random.h"
#include "tree_checks.h"

namespace sinew {
namespace {

constexpr TsahSelection kSelections[] = {TsahSelection::metropolis_hastings,
                                         TsahSelection::sorted_batch, TsahSelection::random};
constexpr TsahMove kMoves[] = {TsahMove::node, TsahMove::children};

// From x = a to b, one unit wide and high: half area 2 (b - a) + 1.
Box bar(float a, float b) {
  return {vec3(a, 0, 0), vec3(b, 1, 1)};
}

// Three unit cubes A, B, C; in the second frame B has left A for C.
//   frame 0  A[0,1] B[1,2]                     C[9,10]
//   frame 1  A[0,1]               B[7,8]       C[9,10]
FrameBoxes three_cubes() {
  return make_frame_boxes({{bar(0, 1), bar(1, 2), bar(9, 10)}, {bar(0, 1), bar(7, 8), bar(9, 10)}});
}

// ((A B) C): nodes 0 root, 1 AB, 2 A, 3 B, 4 C.
Tree tree_of_three() {
  Tree tree;
  tree.nodes = {TreeNode::inner(1, 4), TreeNode::inner(2, 3), TreeNode::leaf(0, 1),
                TreeNode::leaf(1, 1), TreeNode::leaf(2, 1)};
  tree.primitives = {0, 1, 2};
  return tree;
}

FrameBoxes random_frames(uint32_t seed, uint32_t primitives, uint32_t frames) {
  Random random(seed);
  std::vector<std::vector<Box>> boxes(frames);
  for (std::vector<Box>& frame : boxes) {
    for (uint32_t p = 0; p < primitives; ++p) {
      const vec3 low = random.uniform3(0.0f, 1.0f);
      const vec3 extent = random.uniform3(0.0f, 0.2f);
      frame.push_back({low, low + extent});
    }
  }
  return make_frame_boxes(std::move(boxes));
}

Tree deep_tree(const FrameBoxes& frames) {
  return build_sweep(frames.frames.front(), {.leaf_block = 1, .max_leaf = 1});
}

double cost_of(const Tree& tree, const FrameBoxes& frames, double exponent) {
  return tsah_cost(frame_costs(tree, frames), frames.weights, exponent);
}

TEST(TsahByHand, CostsAndContribution) {
  // Root [0,10]: 21 in both frames. AB: [0,2] 5, then [0,8] 17. Leaves: 3 each.
  //   C_0 = (3 (21 + 5) + 2 * 9) / 21 = 96/21,  C_1 = (3 (21 + 17) + 2 * 9) / 21 = 132/21
  const FrameBoxes frames = three_cubes();
  const MovableTree tree(tree_of_three(), frames);
  const std::vector<double> costs = tree.costs({});
  EXPECT_NEAR(costs[0], 96.0 / 21, 1e-12);
  EXPECT_NEAR(costs[1], 132.0 / 21, 1e-12);
  // k = 0: (96 + 132) / 42.
  // k = 2, with 96 = 12 * 8 and 132 = 12 * 11: 12 (8^3 + 11^3) / (21 (8^2 + 11^2)).
  EXPECT_NEAR(tsah_cost(costs, frames.weights, 0), 38.0 / 7, 1e-12);
  EXPECT_NEAR(tsah_cost(costs, frames.weights, 2), 12.0 * 1843 / (21 * 185), 1e-12);
  // Delta of AB, k = 0: 5 + 17. k = 2: (96/21)^2 * 5 + (132/21)^2 * 17.
  EXPECT_NEAR(contribution(tree.boxes(1), std::vector<double>{1, 1}), 22.0, 1e-12);
  const std::vector<double> weights = {costs[0] * costs[0], costs[1] * costs[1]};
  EXPECT_NEAR(contribution(tree.boxes(1), weights), (1024.0 * 5 + 1936.0 * 17) / 49, 1e-9);
}

TEST(TsahByHand, TheExponentDecidesWhereANodeBelongs) {
  // B is taken out of ((A B) C); left is (A C), with root [0,10] in both frames.
  //   at A: [0,2] 5 and [0,8] 17;  at C: [1,10] 19 and [7,10] 7;  at the root: 21 and 21
  // The root grows nowhere, so no cost is induced. k = 0: factors 3 * (1/2) / 21 = 1/14:
  //   A 22/14, C 26/14, root 42/14: B stays with A.
  // k = 2: w = 64 : 121, factors 3 * (64/185) / 21 = 64/1295 and 121/1295:
  //   A (64 * 5 + 121 * 17) / 1295 = 2377/1295, C (64 * 19 + 121 * 7) / 1295 = 2063/1295.
  const FrameBoxes frames = three_cubes();
  MovableTree tree(tree_of_three(), frames);
  InsertionSearch search;
  const std::vector<double> equal = area_factors(tree, std::vector<double>{1, 1}, 3.0f);
  const std::vector<double> squares = area_factors(tree, std::vector<double>{64, 121}, 3.0f);
  EXPECT_EQ(tree.remove(3), 1u);
  EXPECT_EQ(tree.parent(2), 0u);
  EXPECT_NEAR(search.cost_at(tree, equal, 3, 2), 22.0 / 14, 1e-12);
  EXPECT_NEAR(search.cost_at(tree, equal, 3, 4), 26.0 / 14, 1e-12);
  EXPECT_NEAR(search.cost_at(tree, equal, 3, 0), 42.0 / 14, 1e-12);
  const InsertPosition nothing_known{MovableTree::kNone, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(search.find(tree, equal, 3, nothing_known).at, 2u);
  const InsertPosition best = search.find(tree, squares, 3, nothing_known);
  EXPECT_EQ(best.at, 4u);
  EXPECT_NEAR(best.cost, 2063.0 / 1295, 1e-12);
  // Then BC is [1,10] 19 and [7,10] 7: C_0 = (3 (21 + 19) + 18) / 21, C_1 = (3 (21 + 7) + 18) / 21.
  tree.insert(3, best.at, 1);
  EXPECT_NEAR(tree.costs({})[0], 138.0 / 21, 1e-12);
  EXPECT_NEAR(tree.costs({})[1], 102.0 / 21, 1e-12);
}

TEST(TsahByHand, DirectAndInducedCosts) {
  // B is put into ((A D) C): A[0,1] D[2,3] C[9,10]; B is [4,5], then [1,2]. Factors are 1/14.
  //   at      direct                   induced                                 sum
  //   root    [0,10] 21, 21            -                                       42
  //   AD      [0,5] 11, [0,3] 7        root 0, 0                               18
  //   A       [0,5] 11, [0,2] 5        AD 7 -> [0,5] 11: 4, 0                  20
  //   D       [2,5] 7, [1,3] 5         AD 4, 0                                 16   the best
  //   C       [4,10] 13, [1,10] 19     root 0, 0                               32
  const FrameBoxes frames = make_frame_boxes({{bar(0, 1), bar(2, 3), bar(9, 10), bar(4, 5)},
                                              {bar(0, 1), bar(2, 3), bar(9, 10), bar(1, 2)}});
  Tree start;  // (((A D) C) B): 0 root, 1 ADC, 2 AD, 3 A, 4 D, 5 C, 6 B
  start.nodes = {TreeNode::inner(1, 6), TreeNode::inner(2, 5), TreeNode::inner(3, 4),
                 TreeNode::leaf(0, 1),  TreeNode::leaf(1, 1),  TreeNode::leaf(2, 1),
                 TreeNode::leaf(3, 1)};
  start.primitives = {0, 1, 2, 3};
  MovableTree tree(start, frames);
  const std::vector<double> factors = area_factors(tree, frames.weights, 3.0f);
  EXPECT_EQ(tree.remove(6), 0u);
  EXPECT_EQ(tree.root(), 1u);
  InsertionSearch search;
  const std::pair<uint32_t, double> expected[] = {{1, 42}, {2, 18}, {3, 20}, {4, 16}, {5, 32}};
  for (const auto& [at, sum] : expected) {
    EXPECT_NEAR(search.cost_at(tree, factors, 6, at), sum / 14, 1e-12) << at;
  }
  const InsertPosition best = search.find(tree, factors, 6, {1, 42.0 / 14});
  EXPECT_EQ(best.at, 4u);
  EXPECT_NEAR(best.cost, 16.0 / 14, 1e-12);
}

std::vector<uint32_t> nodes_below(const MovableTree& tree, uint32_t from) {
  std::vector<uint32_t> nodes = {from};
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (tree.is_leaf(nodes[i])) continue;
    const uint32_t left = tree.child(nodes[i], 0), right = tree.child(nodes[i], 1);
    nodes.insert(nodes.end(), {left, right});
  }
  return nodes;
}

TEST(InsertionSearch, FindsWhatTryingAllPositionsFinds) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    const FrameBoxes frames = random_frames(seed, 2 + 2 * seed, 1 + seed % 4);
    MovableTree tree(deep_tree(frames), frames);
    std::vector<double> weights = tree.costs({});
    for (double& w : weights) w *= w;
    const std::vector<double> factors = area_factors(tree, weights, 3.0f);
    const double weight_sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto weighted_cost = [&] {  // equation 2
      const std::vector<double> costs = tree.costs({});
      return std::inner_product(costs.begin(), costs.end(), weights.begin(), 0.0) / weight_sum;
    };
    InsertionSearch search;
    for (uint32_t node = 0; node < tree.node_count(); ++node) {
      if (node == tree.root()) continue;
      const uint32_t before = tree.sibling(node);
      double least = std::numeric_limits<double>::infinity();
      uint32_t link = tree.remove(node);
      const InsertPosition found = search.find(tree, factors, node, {MovableTree::kNone, least});
      for (const uint32_t at : nodes_below(tree, tree.root())) {
        tree.insert(node, at, link);
        least = std::min(least, weighted_cost());
        link = tree.remove(node);
      }
      tree.insert(node, found.at, link);
      EXPECT_NEAR(weighted_cost(), least, 1e-9 * least);
      link = tree.remove(node);
      tree.insert(node, before, link);
    }
    EXPECT_GT(search.visited(), 0u);
  }
}

TEST(MovableTree, ComesBackToWhatItWas) {
  const FrameBoxes frames = random_frames(5, 40, 3);
  const Tree start = deep_tree(frames);
  MovableTree tree(start, frames);
  const std::vector<double> before = tree.costs({});
  const std::vector<double> costs = frame_costs(start, frames);
  for (size_t f = 0; f < costs.size(); ++f) EXPECT_NEAR(before[f], costs[f], 1e-5 * costs[f]);
  for (uint32_t node = 1; node < tree.node_count(); ++node) {
    const uint32_t sibling = tree.sibling(node);
    tree.insert(node, sibling, tree.remove(node));
  }
  EXPECT_EQ(tree.costs({}), before);
  test::expect_valid(MovableTree::to_tree(tree.state()), frames.frames[0], 1);
}

TEST(Tsah, NeverRaisesTheCostAndAlwaysEnds) {
  const FrameBoxes frames = random_frames(9, 300, 4);
  const Tree start = deep_tree(frames);
  for (const TsahSelection selection : kSelections) {
    for (const TsahMove move : kMoves) {
      for (const double exponent : {0.0, 2.0, 4.0}) {
        TsahConfig config;
        config.exponent = exponent;
        config.selection = selection;
        config.move = move;
        config.random_after = exponent == 2.0 ? 2 : 0;
        config.least_gain = 1e-3;
        double last = 0.0;
        uint32_t batches = 0;
        config.on_batch = [&](const TsahStep& step) {
          EXPECT_EQ(step.batch, batches++);
          EXPECT_EQ(step.costs.size(), 4u);
          EXPECT_NEAR(step.cost, tsah_cost(step.costs, frames.weights, exponent), 1e-9);
          // At weights that stay the same no move of a whole node makes the tree dearer.
          if (move == TsahMove::node && exponent == 0.0 && step.batch > 0) {
            EXPECT_LE(step.cost, last + 1e-9);
          }
          last = step.cost;
          return true;
        };
        const Tree tree = optimize_tsah(start, frames, config);
        test::expect_valid(tree, frames.frames[0], 1);
        test::expect_depth_first(tree);
        const double before = cost_of(start, frames, exponent);
        EXPECT_LE(cost_of(tree, frames, exponent), before);
        // Sorted batches alone may find nothing in the few nodes that they choose.
        if (selection != TsahSelection::sorted_batch) {
          EXPECT_LT(cost_of(tree, frames, exponent), before);
        }
        EXPECT_GE(batches, 1 + config.patience);
      }
    }
  }
}

TEST(Tsah, GroupsWhatFliesTogether) {
  // Eight cubes in a row; then those with even numbers fly left and the others right, so trees of
  // the first frame pair cubes that part.
  std::vector<std::vector<Box>> boxes(2);
  for (int i = 0; i < 8; ++i) {
    const auto x = static_cast<float>(i);
    boxes[0].push_back(bar(x, x + 1));
    const float away = i % 2 ? 1000.0f : -1000.0f;
    boxes[1].push_back(bar(x + away, x + away + 1));
  }
  const FrameBoxes frames = make_frame_boxes(boxes);
  for (const TsahSelection selection : kSelections) {
    for (const TsahMove move : kMoves) {
      TsahConfig config;
      config.selection = selection;
      config.move = move;
      config.patience = 100;  // batches here are single nodes
      config.random_after = 10;
      const Tree tree = build_tsah(frames, config);
      std::vector<int> parity;
      for (const uint32_t p : tree.primitives) parity.push_back(static_cast<int>(p % 2));
      EXPECT_TRUE(std::is_sorted(parity.begin(), parity.end()) ||
                  std::is_sorted(parity.rbegin(), parity.rend()));
    }
  }
}

TEST(Tsah, HighExponentsLowerTheDearestFrame) {
  const FrameBoxes frames = random_frames(21, 200, 3);
  FrameBoxes uneven = frames;  // a frame that is hard: everything is large
  for (Box& box : uneven.frames[2]) box.max += vec3(0.3f);
  const auto costs_with = [&](double exponent) {
    TsahConfig config;
    config.exponent = exponent;
    config.move = TsahMove::node;
    return frame_costs(build_tsah(uneven, config), uneven);
  };
  const std::vector<double> low = costs_with(0.0), high = costs_with(4.0);
  EXPECT_LT(*std::max_element(high.begin(), high.end()), *std::max_element(low.begin(), low.end()));
}

TEST(Tsah, TheSeedDecides) {
  const FrameBoxes frames = random_frames(4, 150, 3);
  TsahConfig config;
  const Tree tree = build_tsah(frames, config);
  test::expect_same(build_tsah(frames, config), tree);
  config.seed = 2;
  EXPECT_NE(build_tsah(frames, config).primitives, tree.primitives);
}

TEST(Tsah, TheCallbackEndsIt) {
  const FrameBoxes frames = random_frames(4, 150, 3);
  TsahConfig config;
  int calls = 0;
  config.on_batch = [&](const TsahStep& step) {
    ++calls;
    return step.batch < 2;
  };
  test::expect_valid(build_tsah(frames, config), frames.frames[0], 1);
  EXPECT_EQ(calls, 3);
}

TEST(Tsah, OneFrameIsInsertionBasedOptimisation) {
  const FrameBoxes frames = random_frames(14, 400, 1);
  const Tree start = deep_tree(frames);
  const Tree tree = optimize_insertion(start, frames.frames[0]);
  EXPECT_LT(cost_of(tree, frames, 0), cost_of(start, frames, 0));
  test::expect_same(optimize_tsah(start, frames), tree);
  // A second frame like the first changes nothing but what the weights are.
  const FrameBoxes twice = make_frame_boxes({frames.frames[0], frames.frames[0]});
  EXPECT_NEAR(cost_of(optimize_tsah(start, twice), frames, 0), cost_of(tree, frames, 0),
              0.05 * cost_of(tree, frames, 0));
}

TEST(Tsah, DegenerateInputs) {
  const Box point{vec3(2.0f), vec3(2.0f)}, cube{vec3(0.0f), vec3(1.0f)};
  std::vector<std::vector<std::vector<Box>>> inputs = {
      {{cube}},                        // one primitive
      {{cube, point}, {point, cube}},  // two
      {{cube, cube, point}},           // three: one node can move
      {std::vector<Box>(50, cube)},    // all equal
      {std::vector<Box>(50, point)},   // no area at all
      {std::vector<Box>(50, point), std::vector<Box>(50, cube)},
      {{bar(0, 1), bar(1, 2), bar(2, 3)}, {point, point, point}},
      {{Box{vec3(-1e30f), vec3(1e30f)}, cube, point, Box{vec3(1e-30f), vec3(2e-30f)}}},
  };
  for (size_t i = 0; i < inputs.size(); ++i) {
    SCOPED_TRACE(i);
    const FrameBoxes frames = make_frame_boxes(inputs[i]);
    for (const TsahSelection selection : kSelections) {
      for (const TsahMove move : kMoves) {
        TsahConfig config;
        config.selection = selection;
        config.move = move;
        config.exponent = 2.0;
        test::expect_valid(build_tsah(frames, config), frames.frames[0], 1);
      }
    }
  }
  EXPECT_TRUE(build_tsah({}).empty());
  EXPECT_TRUE(build_tsah(make_frame_boxes({{}, {}})).empty());
}

}  // namespace
}  // namespace sinew
