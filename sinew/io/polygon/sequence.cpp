// Finds the files of a pattern, then tries a vertex cache (one topology, one mesh);
// if the topology changes, reads them again as one mesh a frame.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "sinew/io/obj/material.h"
#include "sinew/io/polygon/mesh.h"
#include "sinew/io/polygon/scene.h"
#include "sinew/io/polygon/sequence.h"
#include "sinew/io/vertex_cache.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostWarnings = 20;

struct Pattern {
  fs::path folder;
  std::string prefix, suffix;  // of the file name, around the number
  size_t digits = 0;           // at least; filled up with zeros
};

struct Frame {
  uint64_t number = 0;
  std::string path;
};

// "####" or "%04d" in the file name (at most 9 digits), the first one that is there.
std::optional<Pattern> parse_pattern(const std::string& text) {
  const fs::path path(text);
  const std::string name = path.filename().string();
  Pattern pattern{path.parent_path(), "", "", 0};
  size_t begin = name.find('#');
  size_t end = begin;
  if (begin != std::string::npos) {
    end = std::min(name.find_first_not_of('#', begin), name.size());
    pattern.digits = end - begin;
  } else {
    begin = name.find('%');
    if (begin == std::string::npos) return std::nullopt;
    end = name.find('d', begin);
    if (end == std::string::npos || end - begin > 3) return std::nullopt;
    const char* stop = name.data() + end;
    const auto read = std::from_chars(name.data() + begin + 1, stop, pattern.digits);
    if (end > begin + 1 && (read.ec != std::errc() || read.ptr != stop)) return std::nullopt;
    pattern.digits = std::max<size_t>(pattern.digits, 1);
    ++end;
  }
  if (pattern.digits > 9) return std::nullopt;
  pattern.prefix = name.substr(0, begin);
  pattern.suffix = name.substr(end);
  return pattern;
}

// The number that `name` has in the pattern's place; only the way the pattern would print it.
std::optional<uint64_t> number_of(const Pattern& pattern, const std::string& name) {
  if (name.size() < pattern.prefix.size() + pattern.suffix.size() + pattern.digits ||
      !name.starts_with(pattern.prefix) || !name.ends_with(pattern.suffix)) {
    return std::nullopt;
  }
  const std::string digits = name.substr(
      pattern.prefix.size(), name.size() - pattern.prefix.size() - pattern.suffix.size());
  const bool all_digits = digits.find_first_not_of("0123456789") == std::string::npos;
  if (!all_digits || digits.size() > 9) return std::nullopt;
  if (digits.size() > pattern.digits && digits[0] == '0') return std::nullopt;
  return std::stoull(digits);
}

Result<std::vector<Frame>> find_frames(const std::string& text, const Pattern& pattern) {
  std::vector<Frame> frames;
  std::error_code failed;
  const fs::path folder = pattern.folder.empty() ? fs::path(".") : pattern.folder;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (const auto number = number_of(pattern, name)) {
      frames.push_back({*number, (pattern.folder / name).string()});
    }
  }
  if (failed) {
    return fail({ErrorKind::bad_input, text, "", "its folder cannot be read: " + failed.message(),
                 "check the path"});
  }
  if (frames.empty()) {
    return fail({ErrorKind::bad_input, text, "", "no file matches this sequence",
                 "check the name and the number of digits"});
  }
  std::sort(frames.begin(), frames.end(),
            [](const Frame& a, const Frame& b) { return a.number < b.number; });
  return frames;
}

// Seconds of each frame; a missing frame's time stays free.
std::vector<float> frame_times(const std::vector<Frame>& frames) {
  std::vector<float> times;
  for (const Frame& frame : frames) {
    const auto since_first = static_cast<double>(frame.number - frames[0].number);
    times.push_back(static_cast<float>(since_first / kCacheFps));
  }
  return times;
}

void warn_of_gaps(const std::vector<Frame>& frames, Scene& scene) {
  const uint64_t missing = frames.back().number - frames[0].number + 1 - frames.size();
  if (missing == 0) return;
  size_t at = 1;
  while (frames[at].number == frames[at - 1].number + 1) ++at;
  scene.warnings.push_back(
      fmt::format("the sequence has gaps: {} frames are missing, the first after {}", missing,
                  fs::path(frames[at - 1].path).filename().string()));
}

bool same_topology(const PolygonModel& model, const Mesh& mesh) {
  if (model.positions.size() != mesh.positions.size() ||
      model.triangle_part.size() != mesh.triangles.size()) {
    return false;
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const PolygonCorner* corner = &model.corners[3 * i];
    if (uvec3(corner[0].position, corner[1].position, corner[2].position) != mesh.triangles[i]) {
      return false;
    }
  }
  return true;
}

tl::unexpected<Error> too_large(const std::string& pattern) {
  return fail({ErrorKind::bad_input, pattern, "", "the sequence takes more than the memory limit",
               "raise the memory limit or load fewer frames"});
}

// Adds what the first file's warnings do not say, once for all files.
void add_warnings_of(const Frame& frame, const std::vector<std::string>& warnings,
                     std::set<std::string>& known, Scene& scene) {
  for (const std::string& warning : warnings) {
    if (!known.insert(warning).second || known.size() > kMostWarnings) continue;
    scene.warnings.push_back(fs::path(frame.path).filename().string() + ": " + warning);
  }
}

// Nothing if the topology changes.
Result<std::optional<Scene>> load_as_cache(const std::string& pattern,
                                           const std::vector<Frame>& frames,
                                           const LoadOptions& options) {
  SINEW_TRY(Scene scene, load_polygons(frames[0].path, options));
  const Mesh& mesh = scene.meshes[0];
  const uint64_t bytes = frames.size() * mesh.positions.size() * sizeof(vec3);
  if (bytes > options.memory_limit) return too_large(pattern);
  std::vector<vec3> keys = mesh.positions;
  std::set<std::string> known(scene.warnings.begin(), scene.warnings.end());
  for (size_t i = 1; i < frames.size(); ++i) {
    SINEW_TRY(const PolygonModel model, read_polygons(frames[i].path, options));
    if (!same_topology(model, mesh)) return std::optional<Scene>();
    add_warnings_of(frames[i], model.warnings, known, scene);
    keys.reserve(frames.size() * mesh.positions.size());
    keys.insert(keys.end(), model.positions.begin(), model.positions.end());
  }
  set_keys(scene, std::move(keys), frame_times(frames), "sequence");
  return std::optional<Scene>(std::move(scene));
}

// Node `index` shows from its own time to the next one's.
Channel visibility_channel(uint32_t index, const std::vector<float>& times) {
  Channel channel;
  channel.node = index;
  channel.path = ChannelPath::visibility;
  channel.interpolation = Interpolation::step;
  channel.width = 1;
  if (index > 0) {
    channel.times.push_back(times[0]);
    channel.values.push_back(0.0f);
  }
  channel.times.push_back(times[index]);
  channel.values.push_back(1.0f);
  if (index + 1 < times.size()) {
    channel.times.push_back(times[index + 1]);
    channel.values.push_back(0.0f);
  }
  return channel;
}

Result<Scene> load_frame_by_frame(const std::string& pattern, const std::vector<Frame>& frames,
                                  const LoadOptions& options) {
  Scene scene;
  ObjMaterials materials(scene, frames[0].path, options);
  const std::vector<float> times = frame_times(frames);
  Clip clip;
  clip.name = "sequence";
  clip.end = times.back();
  uint64_t bytes = 0;
  std::set<std::string> known;
  for (uint32_t i = 0; i < frames.size(); ++i) {
    SINEW_TRY(const PolygonModel model, read_polygons(frames[i].path, options));
    bytes += model.bytes();
    if (bytes > options.memory_limit) return too_large(pattern);
    SINEW_TRY(const std::vector<uint32_t> part_materials, materials.of_parts(model));
    std::vector<std::string> warnings = model.warnings;
    scene.meshes.push_back(make_polygon_mesh(model, part_materials, warnings));
    if (i == 0) {
      scene.warnings.insert(scene.warnings.end(), warnings.begin(), warnings.end());
      known.insert(warnings.begin(), warnings.end());
    } else {
      add_warnings_of(frames[i], warnings, known, scene);
    }
    Node& node = scene.nodes.emplace_back();
    node.name = scene.meshes.back().name = fs::path(frames[i].path).stem().string();
    node.mesh = static_cast<int32_t>(i);
    node.visible = i == 0;
    clip.channels.push_back(visibility_channel(i, times));
  }
  scene.clips.push_back(std::move(clip));
  scene.default_fps = kCacheFps;
  scene.default_frames =
      static_cast<int32_t>(frames.back().number - frames[0].number + 1);  // at most 9 digits
  list_objects(scene);
  return scene;
}

}  // namespace

bool is_sequence(const std::string& pattern) {
  return parse_pattern(pattern).has_value();
}

Result<Scene> load_sequence(const std::string& text, const LoadOptions& options) {
  const std::optional<Pattern> pattern = parse_pattern(text);
  if (!pattern) {
    return fail(
        {ErrorKind::bad_input, text, "", "is no sequence", "write #### or %04d in its name"});
  }
  SINEW_TRY(const std::vector<Frame> frames, find_frames(text, *pattern));
  SINEW_TRY(std::optional<Scene> cached, load_as_cache(text, frames, options));
  if (!cached) {
    SINEW_TRY(cached, load_frame_by_frame(text, frames, options));
  }
  warn_of_gaps(frames, *cached);
  return std::move(*cached);
}

}  // namespace sinew
