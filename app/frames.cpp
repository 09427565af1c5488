#include "app/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "sinew/scene/sample.h"

namespace sinew::app {
namespace {

constexpr int kMaxFrame = 1'000'000;
constexpr double kDefaultFps = 24.0;

struct Range {
  int first = 0;
  int last = 0;
  int step = 1;
};

tl::unexpected<Error> bad_frames(std::string_view item, std::string problem,
                                 std::string remedy = "write 7, 1-100, 1,3,5-9 or 1-100x2") {
  return fail({ErrorKind::usage, "", fmt::format("frames '{}'", item), std::move(problem),
               std::move(remedy)});
}

// Takes a whole number off the front of `text`; nothing if there is none or it is too large.
bool take_number(std::string_view& text, int& number) {
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc() || number < 0) return false;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return true;
}

bool take(std::string_view& text, std::string_view token) {
  if (!text.starts_with(token)) return false;
  text.remove_prefix(token.size());
  return true;
}

// Other programs write steps and ranges differently; say how they are written here. `rest` is what
// follows the part that was understood.
tl::unexpected<Error> explain(std::string_view item, const Range& range, bool is_range,
                              std::string_view rest) {
  for (const char* separator : {"..", ":", "/", "@"}) {
    int number = 0;
    std::string_view tail = rest;
    if (!take(tail, separator) || !take_number(tail, number) || !tail.empty()) continue;
    if (is_range) {
      return bad_frames(item, fmt::format("steps are not written with '{}'", separator),
                        fmt::format("write {}-{}x{}", range.first, range.last, number));
    }
    return bad_frames(item, fmt::format("ranges are not written with '{}'", separator),
                      fmt::format("write {}-{}", range.first, number));
  }
  return bad_frames(item, "is not a frame or a range of frames");
}

Result<Range> parse_range(std::string_view item) {
  Range range;
  std::string_view rest = item;
  if (rest.empty()) return bad_frames(item, "a frame is missing");
  if (!take_number(rest, range.first)) {
    return bad_frames(item, "is not a frame or a range of frames");
  }
  range.last = range.first;
  const bool is_range = take(rest, "-");
  if (is_range && !take_number(rest, range.last)) {
    return bad_frames(item, "has no last frame", fmt::format("write {}-100", range.first));
  }
  if (is_range && take(rest, "x") && !take_number(rest, range.step)) {
    return bad_frames(item, "has no step after the x",
                      fmt::format("write {}-{}x2", range.first, range.last));
  }
  if (!rest.empty()) return explain(item, range, is_range, rest);
  if (range.first < 1) return bad_frames(item, "frames count from 1");
  if (range.step < 1) return bad_frames(item, "the step must be at least 1");
  if (range.last < range.first) {
    return bad_frames(item, "the last frame comes before the first",
                      fmt::format("write {}-{}", range.last, range.first));
  }
  if (range.last > kMaxFrame) {
    return bad_frames(item, fmt::format("frames end at {}", kMaxFrame));
  }
  return range;
}

}  // namespace

Result<std::vector<int>> parse_frames(std::string_view text) {
  std::vector<int> frames;
  std::string_view rest = text;
  while (true) {
    const size_t comma = rest.find(',');
    SINEW_TRY(const Range range, parse_range(rest.substr(0, comma)));
    for (int frame = range.first; frame <= range.last; frame += range.step) frames.push_back(frame);
    if (frames.size() > static_cast<size_t>(kMaxFrame)) {
      return bad_frames(text, fmt::format("means more than {} frames", kMaxFrame));
    }
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

Timeline timeline_of(const Scene& scene, int clip, double fps) {
  Timeline timeline;
  const bool own_rate = fps <= 0.0;
  if (!own_rate) {
    timeline.fps = fps;
  } else {
    timeline.fps = scene.default_fps > 0.0 ? scene.default_fps : kDefaultFps;
  }
  if (clip == kRestPose) return timeline;
  const Clip& chosen = scene.clips[static_cast<size_t>(clip)];
  timeline.start = chosen.start;
  timeline.end = chosen.end;
  // A thousandth of a frame forgives lengths that floating point made a little too long.
  const double length = std::ceil((chosen.end - chosen.start) * timeline.fps - 1e-3);
  timeline.frames = static_cast<int>(std::clamp(length, 1.0, double{kMaxFrame}));
  if (own_rate && clip == 0 && scene.default_frames > 0) {
    timeline.frames = std::min(scene.default_frames, kMaxFrame);
  }
  return timeline;
}

double frame_time(const Timeline& timeline, int frame) {
  return timeline.start + (frame - 1) / timeline.fps;
}

}  // namespace sinew::app
