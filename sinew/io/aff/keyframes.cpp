#include "sinew/io/aff/keyframes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sinew/io/aff/spline.h"
#include "sinew/io/text.h"

namespace sinew::aff {
namespace {

template <class Key>
void warn_of_time_going_back(const std::vector<Key>& keys, const Words& words,
                             std::vector<std::string>& warnings) {
  const auto back = std::ranges::adjacent_find(keys, std::ranges::greater{}, &Key::time);
  if (back == keys.end() || warnings.size() >= kMostWarnings) return;
  warnings.push_back(fmt::format(
      "{}: keys before line {}: time goes back from {} to {}: what is before {} is passed over",
      words.path(), words.line(), back->time, (back + 1)->time, back->time));
}

// "time x y z tension continuity bias"
Result<std::vector<VectorKey>> read_vector_keys(Words& words, uint32_t count) {
  std::vector<VectorKey> keys(count);
  for (VectorKey& key : keys) {
    double row[7];
    SINEW_CHECKED(words.numbers(row));
    key = {row[0], {row[1], row[2], row[3]}, row[4], row[5], row[6]};
  }
  return keys;
}

// "time x y z degrees tension continuity bias"
Result<std::vector<RotationKey>> read_rotation_keys(Words& words, uint32_t count) {
  std::vector<RotationKey> keys(count);
  for (RotationKey& key : keys) {
    double row[8];
    SINEW_CHECKED(words.numbers(row));
    const glm::dvec3 axis(row[1], row[2], row[3]);
    const double length = glm::length(axis);
    const double angle = glm::radians(row[4]);
    if (length == 0.0 && angle != 0.0) {
      return words.error("turns about an axis without direction", "give an axis that is not 0 0 0");
    }
    const glm::dvec3 v = length > 0.0 ? axis * (std::sin(0.5 * angle) / length) : glm::dvec3(0.0);
    key = {row[0], glm::dquat(std::cos(0.5 * angle), v.x, v.y, v.z), row[5], row[6], row[7]};
  }
  return keys;
}

// "time 0|1": visible until the first key.
Result<Channel> read_visibility(Words& words) {
  SINEW_TRY(const uint32_t count, words.count("visibility keys", 2));
  Channel channel;
  channel.path = ChannelPath::visibility;
  channel.interpolation = Interpolation::step;
  channel.width = 1;
  for (uint32_t i = 0; i < count; ++i) {
    float row[2];
    SINEW_CHECKED(words.numbers(row));
    if (i == 0) {
      channel.times.push_back(std::nextafter(row[0], -std::numeric_limits<float>::infinity()));
      channel.values.push_back(1.0f);
    }
    if (row[0] < channel.times.back()) {
      return words.error("visibility keys go back in time", "give them in order");
    }
    if (row[0] > channel.times.back()) {
      channel.times.push_back(row[0]);
      channel.values.push_back(0.0f);
    }
    channel.values.back() = row[1] != 0.0f ? 1.0f : 0.0f;
  }
  if (count == 0) return words.error("has no visibility keys", "give at least 1");
  return channel;
}

// Bytes that a channel may take for each key of the file: a time and three values (the key's and
// two slopes) of each of its own keys, of which a jump makes two.
uint64_t most_bytes_per_key(bool rotates) {
  return rotates ? uint64_t{kMostPieces + 1} * (1 + 3 * 4) * sizeof(float)
                 : uint64_t{2} * (1 + 3 * 3) * sizeof(float);
}

Result<Channel> read_motion(Words& words, uint64_t memory, std::vector<std::string>& warnings) {
  const std::string_view motion = words.word();
  if (motion == "visibility") return read_visibility(words);
  if (motion != "transl" && motion != "rot" && motion != "scale") {
    return words.error(fmt::format("\"{}\" is no kind of keyframes", printable(motion)),
                       "write transl, rot, scale or visibility");
  }
  const bool rotates = motion == "rot";
  SINEW_TRY(const uint32_t count, words.count("keys", rotates ? 8 : 7));
  if (count < kLeastKeys) {
    return words.error(fmt::format("has {} keys, fewer than a spline needs", count),
                       fmt::format("give at least {}", kLeastKeys));
  }
  if (count > memory / most_bytes_per_key(rotates)) {
    return words.error(fmt::format("{} keys may take more than the memory limit", count),
                       "raise the memory limit");
  }
  Channel channel;
  if (rotates) {
    SINEW_TRY(const std::vector<RotationKey> keys, read_rotation_keys(words, count));
    warn_of_time_going_back(keys, words, warnings);
    channel = rotation_channel(keys);
  } else {
    SINEW_TRY(const std::vector<VectorKey> keys, read_vector_keys(words, count));
    warn_of_time_going_back(keys, words, warnings);
    channel = vector_channel(keys);
    channel.path = motion == "scale" ? ChannelPath::scale : ChannelPath::translation;
  }
  const auto is_finite = [](float value) { return std::isfinite(value); };
  if (!std::ranges::all_of(channel.values, is_finite)) {
    return words.error("the spline through the keys leaves the range of numbers",
                       "give keys that lie further apart in time");
  }
  return channel;
}

}  // namespace

Result<Keyframes> read_keyframes(Words& words, uint64_t memory,
                                 std::vector<std::string>& warnings) {
  Keyframes result;
  SINEW_TRY(result.name, words.name("the name of a transform"));
  SINEW_CHECKED(words.expect("{"));
  while (!words.next_is("}")) {
    if (words.at_end()) return words.expect("}").map([] { return Keyframes{}; });
    SINEW_TRY(Channel channel, read_motion(words, memory, warnings));
    const auto twice = std::ranges::find(result.channels, channel.path, &Channel::path);
    if (twice != result.channels.end()) {
      return words.error("has two sets of keys of one kind", "give one");
    }
    result.channels.push_back(std::move(channel));
  }
  words.word();
  return result;
}

}  // namespace sinew::aff
