// Frames that stand for an animation: how many, which, and for how much.
#include "sinew/bvh/frames/frame_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "bvh/animated_boxes.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

using Frames = std::vector<uint32_t>;

// Primitives that sit at random places, other ones in every pose; pose(frame) says which.
AnimatedBoxes poses(uint32_t primitives, uint32_t frames, std::function<uint32_t(uint32_t)> pose,
                    float jitter = 0.0f) {
  return animation_of(primitives, frames, [=](uint32_t frame, std::span<Box> out) {
    Random places(1000 + pose(frame)), shaken(frame);
    for (Box& box : out) {
      const vec3 place = places.uniform3(0.0f, 1.0f);
      box = box_at(place + shaken.uniform3(-jitter, jitter));
    }
  });
}

TEST(FrameChoice, SpreadsFramesEvenly) {
  // 99 / 4 = 24.75, 49.5, 74.25, rounded half up.
  EXPECT_EQ(evenly_spread(0, 99, 5), (Frames{0, 25, 50, 74, 99}));
  EXPECT_EQ(evenly_spread(3, 5, 10), (Frames{3, 4, 5}));
  EXPECT_EQ(evenly_spread(10, 20, 1), Frames{15});
  EXPECT_EQ(evenly_spread(7, 7, 3), Frames{7});
}

TEST(FrameChoice, FramesCountByTheTimeAroundThem) {
  AnimatedBoxes a;
  a.times = {0, 1, 2, 4};
  // Half the gaps: 0.5, 0.5 + 0.5, 0.5 + 1, 1; of 4 in all.
  EXPECT_EQ(frame_weights(a, 0, 3), (std::vector<double>{0.125, 0.25, 0.375, 0.25}));
  EXPECT_EQ(frame_weights(a, 1, 2), (std::vector<double>{0.5, 0.5}));
  a.weights = {1, 1, 2, 4};
  EXPECT_EQ(frame_weights(a, 0, 3), (std::vector<double>{0.125, 0.125, 0.25, 0.5}));
  a.weights = {};
  a.times = {5, 5, 5, 5};  // no time passes
  EXPECT_EQ(frame_weights(a, 0, 3), (std::vector<double>{0.25, 0.25, 0.25, 0.25}));
}

TEST(FrameChoice, WeightsGoToTheNearest) {
  const Frames chosen = {10, 14};
  const std::vector<double> weights = {1, 2, 4, 8, 16, 32};  // of frames 9 to 14
  // 9, 10, 11 are nearest to 10; 12 is halfway; 13 and 14 are nearest to 14.
  EXPECT_EQ(weights_by_nearness(chosen, 9, weights), (std::vector<double>{11, 52}));
}

TEST(FrameChoice, UniformTakesFirstAndLast) {
  const AnimatedBoxes a = poses(20, 101, [](uint32_t f) { return f; });
  std::vector<double> weights;
  EXPECT_EQ(choose_frames(a, 0, 100, 5, FrameChoice::uniform, &weights),
            (Frames{0, 25, 50, 75, 100}));
  ASSERT_EQ(weights.size(), 5u);
  EXPECT_NEAR(weights[0], 0.125, 1e-9);
  EXPECT_NEAR(weights[2], 0.25, 1e-9);
  EXPECT_EQ(choose_frames(a, 40, 42, 5, FrameChoice::uniform), (Frames{40, 41, 42}));
}

TEST(FrameChoice, EqualFramesAreOne) {
  for (const FrameChoice choice : {FrameChoice::uniform, FrameChoice::medoids}) {
    std::vector<double> weights;
    const AnimatedBoxes still = poses(50, 40, [](uint32_t) { return 0; });
    EXPECT_EQ(choose_frames(still, 0, 39, 5, choice, &weights).size(), 1u);
    EXPECT_EQ(weights, std::vector<double>{1.0});
    const AnimatedBoxes two = poses(50, 2, [](uint32_t) { return 0; });
    EXPECT_EQ(choose_frames(two, 0, 1, 5, choice).size(), 1u);
    const AnimatedBoxes nothing = poses(0, 9, [](uint32_t f) { return f; });
    EXPECT_EQ(choose_frames(nothing, 0, 8, 3, choice).size(), 1u);
  }
}

TEST(FrameChoice, MedoidsTakeOneOfEachPose) {
  // Of 20 frames 10 show pose 0, 6 pose 1 and 4 pose 2, mixed.
  const std::vector<uint32_t> shown = {0, 1, 0, 2, 0, 0, 1, 0, 1, 0, 2, 0, 1, 2, 0, 1, 0, 0, 2, 1};
  for (const float jitter : {0.0f, 0.002f}) {
    AnimatedBoxes a = poses(
        300, 20, [&](uint32_t f) { return shown[f]; }, jitter);
    a.weights.assign(20, 1.0);
    std::vector<double> weights;
    const Frames chosen = choose_frames(a, 0, 19, 3, FrameChoice::medoids, &weights);
    ASSERT_EQ(chosen.size(), 3u);
    std::set<uint32_t> found;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t pose = shown[chosen[i]];
      found.insert(pose);
      EXPECT_NEAR(weights[i], pose == 0 ? 0.5 : pose == 1 ? 0.3 : 0.2, 1e-9) << pose;
    }
    EXPECT_EQ(found.size(), 3u);
    if (jitter == 0.0f) {
      EXPECT_EQ(choose_frames(a, 0, 19, 8, FrameChoice::medoids).size(), 3u);
    }
  }
}

TEST(FrameChoice, MedoidsLookAtSomeOfManyFrames) {
  // 1000 frames, the last fifth in another pose.
  const AnimatedBoxes a = poses(100, 1000, [](uint32_t f) { return f < 800 ? 0 : 1; });
  std::vector<double> weights;
  const Frames chosen = choose_frames(a, 0, 999, 4, FrameChoice::medoids, &weights);
  ASSERT_EQ(chosen.size(), 2u);
  EXPECT_LT(chosen[0], 800u);
  EXPECT_GE(chosen[1], 800u);
  EXPECT_NEAR(weights[1], 0.2, 0.02);
}

TEST(FrameChoice, MotionOfTheWholeIsNoDifference) {
  const AnimatedBoxes a = animation_of(400, 30, [](uint32_t frame, std::span<Box> out) {
    Random random(5);
    const float t = static_cast<float>(frame);
    for (Box& box : out) {
      const vec3 place = random.uniform3(0.0f, 1.0f);
      box = box_at((1.0f + 0.1f * t) * place + vec3(t, 0.0f, -2.0f * t), 0.01f + 0.001f * t);
    }
  });
  EXPECT_EQ(choose_frames(a, 0, 29, 5, FrameChoice::medoids).size(), 1u);
  EXPECT_EQ(choose_frames(a, 0, 29, 5, FrameChoice::uniform).size(), 5u);
}

TEST(FrameChoice, MedoidsAvoidFramesThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const AnimatedBoxes good = poses(
      200, 12, [](uint32_t f) { return f / 6; }, 0.001f);
  AnimatedBoxes a = good;
  a.boxes = [&](uint32_t frame, std::span<Box> out) {
    good.boxes(frame, out);
    if (frame == 4 || frame == 10) return;  // in all others something is missing
    for (size_t p = 0; p < out.size(); p += 3) out[p].max.y = nan;
  };
  EXPECT_EQ(choose_frames(a, 0, 11, 2, FrameChoice::medoids), (Frames{4, 10}));

  a.boxes = [&](uint32_t, std::span<Box> out) {
    for (Box& box : out) box = {vec3(nan), vec3(nan)};
  };
  EXPECT_EQ(choose_frames(a, 0, 11, 2, FrameChoice::medoids).size(), 1u);
  const FrameBoxes boxes = sample_frames(a, Frames{3}, std::vector<double>{1.0});
  for (const Box& box : boxes.frames[0]) EXPECT_TRUE(is_finite(box));
}

TEST(FrameChoice, SameForAnyThreadCount) {
  const AnimatedBoxes a = poses(
      500, 60, [](uint32_t f) { return f / 7; }, 0.05f);
  const auto choose = [&](std::vector<double>& weights) {
    return choose_frames(a, 0, 59, 6, FrameChoice::medoids, &weights);
  };
  std::vector<double> expected_weights;
  const Frames expected = choose(expected_weights);
  for (const int threads : {1, 4}) {
    const ThreadLimit limit(threads);
    std::vector<double> weights;
    EXPECT_EQ(choose(weights), expected);
    EXPECT_EQ(weights, expected_weights);
  }
}

TEST(FrameChoice, ClipsJoinByTheirLength) {
  AnimatedBoxes walk = poses(10, 5, [](uint32_t) { return 1; });  // times 0 to 4
  AnimatedBoxes wave = poses(10, 3, [](uint32_t) { return 2; });
  wave.times = {0, 0.5, 1};
  AnimatedBoxes rest = poses(10, 1, [](uint32_t) { return 3; });
  AnimatedBoxes none = poses(10, 0, [](uint32_t) { return 4; });
  const AnimatedBoxes all = join_clips({walk, none, wave, rest});
  ASSERT_EQ(all.frame_count(), 9u);
  // walk 4 s, wave 1 s; the rest pose counts like one of these 8 frames: 5 / 8.
  const std::vector<double> expected = {0.5, 1, 1, 1, 0.5, 0.25, 0.5, 0.25, 0.625};
  EXPECT_EQ(all.weights, expected);

  std::vector<Box> here(10), there(10);
  all.boxes(6, here);
  wave.boxes(1, there);
  EXPECT_EQ(here[3].min, there[3].min);
  all.boxes(8, here);
  rest.boxes(0, there);
  EXPECT_EQ(here[3].min, there[3].min);

  std::vector<double> weights;
  const Frames chosen = choose_frames(all, 0, 8, 5, FrameChoice::medoids, &weights);
  ASSERT_EQ(chosen.size(), 3u);
  EXPECT_NEAR(weights[0], 4.0 / 5.625, 1e-9);
  EXPECT_NEAR(weights[1], 1.0 / 5.625, 1e-9);
  EXPECT_EQ(join_clips({}).frame_count(), 0u);
}

TEST(FrameChoice, SamplesOnePrimitiveOfEachRun) {
  const std::vector<uint32_t> sample = sample_primitives(1000, 64);
  ASSERT_EQ(sample.size(), 64u);
  for (uint32_t i = 0; i < 64; ++i) {
    EXPECT_GE(sample[i], i * 1000 / 64);
    EXPECT_LT(sample[i], (i + 1) * 1000 / 64);
  }
  EXPECT_EQ(sample_primitives(1000, 64), sample);
  EXPECT_EQ(sample_primitives(3, 64), (std::vector<uint32_t>{0, 1, 2}));
}

TEST(HeldOut, LeavesRepresentativesOut) {
  const AnimatedBoxes a = poses(100, 11, [](uint32_t f) { return f; });
  const Frames representatives = {0, 5, 10};
  const std::vector<double> weights = {0.25, 0.5, 0.25};
  const FrameBoxes known = sample_frames(a, representatives, weights);
  const Tree tree = build_binned(known.frames[1], {.max_leaf = 1});
  const HeldOutCost cost = held_out_cost(tree, a, 0, 10, representatives, known);
  EXPECT_EQ(cost.frames, (Frames{1, 2, 3, 4, 6, 7, 8, 9}));
  double max = 0.0;
  for (size_t i = 0; i < cost.frames.size(); ++i) {
    std::vector<Box> boxes(100);
    a.boxes(cost.frames[i], boxes);
    EXPECT_EQ(cost.costs[i], sah_cost(tree, refit(tree, boxes)));
    max = std::max(max, cost.costs[i]);
  }
  EXPECT_EQ(cost.max, max);
  // Weights of frames are 1 (ends 0.5); those of 0, 5 and 10 go to their neighbours: frames 1, 4,
  // 6 and 9 count 1.5, the others 1, of 10.
  const std::vector<double>& c = cost.costs;
  EXPECT_NEAR(cost.mean, 0.15 * (c[0] + c[3] + c[4] + c[7]) + 0.1 * (c[1] + c[2] + c[5] + c[6]),
              1e-9);

  EXPECT_EQ(held_out_cost(tree, a, 0, 10, representatives, known, {}, 3).frames, (Frames{1, 6, 9}));
  const FrameBoxes one = sample_frames(a, Frames{5}, std::vector<double>{1.0});
  EXPECT_TRUE(held_out_cost(tree, a, 5, 5, Frames{5}, one).frames.empty());
}

TEST(HeldOut, MissingBoxesComeFromTheNearestRepresentative) {
  AnimatedBoxes a = poses(10, 9, [](uint32_t f) { return f; });
  const Frames representatives = {0, 8};
  const FrameBoxes known = sample_frames(a, representatives, std::vector<double>{0.5, 0.5});
  const auto whole = a.boxes;
  a.boxes = [&](uint32_t frame, std::span<Box> out) {
    whole(frame, out);
    out[4].min.x = std::numeric_limits<float>::infinity();
  };
  EXPECT_EQ(repaired_frame(a, 2, representatives, known)[4].min, known.frames[0][4].min);
  EXPECT_EQ(repaired_frame(a, 7, representatives, known)[4].min, known.frames[1][4].min);
}

}  // namespace
}  // namespace sinew
