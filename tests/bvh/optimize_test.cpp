// One tree for several frames: what it must keep, what it must find, and its search and sums
// against slow twins.
#include "sinew/bvh/frames/optimize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/frames/frame_tree.h"
#include "sinew/bvh/tsah/tsah_reference.h"
#include "sinew/bvh/wide.h"
#include "sinew/math/random.h"
#include "tree_checks.h"

namespace sinew {
namespace {

// Small boxes in a cube that fly apart in so many groups, which are mixed at first.
FrameBoxes scattering(uint32_t seed, uint32_t primitives, uint32_t frames, uint32_t pieces) {
  Random random(seed);
  std::vector<vec3> at(primitives), velocity(pieces);
  for (vec3& p : at) p = random.uniform3(0.0f, 1.0f);
  for (vec3& v : velocity) v = random.uniform3(-20.0f, 20.0f);
  std::vector<std::vector<Box>> boxes(frames, std::vector<Box>(primitives));
  const float size = 0.5f / std::cbrt(float(primitives));
  for (uint32_t f = 0; f < frames; ++f) {
    const float t = frames > 1 ? float(f) / float(frames - 1) : 0.0f;
    for (uint32_t p = 0; p < primitives; ++p) {
      const vec3 low = at[p] + t * velocity[p % pieces];
      boxes[f][p] = {low, low + vec3(size)};
    }
  }
  return make_frame_boxes(std::move(boxes));
}

Tree sweep(const FrameBoxes& frames, uint32_t frame = 0) {
  return build_sweep(frames.frames[frame], {.leaf_block = 1, .max_leaf = 1});
}

double average(const Tree& tree, const FrameBoxes& frames) {
  return power_cost(frame_costs(tree, frames), frames.weights, 0);
}

void expect_good_tree(const Tree& tree, const FrameBoxes& frames) {
  for (const std::vector<Box>& boxes : frames.frames) test::expect_valid(tree, boxes, 1);
  test::expect_depth_first(tree);
}

TEST(BuildOverFrames, HoldsEveryPrimitiveOnce) {
  for (const uint32_t count : {1u, 2u, 3u, 7u, 100u, 6000u}) {
    for (const uint32_t frame_count : {1u, 5u, 9u}) {
      SCOPED_TRACE(testing::Message() << count << " primitives, " << frame_count << " frames");
      const FrameBoxes frames = scattering(count, count, frame_count, 7);
      expect_good_tree(build_over_frames(frames), frames);
    }
  }
}

TEST(BuildOverFrames, OneFrameIsAboutAsGoodAsABuildForIt) {
  const FrameBoxes frames = scattering(1, 3000, 1, 1);
  EXPECT_LT(average(build_over_frames(frames), frames), 1.03 * average(sweep(frames), frames));
}

TEST(BuildOverFrames, ScatteringPiecesAreFoundInAnyFrame) {
  const FrameBoxes frames = scattering(2, 3000, 5, 20);
  const Tree tree = build_over_frames(frames);
  for (uint32_t f = 0; f < 5; ++f) {
    EXPECT_LT(average(tree, frames), 1.02 * average(sweep(frames, f), frames)) << "frame " << f;
  }
}

TEST(Optimize, KeepsTheTreeValidAndIsNeverDearer) {
  for (const uint32_t seed : {1u, 2u, 3u}) {
    for (const uint32_t frame_count : {1u, 4u, 5u, 17u}) {
      for (const uint32_t exponent : {0u, 2u, 4u}) {
        SCOPED_TRACE(testing::Message()
                     << "seed " << seed << ", " << frame_count << " frames, k " << exponent);
        const FrameBoxes frames = scattering(seed, 300, frame_count, 5);
        const OptimizeConfig config{.exponent = exponent};
        const Tree start = sweep(frames);
        const Tree tree = optimize(start, frames, config);
        expect_good_tree(tree, frames);
        const auto cost = [&](const Tree& t) {
          return power_cost(frame_costs(t, frames), frames.weights, exponent);
        };
        EXPECT_LE(cost(tree), cost(start));
        EXPECT_LE(cost(optimize(tree, frames, config)), cost(tree));
      }
    }
  }
}

TEST(Optimize, SameTreeForAnyThreadCount) {
  const FrameBoxes many = scattering(4, 20000, 3, 30), few = scattering(4, 3000, 5, 30);
  const Tree built = build_over_frames(many);
  const OptimizeConfig peaks{.exponent = 2};
  const Tree optimized = build_optimized(few), lower = build_optimized(few, peaks);
  for (const int threads : {1, 2, 3, 4}) {
    const ThreadLimit limit(threads);
    test::expect_same(build_over_frames(many), built);
    test::expect_same(build_optimized(few), optimized);
    test::expect_same(build_optimized(few, peaks), lower);
  }
}

TEST(Optimize, OneFrameIsPlainOptimisation) {
  const FrameBoxes one = scattering(5, 2000, 1, 1);
  const Tree start = sweep(one);
  const Tree tree = optimize(start, one);
  EXPECT_LT(average(tree, one), average(start, one));
  EXPECT_LE(average(build_optimized(one), one), average(start, one));

  // The same frame several times, and any exponent, ask for the same thing.
  FrameBoxes three = make_frame_boxes({one.frames[0], one.frames[0], one.frames[0]});
  for (const uint32_t exponent : {0u, 4u}) {
    EXPECT_NEAR(average(optimize(start, three, {.exponent = exponent}), three), average(tree, one),
                1e-3 * average(tree, one));
  }
}

// A0 A1 B0 B1 lie in a row, neighbours in pairs (A0 B0) (A1 B1); then all A fly left, all B right.
//   frame 0   A0 B0 ....... A1 B1          frame 1   A0 A1 ................ B0 B1
TEST(Optimize, PairsThatFlyApartAreRegrouped) {
  const auto at = [](float x) { return Box{vec3(x, 0, 0), vec3(x + 1, 1, 1)}; };
  const FrameBoxes frames =
      make_frame_boxes({{at(0), at(1), at(4), at(5)}, {at(0), at(100), at(1), at(101)}});
  Tree start;  // ((0 1) (2 3)): right in the first frame, far too large in the second
  start.nodes = {TreeNode::inner(1, 4), TreeNode::inner(2, 3), TreeNode::leaf(0, 1),
                 TreeNode::leaf(1, 1),  TreeNode::inner(5, 6), TreeNode::leaf(2, 1),
                 TreeNode::leaf(3, 1)};
  start.primitives = {0, 1, 2, 3};
  // Root: 6x1x1, half area 13; then 102x1x1, half area 205. Leaves: 4 * 3.
  // Pairs by the first frame: 5 + 5, then 203 + 203: C = (3 * 23 + 24) / 13, (3 * 611 + 24) / 205.
  // Pairs A and B:          11 + 11, then 5 + 5:     C = (3 * 35 + 24) / 13, (3 * 215 + 24) / 205.
  EXPECT_NEAR(average(start, frames), 0.5 * (93.0 / 13 + 1857.0 / 205), 1e-6);
  for (const Tree& tree : {optimize(start, frames), build_optimized(frames)}) {
    EXPECT_NEAR(average(tree, frames), 0.5 * (129.0 / 13 + 669.0 / 205), 1e-6);
  }
}

TEST(Optimize, HigherExponentsLowerTheDearestFrame) {
  const FrameBoxes frames = scattering(6, 2000, 5, 2000);  // every primitive for itself
  double before = std::numeric_limits<double>::infinity();
  for (const uint32_t exponent : {0u, 2u, 4u}) {
    const std::vector<double> costs =
        frame_costs(build_optimized(frames, {.exponent = exponent}), frames);
    const double most = *std::max_element(costs.begin(), costs.end());
    EXPECT_LT(most, before) << "k " << exponent;
    before = most;
  }
}

TEST(Optimize, WeightsOfFramesCount) {
  FrameBoxes frames = scattering(7, 2000, 2, 2000);
  std::vector<double> second;
  for (const double weight : {0.1, 0.5, 0.9}) {
    frames.weights = {1.0 - weight, weight};
    second.push_back(frame_costs(build_optimized(frames), frames)[1]);
  }
  EXPECT_GT(second[0], second[1]);
  EXPECT_GT(second[1], second[2]);
}

TEST(Optimize, DegenerateInput) {
  EXPECT_TRUE(build_optimized({}).empty());
  EXPECT_TRUE(optimize({}, {}).empty());
  const Box unit{vec3(0), vec3(1)};
  for (const uint32_t count : {1u, 2u, 3u, 200u}) {
    for (const uint32_t exponent : {0u, 2u}) {
      // Equal boxes; points in one place; points on a line, which have no area.
      std::vector<Box> line;
      for (uint32_t i = 0; i < count; ++i)
        line.push_back({vec3(float(i), 0, 0), vec3(float(i), 0, 0)});
      const std::vector<Box> same(count, unit), point(count, Box{vec3(1), vec3(1)});
      const std::vector<std::vector<std::vector<Box>>> inputs = {
          {same}, {point}, {line, same, point}};
      for (const auto& all : inputs) {
        const FrameBoxes frames = make_frame_boxes(all);
        expect_good_tree(build_optimized(frames, {.exponent = exponent}), frames);
      }
    }
  }
}

TEST(Optimize, ExtremeCoordinatesAreHandled) {
  Random random(8);
  std::vector<std::vector<Box>> boxes(3);
  for (int i = 0; i < 300; ++i) {
    for (size_t f = 0; f < boxes.size(); ++f) {
      const float scale = f == 0 ? 1e37f : (f == 1 ? 1e-30f : (i % 2 ? 1e30f : 1e-30f));
      const vec3 p = random.uniform3(-scale, scale);
      boxes[f].push_back({p, p + vec3(0.1f * scale)});
    }
  }
  const FrameBoxes frames = make_frame_boxes(boxes);
  expect_good_tree(build_optimized(frames), frames);
}

TEST(Optimize, StepsAreReportedAndCanStopIt) {
  const FrameBoxes frames = scattering(9, 2000, 3, 10);
  const Tree start = sweep(frames);
  int steps = 0;
  double before = average(start, frames), seconds = 0.0;
  OptimizeConfig config;
  config.on_step = [&](const OptimizeStep& step) {
    ++steps;
    const double now = power_cost(step.costs, frames.weights, 0);
    EXPECT_LE(now, before * (1 + 1e-6));
    EXPECT_GE(step.seconds, seconds);
    EXPECT_GT(step.moved, 0u);
    before = now;
    seconds = step.seconds;
    return steps < 2;
  };
  const Tree tree = optimize(start, frames, config);
  EXPECT_EQ(steps, 2);
  expect_good_tree(tree, frames);
  EXPECT_NEAR(average(tree, frames), before, 1e-4 * before);
}

// Boxes one inside the other are best as one long chain.
TEST(Optimize, StaysShallowEnoughToBeTraced) {
  std::vector<Box> boxes;
  for (int i = 0; i < 240; ++i) boxes.push_back({vec3(0), vec3(std::exp2(0.2f * float(i)))});
  const FrameBoxes frames = make_frame_boxes({boxes});
  const Tree tree = build_optimized(frames);
  expect_good_tree(tree, frames);
  std::vector<uint32_t> depth(tree.nodes.size(), 1);
  for (uint32_t n = 0; n < tree.nodes.size(); ++n) {  // parents stand before children
    if (tree.nodes[n].is_leaf()) continue;
    depth[tree.nodes[n].left()] = depth[tree.nodes[n].right()] = depth[n] + 1;
  }
  const uint32_t most = *std::max_element(depth.begin(), depth.end());
  EXPECT_LE(most, kMaxDepth);
  EXPECT_GT(most, kMaxDepth / 2);
}

// As good as moving one subtree after another, which sees every tree as it is.
TEST(Optimize, AsGoodAsTheSequentialMethod) {
  for (const uint32_t pieces : {20u, 2000u}) {
    const FrameBoxes frames = scattering(10, 2000, 5, pieces);
    const double product = average(build_optimized(frames), frames);
    TsahConfig config;
    config.selection = TsahSelection::random;
    for (const TsahMove move : {TsahMove::children, TsahMove::node}) {
      config.move = move;
      EXPECT_LT(product, 1.01 * average(build_tsah(frames, config), frames)) << pieces << " pieces";
    }
  }
}

// ---- FrameTree and the kernels -------------------------------------------------------------

// Weighted cost of all inner nodes, from scratch.
double inner_cost(const Tree& tree, const FrameBoxes& frames) {
  double sum = 0.0;
  for (uint32_t f = 0; f < frames.frame_count(); ++f) {
    const Bounds bounds = refit(tree, frames.frames[f]);
    double areas = 0.0;
    for (uint32_t n = 0; n < tree.nodes.size(); ++n) {
      if (!tree.nodes[n].is_leaf()) areas += double(half_area(bounds[n]));
    }
    sum += frames.weights[f] * areas / double(half_area(bounds[Tree::kRoot]));
  }
  return sum;
}

TEST(FrameTree, CostsAreThoseOfTheTree) {
  for (const uint32_t frame_count : {1u, 4u, 5u, 8u, 17u}) {
    const FrameBoxes frames = scattering(11, 500, frame_count, 5);
    const Tree start = sweep(frames);
    FrameTree tree(start, frames, {});
    const std::vector<double> expected = frame_costs(start, frames);
    for (uint32_t f = 0; f < frame_count; ++f) {
      EXPECT_NEAR(tree.costs()[f], expected[f], 1e-5 * expected[f]);
    }
    test::expect_same(tree.tree(), start);
  }
}

// The search finds the move that lowers the cost most, of all moves that there are.
TEST(FrameTree, SearchFindsTheBestOfAllMoves) {
  for (const uint32_t seed : {12u, 13u, 14u}) {
    for (const uint32_t frame_count : {1u, 5u, 9u}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << frame_count << " frames");
      const FrameBoxes frames = scattering(seed, 24, frame_count, 3);
      const Tree start = sweep(frames);
      FrameTree tree(start, frames, {});
      const double before = inner_cost(start, frames);
      std::vector<uint32_t> slots(tree.slot_count() - 2);
      std::iota(slots.begin(), slots.end(), 2u);
      std::vector<Reinsertion> found(slots.size());
      find_reinsertions(tree.view(), slots, 1000, found.data());
      for (size_t i = 0; i < slots.size(); ++i) {
        double best = 0.0;
        for (uint32_t to = 0; to < tree.slot_count(); ++to) {
          if (to == 1) continue;  // no node
          FrameTree moved(start, frames, {});
          if (moved.move(slots[i], to)) {
            best = std::max(best, before - inner_cost(moved.tree(), frames));
          }
        }
        EXPECT_NEAR(found[i].gain, best, 2e-5 * before) << "slot " << slots[i];
      }
    }
  }
}

// Random moves, and the boxes, areas, and costs after them against a new tree's.
TEST(FrameTree, StaysExactAfterMoves) {
  for (const uint32_t frame_count : {3u, 5u, 17u}) {
    const FrameBoxes frames = scattering(15, 200, frame_count, 200);
    FrameTree tree(sweep(frames), frames, {});
    Random random(16);
    int moved = 0;
    for (int i = 0; i < 20000; ++i) {
      const uint32_t slot = 2 + random.next() % (tree.slot_count() - 2);
      const uint32_t to = random.next() % tree.slot_count();
      if (to != 1) moved += tree.move(slot, to) ? 1 : 0;
    }
    EXPECT_GT(moved, 50);
    const std::vector<double> costs = tree.costs();
    const Tree now = tree.tree();
    expect_good_tree(now, frames);
    const std::vector<double> expected = frame_costs(now, frames);
    for (uint32_t f = 0; f < frame_count; ++f)
      EXPECT_NEAR(costs[f], expected[f], 1e-4 * expected[f]);
    const FrameView view = tree.view();
    const std::vector<float> areas(view.areas, view.areas + tree.slot_count());
    tree.refresh();
    for (uint32_t slot = 0; slot < tree.slot_count(); ++slot) {
      EXPECT_NEAR(areas[slot], view.areas[slot], 1e-6) << "slot " << slot;
    }
  }
}

}  // namespace
}  // namespace sinew
