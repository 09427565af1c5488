// Update mode `automatic`, given what poses cost.
#include "sinew/bvh/update/choose.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

// A body whose costs are known, and rays that reach a share of it.
struct Body {
  UpdateCosts costs;
  bool derivable = true;
  UpdateHistory history;
  std::optional<UpdateOutcome> last;

  UpdateMode next(double share, double rays) {
    const UpdateMode mode = choose_mode(derivable, last, history);
    constexpr double kTreelets = 1000.0;
    UpdateOutcome outcome{.mode = mode, .treelets = kTreelets, .rays = rays};
    if (mode == UpdateMode::full) {
      outcome.update_ns = kTreelets * costs.full;
    } else {
      const bool lazy = mode == UpdateMode::lazy;
      outcome.made = share * kTreelets;
      outcome.update_ns = kTreelets * (lazy ? costs.lazy : costs.hybrid);
      outcome.timed = outcome.made / 8;
      outcome.make_ns = outcome.timed * (lazy ? costs.make_lazy : costs.make_hybrid);
    }
    last = outcome;
    return mode;
  }
  UpdateMode after(int frames, double share, double rays) {
    UpdateMode mode = UpdateMode::automatic;
    for (int i = 0; i < frames; ++i) mode = next(share, rays);
    return mode;
  }
};

TEST(UpdateChoice, FollowsWhatRaysReach) {
  Body body;
  EXPECT_EQ(body.after(10, 0.02, 100), UpdateMode::lazy);
  EXPECT_EQ(body.after(10, 0.95, 100), UpdateMode::full);
  EXPECT_FLOAT_EQ(body.history.choice.reached, 0.95f);
  EXPECT_EQ(body.after(40, 0.02, 100), UpdateMode::lazy);
}

TEST(UpdateChoice, LooksTwiceAtWhatAPoseCosts) {
  Body body;
  EXPECT_EQ(body.next(1.0, 100), UpdateMode::lazy);
  EXPECT_EQ(body.next(1.0, 100), UpdateMode::lazy) << "a first pose makes its memory";
  EXPECT_EQ(body.next(1.0, 100), UpdateMode::full);
}

TEST(UpdateChoice, FollowsWhatThingsCost) {
  Body dear;  // vertices cost much: as many influences and targets do
  dear.costs = {.full = 5500, .hybrid = 5200, .make_hybrid = 700, .make_lazy = 6000};
  EXPECT_EQ(dear.after(20, 0.6, 100), UpdateMode::lazy);
  Body cheap;
  cheap.costs = {.full = 300, .hybrid = 200, .make_hybrid = 700, .make_lazy = 1500};
  EXPECT_EQ(cheap.after(20, 0.6, 100), UpdateMode::full);
}

TEST(UpdateChoice, TriesAgainWhenTheRaysChange) {
  Body body;
  EXPECT_EQ(body.after(5, 0.95, 100000), UpdateMode::full);
  body.next(0.01, 10);
  EXPECT_EQ(body.next(0.01, 10), UpdateMode::lazy);
}

TEST(UpdateChoice, WhatIsOnlyGivenIsNeverLazy) {
  Body body;
  body.derivable = false;
  for (const double share : {0.0, 0.3, 1.0})
    EXPECT_NE(body.after(40, share, 100), UpdateMode::lazy);
  EXPECT_EQ(body.after(40, 0.01, 100), UpdateMode::hybrid);
}

TEST(UpdateChoice, DoesNotGoToAndFro) {
  Body body;
  body.after(10, 0.5, 100);
  int changes = 0;
  UpdateMode last = body.next(0.5, 100);
  for (int i = 0; i < 100; ++i) {
    const UpdateMode mode = body.next(0.29 + 0.02 * (i % 2), 100);
    changes += mode != last;
    last = mode;
  }
  EXPECT_LT(changes, 10);
}

}  // namespace
}  // namespace sinew
