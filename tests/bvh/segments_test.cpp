// Animations cut where their primitives exchange neighbours.
#include "sinew/bvh/frames/segments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "bvh/animated_boxes.h"
#include "shapes.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/update/update.h"
#include "sinew/math/random.h"

namespace sinew {
namespace {

// Ten frames a second.
AnimatedBoxes in_tenths(uint32_t primitives, uint32_t frames,
                        std::function<void(uint32_t, std::span<Box>)> boxes) {
  return animation_of(primitives, frames, std::move(boxes), 0.1);
}

// Every primitive sits at a random place of the constellation that the frame shows: a new one from
// each of the frames `changes` on. In between all of them drift a little.
AnimatedBoxes constellations(uint32_t primitives, uint32_t frames, std::vector<uint32_t> changes) {
  return in_tenths(primitives, frames, [=](uint32_t frame, std::span<Box> out) {
    uint32_t shown = 0;
    for (const uint32_t change : changes) shown += frame >= change ? 1 : 0;
    Random places(70 + shown), drift(9);
    for (Box& box : out) {
      const vec3 place = places.uniform3(0.0f, 1.0f);
      box = box_at(place + 1e-4f * static_cast<float>(frame) * drift.direction());
    }
  });
}

std::vector<uint32_t> first_frames(std::span<const Segment> segments) {
  std::vector<uint32_t> out;
  for (const Segment& s : segments) out.push_back(s.first_frame);
  return out;
}

// What holds for every result: segments follow each other, trees hold every primitive once.
std::vector<Segment> cut(const AnimatedBoxes& animation, const SegmentConfig& config) {
  Result<std::vector<Segment>> result = cut_into_segments(animation, config);
  if (!result) {
    ADD_FAILURE() << result.error().message();
    return {};
  }
  uint32_t next = 0;
  double share = 0.0;
  for (const Segment& s : *result) {
    EXPECT_EQ(s.first_frame, next);
    EXPECT_LE(s.first_frame, s.last_frame);
    next = s.last_frame + 1;
    share += s.share;
    EXPECT_EQ(s.frames.frame_count(), s.representatives.size());
    EXPECT_LE(s.representatives.size(), config.representatives);
    const std::vector<double>& weights = s.frames.weights;
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0, 1e-9);
    std::vector<int> seen(animation.primitive_count, 0);
    for (const TreeNode& node : s.tree.nodes) {
      if (!node.is_leaf()) continue;
      EXPECT_EQ(node.count(), 1u);
      ++seen[s.tree.primitives[node.first()]];
    }
    for (const int times : seen) EXPECT_EQ(times, 1);
  }
  EXPECT_EQ(next, animation.frame_count());
  EXPECT_NEAR(share, 1.0, 1e-9);
  return std::move(*result);
}

double cost_ratio(std::span<const Segment> segments) {
  return average_cost(segments) / average_rebuild_cost(segments);
}

TEST(Segments, AreFoundWhereNeighboursChange) {
  const AnimatedBoxes a = constellations(400, 80, {23, 57});
  const std::vector<Segment> one = cut(a, {});
  ASSERT_EQ(one.size(), 1u);
  const std::vector<Segment> three = cut(a, {.most_segments = 6});
  ASSERT_EQ(first_frames(three), (std::vector<uint32_t>{0, 23, 57}));
  EXPECT_DOUBLE_EQ(three[0].begin, 0.0);
  EXPECT_DOUBLE_EQ(three[1].begin, 2.25);  // between frames 22 and 23
  EXPECT_DOUBLE_EQ(three[2].begin, 5.65);
  EXPECT_LE(cost_ratio(three), 1.15);
  EXPECT_GT(cost_ratio(one), 1.5);
  EXPECT_NEAR(three[1].share, 34.0 / 79.0, 1e-9);

  EXPECT_EQ(segment_at(three, -1.0), 0u);
  EXPECT_EQ(segment_at(three, 2.2), 0u);
  EXPECT_EQ(segment_at(three, 2.25), 1u);
  EXPECT_EQ(segment_at(three, 99.0), 2u);
}

TEST(Segments, OneTreeWhereNothingChanges) {
  const AnimatedBoxes still = constellations(300, 40, {});
  EXPECT_EQ(cut(still, {.most_segments = 8}).size(), 1u);
  const AnimatedBoxes moving = in_tenths(300, 40, [](uint32_t frame, std::span<Box> out) {
    Random random(3);
    for (Box& box : out)
      box = box_at(random.uniform3(0.0f, 1.0f) + vec3(3.0f * float(frame), 0, 0));
  });
  EXPECT_EQ(cut(moving, {.most_segments = 8}).size(), 1u);
}

TEST(Segments, TheBestForAFixedNumber) {
  const AnimatedBoxes a = constellations(400, 80, {16, 62});
  // The long part in the middle must share a tree with one of the others.
  const std::vector<Segment> two = cut(a, {.most_segments = 2});
  ASSERT_EQ(two.size(), 2u);
  EXPECT_TRUE(two[1].first_frame == 16 || two[1].first_frame == 62) << two[1].first_frame;
  EXPECT_LT(average_cost(two), 0.9 * average_cost(cut(a, {})));
}

TEST(Segments, NoMoreThanAreWorthTheirBytes) {
  const AnimatedBoxes a = constellations(400, 80, {23, 57});
  // No number keeps a limit of 0; a fourth tree would gain next to nothing.
  EXPECT_EQ(first_frames(cut(a, {.most_segments = 6, .cost_limit = 0.0})),
            (std::vector<uint32_t>{0, 23, 57}));
}

TEST(Segments, KeepTheBudget) {
  const AnimatedBoxes a = constellations(400, 80, {23, 57});
  SegmentConfig config{.most_segments = 6, .byte_budget = bytes_of_trees(400, 3) - 1};
  EXPECT_EQ(cut(a, config).size(), 2u);
  config.byte_budget = bytes_of_trees(400, 3);
  EXPECT_EQ(cut(a, config).size(), 3u);
  config.byte_budget = bytes_of_trees(400, 1);
  EXPECT_EQ(cut(a, config).size(), 1u);
  config.byte_budget -= 1;
  const Result<std::vector<Segment>> none = cut_into_segments(a, config);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::usage);
  EXPECT_NE(none.error().message().find("too small"), std::string::npos);
}

TEST(Segments, OptimizedRebuildsAreAStricterMeasure) {
  const AnimatedBoxes a = constellations(400, 40, {15});
  const std::vector<Segment> binned = cut(a, {.most_segments = 4, .rebuild = Rebuild::binned});
  const std::vector<Segment> optimized =
      cut(a, {.most_segments = 4, .rebuild = Rebuild::optimized});
  EXPECT_EQ(first_frames(optimized), (std::vector<uint32_t>{0, 15}));
  EXPECT_EQ(average_cost(optimized), average_cost(binned));
  EXPECT_LT(average_rebuild_cost(optimized), 0.98 * average_rebuild_cost(binned));
  EXPECT_GT(cost_ratio(optimized), 0.99);
}

TEST(Segments, MedoidsServeToo) {
  const AnimatedBoxes a = constellations(400, 60, {20});
  const std::vector<Segment> two = cut(a, {.choice = FrameChoice::medoids, .most_segments = 4});
  EXPECT_EQ(first_frames(two), (std::vector<uint32_t>{0, 20}));
}

TEST(Segments, SameForAnyThreadCount) {
  const AnimatedBoxes a = constellations(500, 48, {17, 30});
  const SegmentConfig config{.most_segments = 3, .boundaries = 8};
  const std::vector<Segment> expected = cut(a, config);
  EXPECT_EQ(expected.size(), 3u);
  for (const int threads : {1, 4}) {
    const ThreadLimit limit(threads);
    const std::vector<Segment> found = cut(a, config);
    ASSERT_EQ(first_frames(found), first_frames(expected));
    for (size_t s = 0; s < found.size(); ++s) {
      EXPECT_EQ(found[s].tree.primitives, expected[s].tree.primitives);
      EXPECT_EQ(found[s].cost, expected[s].cost);
      EXPECT_EQ(found[s].rebuild_cost, expected[s].rebuild_cost);
    }
  }
}

TEST(Segments, ShortClips) {
  const SegmentConfig config{.most_segments = 4};
  EXPECT_EQ(cut(constellations(50, 1, {}), config).size(), 1u);
  EXPECT_EQ(cut(constellations(1, 30, {5}), config).size(), 1u);
  EXPECT_EQ(cut(constellations(0, 30, {5}), config).size(), 1u);
  EXPECT_EQ(first_frames(cut(constellations(300, 2, {1}), config)), (std::vector<uint32_t>{0, 1}));
  AnimatedBoxes at_once =
      constellations(300, 9, {4});  // no time passes, so there is nothing to cut
  at_once.times.assign(9, 2.0);
  EXPECT_EQ(cut(at_once, config).size(), 1u);
}

TEST(Segments, FlatAndMissingBoxes) {
  const SegmentConfig config{.most_segments = 4};
  const AnimatedBoxes points = in_tenths(50, 10, [](uint32_t, std::span<Box> out) {
    std::fill(out.begin(), out.end(), box_at({}, 0));
  });
  EXPECT_EQ(cut(points, config).size(), 1u);

  const AnimatedBoxes whole = constellations(400, 80, {23, 57});
  AnimatedBoxes torn = whole;
  torn.boxes = [&](uint32_t frame, std::span<Box> out) {
    whole.boxes(frame, out);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (size_t p = 0; p < out.size(); ++p) {
      if (frame % 10 == 3 || p == 7) out[p].min = vec3(nan);
    }
  };
  const std::vector<Segment> segments = cut(torn, config);
  ASSERT_EQ(segments.size(), 3u);
  for (const Segment& s : segments) {
    EXPECT_TRUE(std::isfinite(s.cost));
    for (const std::vector<Box>& frame : s.frames.frames) {
      for (const Box& box : frame) EXPECT_TRUE(is_finite(box));
    }
  }
}

TEST(Segments, RefuseWhatCannotBeCut) {
  const SegmentConfig config{.most_segments = 4};
  AnimatedBoxes a = constellations(20, 10, {});
  const auto error = [&] {
    const Result<std::vector<Segment>> result = cut_into_segments(a, config);
    return result ? std::string() : result.error().message();
  };
  EXPECT_EQ(error(), "");
  a.times[6] = a.times[4];
  EXPECT_NE(error().find("frame 6"), std::string::npos) << error();
  a.times[6] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(error(), "");
  a = join_clips({constellations(20, 10, {}), constellations(20, 5, {})});
  EXPECT_NE(error().find("frame 10"), std::string::npos) << error();
  a = constellations(20, 0, {});
  EXPECT_NE(error().find("no frames"), std::string::npos) << error();
}

TEST(Segments, TheCallerMayStopAfterAPass) {
  const AnimatedBoxes a = constellations(400, 80, {23, 57});
  int steps = 0;
  SegmentConfig config{.most_segments = 6};
  config.optimize.on_step = [&](const OptimizeStep&) { return ++steps < 1; };
  EXPECT_EQ(cut(a, config).size(), 1u);
  EXPECT_EQ(steps, 1);
}

TEST(Segments, BytesAreAboutThoseOfALayoutAndAPose) {
  for (const test::Shape& shape : {test::sphere(5), test::random_triangles(5000, 3)}) {
    const Result<Bvh8Layout> layout = build_layout(shape.positions, shape.triangles, {});
    ASSERT_TRUE(layout);
    Bvh8 pose;
    update_full(*layout, shape.positions, pose);
    const auto count = static_cast<uint32_t>(shape.triangles.size());
    const auto bytes = static_cast<double>(bytes_of(*layout) + bytes_of(pose));
    EXPECT_LT(static_cast<double>(bytes_of_trees(count)), 1.8 * bytes);
    EXPECT_GT(static_cast<double>(bytes_of_trees(count)), 0.9 * bytes);
    EXPECT_EQ(bytes_of_trees(count, 3), 3 * bytes_of_trees(count));
  }
}

}  // namespace
}  // namespace sinew
