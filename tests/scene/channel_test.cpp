// Channels by hand numbers: step, linear, cubic spline, rotations, the ends.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sinew/math/random.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

std::vector<float> at(const Channel& channel, double time) {
  std::vector<float> out(channel.width);
  sample_channel(channel, time, out);
  return out;
}

Channel scalar(Interpolation interpolation, std::vector<float> times, std::vector<float> values) {
  return {0, ChannelPath::weights, interpolation, 1, std::move(times), std::move(values)};
}

TEST(Channel, StepHoldsUntilTheNextKey) {
  const Channel c = scalar(Interpolation::step, {1, 2, 4}, {10, 20, 30});
  EXPECT_EQ(at(c, 0.0)[0], 10);
  EXPECT_EQ(at(c, 1.0)[0], 10);
  EXPECT_EQ(at(c, 1.999999)[0], 10);
  EXPECT_EQ(at(c, 2.0)[0], 20);
  EXPECT_EQ(at(c, 3.9)[0], 20);
  EXPECT_EQ(at(c, 4.0)[0], 30);
  EXPECT_EQ(at(c, 99.0)[0], 30);
}

TEST(Channel, LinearBetweenUnequalKeysAndHeldAtTheEnds) {
  Channel c{0,         ChannelPath::translation,    Interpolation::linear, 3,
            {1, 2, 4}, {0, 0, 0, 1, 2, 3, 5, 2, -1}};
  EXPECT_EQ(at(c, -5.0), (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(at(c, 1.5), (std::vector<float>{0.5f, 1.0f, 1.5f}));
  EXPECT_EQ(at(c, 2.0), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(at(c, 3.0), (std::vector<float>{3, 2, 1}));
  EXPECT_EQ(at(c, 5.0), (std::vector<float>{5, 2, -1}));
}

TEST(Channel, OneKeyHoldsAlways) {
  const Channel c = scalar(Interpolation::linear, {3}, {7});
  for (const double t : {-1.0, 3.0, 9.0}) EXPECT_EQ(at(c, t)[0], 7);
}

TEST(Channel, ATimeThatIsNoNumberGivesTheFirstKey) {
  const Channel c = scalar(Interpolation::linear, {0, 1}, {7, 8});
  EXPECT_EQ(at(c, std::numeric_limits<double>::quiet_NaN())[0], 7);
  EXPECT_EQ(at(c, std::numeric_limits<double>::infinity())[0], 8);
}

// Keys at 0, 2 and 3: value 1 leaving at 2 per second, value 5 entering at -4 and leaving at 8,
// value 0 entering at 16.
TEST(Channel, CubicSplineScalesTangentsByTheKeyInterval) {
  const Channel c = scalar(Interpolation::cubic_spline, {0, 2, 3}, {77, 1, 2, -4, 5, 8, 16, 0, 77});
  EXPECT_EQ(at(c, 0.0)[0], 1);
  EXPECT_EQ(at(c, 2.0)[0], 5);
  EXPECT_EQ(at(c, 3.0)[0], 0);
  // u = 1/2: (1 + 5) / 2 + 2 * (2 - -4) / 8 = 4.5
  EXPECT_FLOAT_EQ(at(c, 1.0)[0], 4.5f);
  // u = 1/4 of 2 s: 0.84375 * 1 + 2 * 0.140625 * 2 + 0.15625 * 5 + 2 * -0.046875 * -4 = 2.5625
  EXPECT_FLOAT_EQ(at(c, 0.5)[0], 2.5625f);
  // u = 1/2 of 1 s: (5 + 0) / 2 + 1 * (8 - 16) / 8 = 1.5
  EXPECT_FLOAT_EQ(at(c, 2.5)[0], 1.5f);
}

constexpr float kHalf = 0.70710678f;

Channel rotation(Interpolation interpolation, std::vector<float> times, std::vector<float> values) {
  return {0, ChannelPath::rotation, interpolation, 4, std::move(times), std::move(values)};
}

void expect_near(const std::vector<float>& a, const std::vector<double>& b) {
  for (size_t i = 0; i < b.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-7) << "component " << i;
}

TEST(Channel, RotationsTurnAtConstantSpeed) {
  // From rest to a quarter turn about z, in 3 s.
  const Channel c = rotation(Interpolation::linear, {0, 3}, {0, 0, 0, 1, 0, 0, kHalf, kHalf});
  for (const double t : {0.0, 0.3, 1.0, 2.0, 3.0}) {
    const double half_angle = 0.5 * glm::radians(30.0) * t;
    expect_near(at(c, t), {0.0, 0.0, std::sin(half_angle), std::cos(half_angle)});
  }
}

TEST(Channel, RotationsTakeTheShorterArc) {
  // The same turn, its second key written with the opposite sign.
  const Channel c = rotation(Interpolation::linear, {0, 3}, {0, 0, 0, 1, 0, 0, -kHalf, -kHalf});
  expect_near(at(c, 1.0), {0.0, 0.0, std::sin(glm::radians(15.0)), std::cos(glm::radians(15.0))});
}

TEST(Channel, RotationsBetweenNearlyEqualKeys) {
  const Channel c = rotation(Interpolation::linear, {0, 1}, {0, 0, 0, 1, 0, 0, 2e-8f, 1});
  expect_near(at(c, 0.5), {0, 0, 1e-8, 1});
  const Channel same = rotation(Interpolation::linear, {0, 1}, {0, 0, 0, 1, 0, 0, 0, 1});
  expect_near(at(same, 0.5), {0, 0, 0, 1});
}

TEST(Channel, EveryRotationComesOutNormalised) {
  std::vector<float> cubic = {0, 0, 0, 0, 0, 0, 0, 3, 5, 0, 0, 0,  // out-tangent about x
                              0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0};
  const Channel channels[] = {
      rotation(Interpolation::step, {0, 1}, {0, 0, 0, 2, 0, 0, 0.5f, 0}),
      rotation(Interpolation::linear, {0, 1}, {0, 0, 0, 2, 0, 0, 0.5f, 0.1f}),
      rotation(Interpolation::cubic_spline, {0, 1}, cubic)};
  for (const Channel& c : channels) {
    for (const double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const std::vector<float> q = at(c, t);
      EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0f, 2e-7f);
    }
  }
  // By hand at u = 1/2: values (0,0,0,3) and (0,2,0,0) halved, plus the tangent over 8.
  const double x = 5.0 / 8.0, y = 1.0, w = 1.5, length = std::sqrt(x * x + y * y + w * w);
  expect_near(at(channels[2], 0.5), {x / length, y / length, 0.0, w / length});
}

TEST(Channel, AZeroRotationIsNoRotation) {
  const Channel c = rotation(Interpolation::step, {0}, {0, 0, 0, 0});
  expect_near(at(c, 0.0), {0, 0, 0, 1});
}

TEST(Channel, FindsTheKeyAmongManyByAnyTime) {
  constexpr uint32_t kSeed = 11;
  Random random(kSeed);
  Channel c = scalar(Interpolation::linear, {0}, {0});
  while (c.times.size() < 1000) {
    c.times.push_back(c.times.back() + random.uniform(1e-4f, 1.0f));
    c.values.push_back(random.uniform(-1.0f, 1.0f));
  }
  for (int i = 0; i < 1000; ++i) {
    const double time = random.uniform(-1.0f, c.times.back() + 1.0f);
    size_t key = 0;
    while (key + 1 < c.times.size() && c.times[key + 1] <= time) ++key;
    double expected = c.values[key];
    if (time > 0.0 && key + 1 < c.times.size()) {
      const double u = (time - c.times[key]) / (double(c.times[key + 1]) - c.times[key]);
      expected += u * (double(c.values[key + 1]) - c.values[key]);
    }
    EXPECT_NEAR(at(c, time)[0], expected, 1e-7) << "seed " << kSeed << ", time " << time;
  }
}

}  // namespace
}  // namespace sinew
