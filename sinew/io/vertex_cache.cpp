#include "sinew/io/vertex_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/io/output_file.h"
#include "sinew/io/polygon/scene.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

static_assert(std::endian::native == std::endian::little, "little-endian floats are not turned");

constexpr char kPc2Magic[12] = "POINTCACHE2";
constexpr size_t kPc2Header = 32;
constexpr size_t kMddHeader = 8;
constexpr float kLongest = 1e7f;  // seconds

template <class T>
T value_at(std::string_view bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

uint32_t turned(uint32_t x) {
  return x << 24 | (x & 0xff00u) << 8 | (x >> 8 & 0xff00u) | x >> 24;
}

float big_endian_float(std::string_view bytes, size_t offset) {
  return std::bit_cast<float>(turned(value_at<uint32_t>(bytes, offset)));
}

tl::unexpected<Error> cache_error(const std::string& path, std::string element, std::string problem,
                                  std::string remedy = "export the cache again") {
  return fail(
      {ErrorKind::bad_input, path, std::move(element), std::move(problem), std::move(remedy)});
}

// Whether `samples` of `points` fit behind `header` bytes; warns of what is left then.
Result<void> check_size(const std::string& path, std::string_view bytes, size_t header,
                        int32_t points, int32_t samples, std::vector<std::string>& warnings) {
  if (points <= 0 || samples <= 0) {
    return cache_error(path, "header",
                       fmt::format("claims {} points and {} samples", points, samples));
  }
  const uint64_t count = static_cast<uint64_t>(points) * static_cast<uint64_t>(samples);
  const uint64_t held = bytes.size() > header ? (bytes.size() - header) / sizeof(vec3) : 0;
  if (count > held) {
    return cache_error(
        path, "",
        fmt::format("is cut off: it should hold {} samples of {} points, but ends in sample {}",
                    samples, points, held / static_cast<uint64_t>(points)));
  }
  const size_t end = header + count * sizeof(vec3);
  if (end < bytes.size()) {
    warnings.push_back(fmt::format("{} bytes after the last sample: ignored", bytes.size() - end));
  }
  return {};
}

Result<void> check_positions(const std::string& path, const VertexCache& cache) {
  const auto bad = std::find_if(cache.positions.begin(), cache.positions.end(), [](const vec3& p) {
    return !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  });
  if (bad == cache.positions.end()) return {};
  const auto index = static_cast<uint64_t>(bad - cache.positions.begin());
  return cache_error(path, fmt::format("sample {}", index / cache.points),
                     fmt::format("point {} is not finite", index % cache.points));
}

// Times at a fixed distance (seconds), from 0.
std::vector<float> even_times(int32_t samples, double distance) {
  std::vector<float> times;
  for (int32_t i = 0; i < samples; ++i) times.push_back(static_cast<float>(i * distance));
  return times;
}

bool rise(const std::vector<float>& times) {
  return std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
}

}  // namespace

Result<VertexCache> parse_pc2(std::string_view bytes, const std::string& path,
                              std::vector<std::string>& warnings) {
  if (bytes.size() < kPc2Header || std::memcmp(bytes.data(), kPc2Magic, sizeof(kPc2Magic)) != 0) {
    return cache_error(path, "header", "is no PC2 vertex cache", "give a PC2 file");
  }
  const auto version = value_at<int32_t>(bytes, 12);
  const auto points = value_at<int32_t>(bytes, 16);
  const auto start_frame = value_at<float>(bytes, 20);
  const auto sample_rate = value_at<float>(bytes, 24);
  const auto samples = value_at<int32_t>(bytes, 28);
  if (version != 1) {
    return cache_error(path, "header", fmt::format("version {} is not supported, 1 is", version));
  }
  if (!std::isfinite(start_frame) || !std::isfinite(sample_rate) || sample_rate <= 0.0f) {
    return cache_error(path, "header", "the frame range makes no sense");
  }
  SINEW_CHECKED(check_size(path, bytes, kPc2Header, points, samples, warnings));
  VertexCache cache;
  cache.points = static_cast<uint32_t>(points);
  cache.times = even_times(samples, static_cast<double>(sample_rate) / kCacheFps);
  if (cache.times.back() > kLongest || !rise(cache.times)) {
    return cache_error(path, "header", "its sample rate is absurd");
  }
  cache.positions.resize(size_t{cache.points} * cache.times.size());
  std::memcpy(cache.positions.data(), bytes.data() + kPc2Header,
              cache.positions.size() * sizeof(vec3));
  SINEW_CHECKED(check_positions(path, cache));
  return cache;
}

Result<VertexCache> parse_mdd(std::string_view bytes, const std::string& path,
                              std::vector<std::string>& warnings) {
  if (bytes.size() < kMddHeader) {
    return cache_error(path, "header", "is no MDD vertex cache", "give an MDD file");
  }
  const auto samples = static_cast<int32_t>(turned(value_at<uint32_t>(bytes, 0)));
  const auto points = static_cast<int32_t>(turned(value_at<uint32_t>(bytes, 4)));
  const size_t time_bytes = sizeof(float) * static_cast<size_t>(std::max(samples, 0));
  SINEW_CHECKED(check_size(path, bytes, kMddHeader + time_bytes, points, samples, warnings));
  VertexCache cache;
  cache.points = static_cast<uint32_t>(points);
  for (size_t at = kMddHeader; at < kMddHeader + time_bytes; at += sizeof(float)) {
    cache.times.push_back(big_endian_float(bytes, at));
    if (!(std::abs(cache.times.back()) <= kLongest)) {
      return cache_error(path, fmt::format("sample {}", cache.times.size() - 1),
                         fmt::format("is at {} s", cache.times.back()));
    }
  }
  if (!rise(cache.times)) {
    warnings.push_back("the times of the samples do not rise: taken as 24 samples a second");
    cache.times = even_times(samples, 1.0 / kCacheFps);
  }
  cache.positions.resize(size_t{cache.points} * cache.times.size());
  size_t at = kMddHeader + time_bytes;
  for (vec3& p : cache.positions) {
    for (int k = 0; k < 3; ++k, at += sizeof(float)) p[k] = big_endian_float(bytes, at);
  }
  SINEW_CHECKED(check_positions(path, cache));
  return cache;
}

bool is_vertex_cache(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".pc2" || extension == ".mdd";
}

Result<void> write_pc2_header(uint32_t points, uint32_t samples, OutputFile& out) {
  if (points > INT32_MAX || samples > INT32_MAX) {
    return fail({ErrorKind::usage, out.path(), "",
                 fmt::format("{} points and {} samples are too many for PC2", points, samples),
                 "split the mesh"});
  }
  const int32_t version = 1;
  const float start_frame = 0.0f, sample_rate = 1.0f;
  std::array<uint8_t, kPc2Header> header{};
  const auto put = [&](size_t offset, const auto& value) {
    std::memcpy(&header[offset], &value, sizeof value);
  };
  put(0, kPc2Magic);
  put(12, version);
  put(16, points);
  put(20, start_frame);
  put(24, sample_rate);
  put(28, samples);
  return out.write(header);
}

Result<Scene> load_vertex_cache(const std::string& base, const std::string& cache_path,
                                const LoadOptions& options) {
  SINEW_TRY(Scene scene, load_polygons(base, options));
  // The file and the positions made from it are in memory together.
  SINEW_TRY(const std::string bytes, read_file(cache_path, options.memory_limit / 2));
  const auto parse = extension_of(cache_path) == ".mdd" ? parse_mdd : parse_pc2;
  SINEW_TRY(VertexCache cache, parse(bytes, cache_path, scene.warnings));
  const size_t vertices = scene.meshes[0].positions.size();
  if (cache.points != vertices) {
    return cache_error(
        cache_path, "",
        fmt::format("has {} points, but {} has {} vertices", cache.points, base, vertices),
        "give the base mesh that the cache was made from");
  }
  set_keys(scene, std::move(cache.positions), std::move(cache.times), "cache");
  return scene;
}

void set_keys(Scene& scene, std::vector<vec3> key_positions, std::vector<float> times,
              const std::string& clip_name) {
  Mesh& mesh = scene.meshes[0];
  SINEW_CHECK(scene.meshes.size() == 1 && scene.nodes.size() == 1 && !times.empty());
  SINEW_CHECK(key_positions.size() == times.size() * mesh.positions.size());
  mesh.keys = static_cast<uint32_t>(times.size());
  mesh.key_positions = std::move(key_positions);
  mesh.normals.clear();
  if (mesh.texcoords[0].empty() && mesh.colors.empty()) mesh.corners.clear();

  Clip& clip = scene.clips.emplace_back();
  clip.name = clip_name;
  clip.start = times.front();
  clip.end = times.back();
  Channel& channel = clip.channels.emplace_back();
  channel.path = ChannelPath::cache_key;
  channel.width = 1;
  channel.times = std::move(times);
  for (uint32_t key = 0; key < mesh.keys; ++key) channel.values.push_back(static_cast<float>(key));
  scene.default_fps = kCacheFps;
  scene.default_frames =
      static_cast<int32_t>(std::min(1e9, std::round((clip.end - clip.start) * kCacheFps) + 1));
}

}  // namespace sinew
