// Interpolates the keys of one channel.
// Based on: glTF 2.0 specification, appendix C. Arithmetic is in double; a rotation's keys are
// normalised before they are used, so that quantised keys turn no rotation into a scaling.
#include <algorithm>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

// A time lies `fraction` of `duration` seconds behind key `key`; past the ends the fraction is 0.
struct KeyPosition {
  size_t key = 0;
  double fraction = 0.0;
  double duration = 0.0;
};

KeyPosition find_key(std::span<const float> times, double time) {
  if (!(time > times.front())) return {};  // also if time is not a number
  if (time >= times.back()) return {times.size() - 1, 0.0, 0.0};
  const auto next = std::ranges::upper_bound(times, time, {}, [](float t) { return double{t}; });
  const size_t key = static_cast<size_t>(next - times.begin()) - 1;
  const double duration = double{times[key + 1]} - double{times[key]};
  return {key, (time - times[key]) / duration, duration};
}

glm::dquat unit_quat(const float* xyzw) {
  const glm::dquat q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  const double length = glm::length(q);
  return length > 0.0 && std::isfinite(length) ? q / length : glm::identity<glm::dquat>();
}

void store(const glm::dquat& q, std::span<float> out) {
  out[0] = static_cast<float>(q.x);
  out[1] = static_cast<float>(q.y);
  out[2] = static_cast<float>(q.z);
  out[3] = static_cast<float>(q.w);
}

// Constant angular speed along the shorter arc.
glm::dquat slerp_short(const glm::dquat& a, glm::dquat b, double u) {
  if (glm::dot(a, b) < 0.0) b = -b;
  const double angle = 2.0 * std::atan2(glm::length(a - b), glm::length(a + b));
  if (angle < 1e-6) return glm::normalize(a * (1.0 - u) + b * u);  // equal to double's precision
  const double scale = 1.0 / std::sin(angle);
  return a * (std::sin((1.0 - u) * angle) * scale) + b * (std::sin(u * angle) * scale);
}

// Hermite spline; tangents are per second, hence the duration.
void sample_cubic(const Channel& channel, const KeyPosition& at, std::span<float> out) {
  const size_t width = channel.width;
  const float* key = channel.values.data() + at.key * 3 * width;  // in-tangent, value, out-tangent
  const float* next = key + 3 * width;
  const double u = at.fraction, u2 = u * u, u3 = u2 * u;
  const double value0 = 2.0 * u3 - 3.0 * u2 + 1.0;
  const double tangent0 = (u3 - 2.0 * u2 + u) * at.duration;
  const double value1 = 3.0 * u2 - 2.0 * u3;
  const double tangent1 = (u3 - u2) * at.duration;
  for (size_t i = 0; i < width; ++i) {
    out[i] = static_cast<float>(value0 * key[width + i] + tangent0 * key[2 * width + i] +
                                value1 * next[width + i] + tangent1 * next[i]);
  }
}

}  // namespace

void sample_channel(const Channel& channel, double time, std::span<float> out) {
  SINEW_CHECK(out.size() == channel.width && !channel.times.empty());
  const KeyPosition at = find_key(channel.times, time);
  const bool rotation = channel.path == ChannelPath::rotation;
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  const size_t width = channel.width;
  const float* value = channel.values.data() + (cubic ? 3 * at.key + 1 : at.key) * width;

  if (at.fraction == 0.0 || channel.interpolation == Interpolation::step) {
    std::copy_n(value, width, out.begin());
  } else if (cubic) {
    sample_cubic(channel, at, out);
  } else if (rotation) {
    store(slerp_short(unit_quat(value), unit_quat(value + width), at.fraction), out);
  } else {
    for (size_t i = 0; i < width; ++i) {
      out[i] = static_cast<float>((1.0 - at.fraction) * value[i] + at.fraction * value[width + i]);
    }
  }
  if (rotation) store(unit_quat(out.data()), out);
}

}  // namespace sinew
