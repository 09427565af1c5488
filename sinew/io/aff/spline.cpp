#include "sinew/io/aff/spline.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "sinew/base/check.h"

namespace sinew::aff {
namespace {

using glm::dquat;
using glm::dvec3;

// Weights of the chords before and after a key in one of its tangents, for a segment's own
// parameter from 0 to 1.
struct TangentWeights {
  double before = 0.0;
  double after = 0.0;
};

// `duration` of the segment that the tangent serves; `span` from the key before to the key after.
double spacing(double duration, double span) {
  return span != 0.0 ? 2.0 * duration / span : 1.0;
}

template <class Value>
TangentWeights outgoing(const SplineKey<Value>& key, double duration, double span) {
  const double half = 0.5 * spacing(duration, span) * (1.0 - key.tension);
  return {half * (1.0 + key.continuity) * (1.0 + key.bias),
          half * (1.0 - key.continuity) * (1.0 - key.bias)};
}

template <class Value>
TangentWeights incoming(const SplineKey<Value>& key, double duration, double span) {
  const double half = 0.5 * spacing(duration, span) * (1.0 - key.tension);
  return {half * (1.0 - key.continuity) * (1.0 + key.bias),
          half * (1.0 + key.continuity) * (1.0 - key.bias)};
}

// Where the segment from key `first` to the next counts: seconds, and its parameter at the
// beginning (it ends at 1).
struct Stretch {
  size_t first = 0;
  double begin = 0.0;
  double end = 0.0;
  double u_begin = 0.0;
};

template <class Value>
std::vector<Stretch> stretches(std::span<const SplineKey<Value>> keys) {
  SINEW_CHECK(keys.size() >= kLeastKeys);
  std::vector<Stretch> result;
  double reached = keys[1].time;
  for (size_t i = 1; i + 2 < keys.size(); ++i) {
    const double from = keys[i].time, to = keys[i + 1].time;
    if (to <= reached) continue;
    result.push_back({i, reached, to, (reached - from) / (to - from)});
    reached = to;
  }
  return result;
}

// Collects keys of a cubic_spline channel; times come in order and may repeat.
class ChannelBuilder {
 public:
  explicit ChannelBuilder(uint32_t width) {
    channel_.width = width;
    channel_.interpolation = Interpolation::cubic_spline;
  }

  // A cubic of values and, per second, slopes from `begin` to `end`, after the one added before.
  void add(double begin, double end, const double* value0, const double* slope0,
           const double* value1, const double* slope1) {
    const size_t width = channel_.width;
    const auto is_same = [](double a, double b) {
      return std::abs(a - b) <= 1e-9 * std::max(1.0, std::abs(a));
    };
    const bool goes_on = !channel_.times.empty() &&
                         channel_.times.back() == static_cast<float>(begin) &&
                         std::equal(value0, value0 + width, last_value_.begin(), is_same);
    if (goes_on) {
      std::transform(slope0, slope0 + width, channel_.values.end() - static_cast<ptrdiff_t>(width),
                     [](double slope) { return static_cast<float>(slope); });
    } else {
      push(begin, kNoSlope, value0, slope0);
    }
    push(end, slope1, value1, kNoSlope);
  }
  void add_constant(double time, const double* value) { push(time, kNoSlope, value, kNoSlope); }

  Channel take() { return std::move(channel_); }

 private:
  static constexpr double kNoSlope[4] = {};

  // At a jump the later key has the time, and the earlier one the float before.
  void push(double time, const double* slope_in, const double* value, const double* slope_out) {
    const auto t = static_cast<float>(time);
    std::vector<float>& times = channel_.times;
    if (!times.empty() && times.back() >= t) {
      const float sooner = std::nextafter(t, -std::numeric_limits<float>::infinity());
      const bool room = times.size() < 2 || times[times.size() - 2] < sooner;
      times.back() = sooner;
      if (!room) {
        times.pop_back();
        channel_.values.resize(channel_.values.size() - 3 * size_t{channel_.width});
      }
    }
    times.push_back(t);
    for (const double* part : {slope_in, value, slope_out}) {
      for (uint32_t i = 0; i < channel_.width; ++i) {
        channel_.values.push_back(static_cast<float>(part[i]));
      }
    }
    last_value_.assign(value, value + channel_.width);
  }

  Channel channel_;
  std::vector<double> last_value_;
};

// value + u * (c1 + u * (c2 + u * c3))
struct Cubic {
  dvec3 c0, c1, c2, c3;
  dvec3 value(double u) const { return c0 + u * (c1 + u * (c2 + u * c3)); }
  dvec3 slope(double u) const { return c1 + u * (2.0 * c2 + u * 3.0 * c3); }
};

Cubic vector_segment(std::span<const VectorKey> keys, size_t first) {
  const VectorKey &before = keys[first - 1], &from = keys[first], &to = keys[first + 1],
                  &after = keys[first + 2];
  const double duration = to.time - from.time;
  const dvec3 chord = to.value - from.value;
  const TangentWeights out = outgoing(from, duration, to.time - before.time);
  const TangentWeights in = incoming(to, duration, after.time - from.time);
  const dvec3 tangent0 = out.before * (from.value - before.value) + out.after * chord;
  const dvec3 tangent1 = in.before * chord + in.after * (after.value - to.value);
  return {from.value, tangent0, 3.0 * chord - 2.0 * tangent0 - tangent1,
          tangent0 + tangent1 - 2.0 * chord};
}

// Imaginary part of the logarithm of a unit quaternion; its length is half the angle, 0 to pi.
dvec3 logarithm(const dquat& q) {
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  return sine > 1e-12 ? v * (std::atan2(sine, q.w) / sine) : v;
}

dquat exponential(const dvec3& v) {
  const double angle = glm::length(v);
  const double scale = angle > 1e-12 ? std::sin(angle) / angle : 1.0;
  return dquat(std::cos(angle), v.x * scale, v.y * scale, v.z * scale);
}

// Along the arc between the two, which is the longer one if their product is negative.
dquat slerp_as_given(const dquat& a, const dquat& b, double u) {
  const double angle = 2.0 * std::atan2(glm::length(a - b), glm::length(a + b));
  const double sine = std::sin(angle);
  if (!(sine > 1e-9)) return angle < 1.0 ? glm::normalize(a * (1.0 - u) + b * u) : a;
  return a * (std::sin((1.0 - u) * angle) / sine) + b * (std::sin(u * angle) / sine);
}

struct Squad {
  dquat p, a, b, q;
  dquat value(double u) const {
    return glm::normalize(
        slerp_as_given(slerp_as_given(p, q, u), slerp_as_given(a, b, u), 2.0 * u * (1.0 - u)));
  }
  // One-sided at the ends, which are kinks.
  dquat slope(double u) const {
    constexpr double kStep = 1e-4;
    if (u < kStep) {
      return (value(u) * -3.0 + value(u + kStep) * 4.0 - value(u + 2 * kStep)) * (0.5 / kStep);
    }
    if (u > 1.0 - kStep) {
      return (value(u) * 3.0 - value(u - kStep) * 4.0 + value(u - 2 * kStep)) * (0.5 / kStep);
    }
    return (value(u + kStep) - value(u - kStep)) * (0.5 / kStep);
  }
};

// The keys, each of the sign that is nearer to the one before. As in BART's code, the first two are
// left alone, and a segment sees the key after it as it stands in the file: `file_keys`.
std::vector<RotationKey> aligned(std::span<const RotationKey> file_keys) {
  std::vector<RotationKey> keys(file_keys.begin(), file_keys.end());
  for (size_t i = 2; i + 1 < keys.size(); ++i) {
    if (glm::dot(keys[i - 1].value, keys[i].value) < 0.0) keys[i].value = -keys[i].value;
  }
  return keys;
}

Squad rotation_segment(std::span<const RotationKey> file_keys, std::span<const RotationKey> keys,
                       size_t first) {
  const RotationKey &before = keys[first - 1], &from = keys[first], &to = keys[first + 1],
                    &after = file_keys[first + 2];
  const double duration = to.time - from.time;
  const auto chord_between = [](const dquat& a, const dquat& b) {
    return logarithm(glm::conjugate(a) * b);
  };
  const dvec3 chord = chord_between(from.value, to.value);
  const TangentWeights out = outgoing(from, duration, to.time - before.time);
  const TangentWeights in = incoming(to, duration, after.time - from.time);
  const dvec3 tangent0 = out.before * chord_between(before.value, from.value) + out.after * chord;
  const dvec3 tangent1 = in.before * chord + in.after * chord_between(to.value, after.value);
  return {from.value, from.value * exponential(0.5 * (tangent0 - chord)),
          to.value * exponential(0.5 * (chord - tangent1)), to.value};
}

constexpr double kRotationTolerance = 1e-5;  // of quaternions: half an angle, radians

// How far the Hermite cubic from u0 to u1 leaves the squad.
double hermite_error(const Squad& squad, double u0, double u1) {
  const double h = u1 - u0;
  const dquat q0 = squad.value(u0), q1 = squad.value(u1);
  const dquat m0 = squad.slope(u0) * h, m1 = squad.slope(u1) * h;
  double worst = 0.0;
  for (const double s : {0.25, 0.5, 0.75}) {
    const double s2 = s * s, s3 = s2 * s;
    const dquat cubic = q0 * (2 * s3 - 3 * s2 + 1) + m0 * (s3 - 2 * s2 + s) +
                        q1 * (3 * s2 - 2 * s3) + m1 * (s3 - s2);
    worst = std::max(worst, glm::length(glm::normalize(cubic) - squad.value(u0 + s * h)));
  }
  return worst;
}

int pieces_of(const Squad& squad, double u_begin) {
  int pieces = 1;
  for (; pieces < kMostPieces; pieces *= 2) {
    const double h = (1.0 - u_begin) / pieces;
    bool fits = true;
    for (int i = 0; i < pieces && fits; ++i) {
      fits = hermite_error(squad, u_begin + i * h, u_begin + (i + 1) * h) < kRotationTolerance;
    }
    if (fits) break;
  }
  return pieces;
}

struct Xyzw {
  double v[4];
  explicit Xyzw(const dquat& q) : v{q.x, q.y, q.z, q.w} {}
};

void add_squad(const Squad& squad, const Stretch& stretch, double duration, ChannelBuilder& out) {
  const int pieces = pieces_of(squad, stretch.u_begin);
  const double step = (1.0 - stretch.u_begin) / pieces;
  const double seconds = (stretch.end - stretch.begin) / pieces;
  for (int i = 0; i < pieces; ++i) {
    const double u0 = stretch.u_begin + i * step;
    const double u1 = i + 1 == pieces ? 1.0 : u0 + step;
    const Xyzw value0(squad.value(u0)), value1(squad.value(u1));
    const Xyzw slope0(squad.slope(u0) / duration), slope1(squad.slope(u1) / duration);
    out.add(stretch.begin + i * seconds,
            i + 1 == pieces ? stretch.end : stretch.begin + (i + 1) * seconds, value0.v, slope0.v,
            value1.v, slope1.v);
  }
}

}  // namespace

Channel vector_channel(std::span<const VectorKey> keys) {
  ChannelBuilder builder(3);
  for (const Stretch& stretch : stretches(keys)) {
    const Cubic cubic = vector_segment(keys, stretch.first);
    const double duration = keys[stretch.first + 1].time - keys[stretch.first].time;
    const dvec3 value0 = cubic.value(stretch.u_begin);
    const dvec3 slope0 = cubic.slope(stretch.u_begin) / duration;
    const dvec3 value1 = keys[stretch.first + 1].value, slope1 = cubic.slope(1.0) / duration;
    builder.add(stretch.begin, stretch.end, &value0.x, &slope0.x, &value1.x, &slope1.x);
  }
  const VectorKey& last = keys[keys.size() - 2];
  Channel channel = builder.take();
  if (!channel.times.empty()) return channel;
  ChannelBuilder constant(3);
  constant.add_constant(last.time, &last.value.x);
  return constant.take();
}

Channel rotation_channel(std::span<const RotationKey> file_keys) {
  const std::vector<RotationKey> keys = aligned(file_keys);
  ChannelBuilder builder(4);
  for (const Stretch& stretch : stretches<dquat>(keys)) {
    const double duration = keys[stretch.first + 1].time - keys[stretch.first].time;
    add_squad(rotation_segment(file_keys, keys, stretch.first), stretch, duration, builder);
  }
  Channel channel = builder.take();
  if (channel.times.empty()) {
    ChannelBuilder constant(4);
    const RotationKey& last = keys[keys.size() - 2];
    constant.add_constant(last.time, Xyzw(last.value).v);
    channel = constant.take();
  }
  channel.path = ChannelPath::rotation;
  return channel;
}

}  // namespace sinew::aff
