#include "sinew/io/aff/spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/math/random.h"
#include "sinew/scene/sample.h"

namespace sinew::aff {
namespace {

VectorKey key(double time, double x, double tension = 0, double continuity = 0, double bias = 0) {
  return {time, {x, -x, 10.0 * x}, tension, continuity, bias};
}

RotationKey turn(double time, glm::dvec3 axis, double degrees) {
  return {time, glm::angleAxis(glm::radians(degrees), glm::normalize(axis)), 0.0, 0.0, 0.0};
}

float x_at(const Channel& channel, double time) {
  std::array<float, 3> out{};
  sample_channel(channel, time, out);
  EXPECT_FLOAT_EQ(out[1], -out[0]);
  EXPECT_NEAR(out[2], 10.0f * out[0], 1e-5f * std::abs(out[2]));
  return out[0];
}

glm::dquat rotation_at(const Channel& channel, double time) {
  std::array<float, 4> out{};
  sample_channel(channel, time, out);
  return glm::normalize(glm::dquat(out[3], out[0], out[1], out[2]));
}

double angle_between(const glm::dquat& a, const glm::dquat& b) {
  const double nearer = std::min(glm::length(a - b), glm::length(a + b));
  return 4.0 * std::asin(std::min(1.0, 0.5 * nearer));
}

void expect_sound(const Channel& channel) {
  EXPECT_TRUE(std::is_sorted(channel.times.begin(), channel.times.end(), std::less_equal<>()));
  EXPECT_EQ(channel.values.size(), 3 * size_t{channel.width} * channel.times.size());
}

TEST(AffSpline, UniformKeysByHand) {
  const std::array keys = {key(0, 0), key(1, 1), key(2, 3), key(3, 3)};
  const Channel channel = vector_channel(keys);
  expect_sound(channel);
  // Slopes: (1 + 2) / 2 out of the first key that counts, (2 + 0) / 2 into the last.
  ASSERT_EQ(channel.times, (std::vector<float>{1, 2}));
  EXPECT_FLOAT_EQ(channel.values[6], 1.5f);
  EXPECT_FLOAT_EQ(channel.values[9], 1.0f);
  EXPECT_FLOAT_EQ(x_at(channel, 1.5), 2.0f + 0.125f * (1.5f - 1.0f));
  EXPECT_FLOAT_EQ(x_at(channel, 0.0), 1.0f) << "the first and last keys only shape tangents";
  EXPECT_FLOAT_EQ(x_at(channel, 9.0), 3.0f);
}

TEST(AffSpline, UnevenKeysByHand) {
  const std::array keys = {key(0, 0), key(1, 1), key(3, 3), key(4, 3)};
  const Channel channel = vector_channel(keys);
  // For the segment's own parameter: 2 * 2 / 3 * (1 + 2) / 2 = 2 and 2 * 2 / 3 * (2 + 0) / 2 = 4/3;
  // it lasts two seconds.
  EXPECT_FLOAT_EQ(channel.values[6], 1.0f);
  EXPECT_FLOAT_EQ(channel.values[9], 2.0f / 3.0f);
  EXPECT_FLOAT_EQ(x_at(channel, 2.0), 2.0f + 0.125f * (2.0f - 4.0f / 3.0f));
}

TEST(AffSpline, TensionContinuityAndBiasByHand) {
  const std::array keys = {key(0, 0), key(1, 1, 0.5, 0.25, 0.5), key(2, 3, -0.5, -0.25, -0.5),
                           key(3, 7)};
  const Channel channel = vector_channel(keys);
  // out: (1 - 0.5) / 2 * ((1.25)(1.5) * 1 + (0.75)(0.5) * 2)
  EXPECT_FLOAT_EQ(channel.values[6], 0.25f * (1.875f + 0.75f));
  // in: (1 + 0.5) / 2 * ((1.25)(0.5) * 2 + (0.75)(1.5) * 4)
  EXPECT_FLOAT_EQ(channel.values[9], 0.75f * (1.25f + 4.5f));
}

TEST(AffSpline, ContinuityMakesKinksAndTensionStops) {
  const std::array keys = {key(0, 0), key(1, 1), key(2, 3, 0, -1, 0), key(3, 3), key(4, 0)};
  const Channel channel = vector_channel(keys);
  ASSERT_EQ(channel.times.size(), 3u);
  // At the key of continuity -1, the curve comes in along its chord and leaves along the next.
  EXPECT_FLOAT_EQ(channel.values[9], 2.0f);
  EXPECT_FLOAT_EQ(channel.values[15], 0.0f);
}

TEST(AffSpline, KeysAtOneTimeJump) {
  const std::array keys = {key(0, 0), key(0, 0), key(1, 1), key(1, 5), key(2, 6), key(2, 6)};
  const Channel channel = vector_channel(keys);
  expect_sound(channel);
  EXPECT_NEAR(x_at(channel, 0.9999), 1.0f, 0.01f);
  EXPECT_FLOAT_EQ(x_at(channel, 1.0), 5.0f) << "the later key counts from its time on";
  EXPECT_FLOAT_EQ(x_at(channel, 2.0), 6.0f);

  const std::array all_at_once = {key(3, 1), key(3, 2), key(3, 4), key(3, 8)};
  EXPECT_FLOAT_EQ(x_at(vector_channel(all_at_once), 0.0), 4.0f);
}

TEST(AffSpline, TimeThatGoesBackIsPassedOver) {
  // Straight lines of slope 1, then one of slope 10 that starts at time 1 again.
  const std::array keys = {key(0, 0),  key(1, 1),  key(2, 2),  key(3, 3),  key(1, 10),
                           key(2, 20), key(3, 30), key(4, 40), key(5, 50), key(6, 60)};
  const Channel channel = vector_channel(keys);
  expect_sound(channel);
  EXPECT_FLOAT_EQ(x_at(channel, 1.0), 1.0f);
  EXPECT_FLOAT_EQ(x_at(channel, 3.5), 35.0f);
  EXPECT_FLOAT_EQ(x_at(channel, 4.5), 45.0f);
}

TEST(AffSpline, ChannelsAreTheSplineAtEveryTime) {
  const uint32_t seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  std::vector<VectorKey> keys;
  double time = -1.0;
  for (int i = 0; i < 12; ++i) {
    time += 0.1 + random.uniform();
    keys.push_back(key(time, random.uniform(), random.uniform() - 0.5, random.uniform() - 0.5,
                       random.uniform() - 0.5));
  }
  const Channel channel = vector_channel(keys);
  for (size_t i = 1; i + 2 < keys.size(); ++i) {
    const double d = keys[i + 1].time - keys[i].time;
    const auto tangent = [&](size_t at, double continuity_sign) {
      const VectorKey& k = keys[at];
      const double c = continuity_sign * k.continuity;
      const double adjust = 2.0 * d / (keys[at + 1].time - keys[at - 1].time);
      return 0.5 * adjust * (1 - k.tension) *
             ((1 + c) * (1 + k.bias) * (k.value.x - keys[at - 1].value.x) +
              (1 - c) * (1 - k.bias) * (keys[at + 1].value.x - k.value.x));
    };
    for (const double u : {0.0, 0.2, 0.5, 0.9}) {
      const double u2 = u * u, u3 = u2 * u;
      const double expected =
          (2 * u3 - 3 * u2 + 1) * keys[i].value.x + (u3 - 2 * u2 + u) * tangent(i, 1.0) +
          (3 * u2 - 2 * u3) * keys[i + 1].value.x + (u3 - u2) * tangent(i + 1, -1.0);
      EXPECT_NEAR(x_at(channel, keys[i].time + u * d), expected, 2e-6) << "segment " << i;
    }
  }
}

TEST(AffSpline, EvenTurnsStayEven) {
  const glm::dvec3 axis(1, 2, -2);
  const std::array keys = {turn(0, axis, 0),   turn(1, axis, 90),  turn(2, axis, 180),
                           turn(3, axis, 270), turn(4, axis, 360), turn(5, axis, 450)};
  const Channel channel = rotation_channel(keys);
  expect_sound(channel);
  EXPECT_EQ(channel.path, ChannelPath::rotation);
  for (double t = 1.0; t <= 4.0; t += 0.05) {
    EXPECT_LT(angle_between(rotation_at(channel, t), turn(0, axis, 90 * t).value), 3e-5) << t;
  }
}

// About one axis, the squad of the keys is the cubic of their angles.
TEST(AffSpline, TurnsAboutOneAxisFollowTheCubicOfTheirAngles) {
  const uint32_t seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const glm::dvec3 axis(0.6, -0.48, 0.64);
  std::vector<RotationKey> turns;
  std::vector<VectorKey> angles;
  double time = 0.0, degrees = 0.0;
  for (int i = 0; i < 20; ++i) {
    time += 0.05 + random.uniform();
    degrees += 100.0 * (random.uniform() - 0.5);
    turns.push_back(turn(time, axis, degrees));
    turns.back().tension = random.uniform() - 0.5;
    turns.back().continuity = random.uniform() - 0.5;
    turns.back().bias = random.uniform() - 0.5;
    angles.push_back(
        key(time, degrees, turns.back().tension, turns.back().continuity, turns.back().bias));
  }
  const Channel rotation = rotation_channel(turns), angle = vector_channel(angles);
  for (double t = turns[1].time; t < turns[18].time; t += 0.01) {
    std::array<float, 3> expected{};
    sample_channel(angle, t, expected);
    EXPECT_LT(angle_between(rotation_at(rotation, t), turn(0, axis, expected[0]).value), 4e-5) << t;
  }
}

TEST(AffSpline, TurnsPassThroughTheirKeysWithoutJumps) {
  const uint32_t seed = 13;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  std::vector<RotationKey> keys;
  for (int i = 0; i < 20; ++i) {
    const glm::dvec3 axis(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
    keys.push_back(turn(i, axis, 720.0 * (random.uniform() - 0.5)));
  }
  const Channel channel = rotation_channel(keys);
  expect_sound(channel);
  for (int i = 1; i + 1 < 20; ++i) {
    EXPECT_LT(angle_between(rotation_at(channel, i), keys[static_cast<size_t>(i)].value), 3e-5);
  }
  for (double t = 1.0; t < 18.0; t += 0.001) {
    const double step = angle_between(rotation_at(channel, t), rotation_at(channel, t + 0.001));
    EXPECT_LT(step, 0.03) << t;
  }
}

TEST(AffSpline, EqualTurnsStandStill) {
  const std::array keys = {turn(0, {0, 1, 0}, 0), turn(1, {0, 1, 0}, 0), turn(2, {1, 0, 0}, 0),
                           turn(3, {0, 1, 0}, 0)};
  const Channel channel = rotation_channel(keys);
  EXPECT_EQ(channel.times.size(), 2u);
  EXPECT_LT(angle_between(rotation_at(channel, 1.7), glm::dquat(1, 0, 0, 0)), 1e-7);
}

}  // namespace
}  // namespace sinew::aff
